"""Guided tours: a sequence of works, each in one view of the viewer, with a text in both languages."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from sqlalchemy import func, select
from sqlalchemy.orm import Session

from rumu.database.tables import Tour, Work
from rumu.errors import GalleryError
from rumu.gallery.annotations import check_facts, check_texts
from rumu.gallery.store import Gallery

MOST_STEPS = 100
_STEP = ("work", "view", "title_zh", "title_en", "text_zh", "text_en")
_MAX_LENGTHS = {"work": 64, "view": 1000, "title_zh": 200, "title_en": 200, "text_zh": 5000, "text_en": 5000}


def tours(gallery: Gallery) -> tuple[Tour, ...]:
    """All tours, in order."""
    with gallery.database.reading() as session:
        return tuple(session.scalars(select(Tour).order_by(Tour.position, Tour.id)))


def tour(gallery: Gallery, tour_id: str) -> Tour:
    """The tour with this id. Raises GalleryError when there is none."""
    with gallery.database.reading() as session:
        return _find(session, tour_id)


def add_tour(gallery: Gallery, facts: Mapping[str, Any], *, author: str | None = None) -> Tour:
    """Add a tour after the others.

    facts: title_zh, title_en, and steps, a list of {work, view, title_zh, title_en, text_zh, text_en}; view
        is a permalink's query string. author: id of a person.
    Raises GalleryError for other facts, and for steps through unknown works.
    """
    _require_title(facts.get("title_zh", ""), facts.get("title_en", ""))
    with gallery.database.writing() as session:
        after_last = session.scalar(select(func.coalesce(func.max(Tour.position) + 1, 0)))
        defaults = {"position": after_last, "title_zh": "", "title_en": ""}
        new = Tour(author_id=author, **defaults | _check(session, facts))
        session.add(new)
        session.flush()
        return new


def change_tour(gallery: Gallery, tour_id: str, facts: Mapping[str, Any]) -> Tour:
    """Change some facts of a tour. Raises GalleryError as `add_tour`, and when there is none."""
    with gallery.database.writing() as session:
        row = _find(session, tour_id)
        for name, value in _check(session, facts).items():
            setattr(row, name, value)
        _require_title(row.title_zh, row.title_en)
        return row


def delete_tour(gallery: Gallery, tour_id: str) -> None:
    """Delete a tour. Raises GalleryError when there is none."""
    with gallery.database.writing() as session:
        session.delete(_find(session, tour_id))


def _find(session: Session, tour_id: str) -> Tour:
    row = session.get(Tour, tour_id)
    if row is None:
        raise GalleryError(f"no tour {tour_id!r} in the gallery")
    return row


def _check(session: Session, facts: Mapping[str, Any]) -> dict[str, Any]:
    """The facts with complete steps. Raises GalleryError for others, and for steps through unknown works."""
    check_facts(facts, {"title_zh", "title_en", "steps", "position"}, {"title_zh": 200, "title_en": 200})
    if "steps" not in facts:
        return dict(facts)
    steps = facts["steps"]
    if not isinstance(steps, Sequence) or isinstance(steps, str) or len(steps) > MOST_STEPS:
        raise GalleryError(f"expected steps as a list of at most {MOST_STEPS}, got {type(steps).__name__}")
    complete = [_complete_step(step) for step in steps]
    ids = {step["work"] for step in complete}
    missing = sorted(ids - set(session.scalars(select(Work.id).where(Work.id.in_(ids)))))
    if missing:
        raise GalleryError(f"expected steps through works of the gallery, there is no {', '.join(missing)}")
    return dict(facts) | {"steps": complete}


def _require_title(*titles: Any) -> None:
    if not any(str(title).strip() for title in titles):
        raise GalleryError("expected a tour to have a title, got none")


def _complete_step(step: Any) -> dict[str, str]:
    if not isinstance(step, Mapping) or not set(step) <= set(_STEP) or not step.get("work"):
        raise GalleryError(f"expected a step with a work and {', '.join(_STEP[1:])}, got {step!r:.200}")
    check_texts(step, _MAX_LENGTHS)
    return {name: step.get(name, "") for name in _STEP}
