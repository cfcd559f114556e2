"""What a later attempt changed against the one before, from the marks that are stored."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from sqlalchemy import select
from sqlalchemy.orm import Session

from rumu.assessment.progress import NumberChange, compare_attempts
from rumu.database.tables import Attempt, Work
from rumu.report.progress_words import describe_fault, describe_mark
from rumu.report.wording import PARTS
from rumu.values import Remark


@dataclass(frozen=True, slots=True)
class StoredMark:
    """A mark as it is stored with an attempt.

    untold: None in marks of versions that did not keep them. framed: whether the picture is the cell that was
    written in: the master's own, or "printed", the cell of a sheet.
    """

    score: float | None
    parts: Mapping[str, float]
    remarks: tuple[Remark, ...]
    untold: tuple[Remark, ...] | None
    framed: bool | str

    @classmethod
    def of(cls, facts: Mapping[str, Any]) -> StoredMark:
        """From `marking.mark_facts`, of this version or an older one."""
        untold = facts.get("untold")
        return cls(
            facts.get("score"),
            {part["name"]: part["score"] for part in facts.get("parts", ())},
            _remarks(facts.get("remarks", ())),
            None if untold is None else _remarks(untold),
            facts.get("framed") or False,
        )


def previous_attempt(session: Session, attempt: Attempt, *, person_id: str, work_id: str) -> Attempt | None:
    """Return a person's last marked attempt at a work before this one, which may not be stored."""
    wanted = select(Attempt).where(
        Attempt.person_id == person_id,
        Attempt.work_id == work_id,
        Attempt.score.is_not(None),
        Attempt.created <= attempt.created,
    )
    if attempt.id is not None:
        wanted = wanted.where(Attempt.id != attempt.id)
    return session.scalars(wanted.order_by(Attempt.created.desc(), Attempt.id).limit(1)).first()


def progress_of(
    session: Session, attempt: Attempt, *, person_id: str | None, work: Work
) -> dict[str, Any] | None:
    """Return what an attempt changed against the one before; None where there is none, or no mark.

    attempt: may be one that is not stored. person_id: of its writer.
    """
    if person_id is None or attempt.mark.get("score") is None:
        return None
    before = previous_attempt(session, attempt, person_id=person_id, work_id=work.id)
    return None if before is None else progress_facts(before, attempt, character=work.character)


def progress_facts(before: Attempt, after: Attempt, *, character: str) -> dict[str, Any] | None:
    """Return what changed from one attempt to a later one, as values of JSON; None where one has no mark.

    remark: index of the fault among the later attempt's remarks, None where it is not told there.
    """
    first, second = StoredMark.of(before.mark), StoredMark.of(after.mark)
    same_frame = bool(first.framed) and first.framed == second.framed
    progress = compare_attempts(first, second, framed=same_frame)
    if progress is None:
        return None
    return {
        "previous": {"id": before.id, "created": before.created},
        "mark": _number_facts(progress.mark) | describe_mark(progress.mark)._asdict(),
        "parts": [
            {"name": name} | PARTS[name][0]._asdict() | _number_facts(change)
            for name, change in progress.parts.items()
            if name in PARTS
        ],
        "faults": [
            {
                "status": fault.status,
                "kind": fault.remark.kind,
                "stroke": fault.remark.stroke,
                "remark": next((k for k, r in enumerate(second.remarks) if r is fault.after), None),
            }
            | describe_fault(fault, character=character)._asdict()
            for fault in progress.faults
        ],
    }


def _number_facts(change: NumberChange) -> dict[str, Any]:
    return {"before": change.before, "after": change.after, "change": change.change}


def _remarks(stored: Sequence[Mapping[str, Any]]) -> tuple[Remark, ...]:
    return tuple(
        Remark(
            kind=facts.get("kind", ""),
            size=float(facts.get("size") or 0.0),
            unit=facts.get("unit", ""),
            severity=float(facts.get("severity") or 0.0),
            region=facts.get("region"),
            zh=facts.get("zh", ""),
            en=facts.get("en", ""),
            outline=_lines(facts.get("outline")),
            master_outline=_lines(facts.get("master_outline")),
            stroke=facts.get("stroke"),
        )
        for facts in stored
    )


def _lines(stored: Sequence[Sequence[Sequence[float]]] | None) -> tuple[tuple[tuple[float, float], ...], ...]:
    return tuple(tuple((float(x), float(y)) for x, y in line) for line in stored or ())
