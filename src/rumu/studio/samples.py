"""The simulated samples as attempts, so that there is something to judge on the first day; always
labelled."""

from __future__ import annotations

from typing import TYPE_CHECKING

from sqlalchemy import select

from rumu.database.tables import Attempt, Work
from rumu.gallery.gallery import Gallery
from rumu.gallery.starter import Sample, starter_samples
from rumu.studio import worker
from rumu.studio.attempts import keep

if TYPE_CHECKING:
    from collections.abc import Callable

    from rumu.studio.place import Place


def waiting(gallery: Gallery) -> list[tuple[Sample, Work]]:
    """The samples that are not attempts yet and whose work is in the gallery."""
    with gallery.database.reading() as session:
        there = set(session.scalars(select(Attempt.id).where(Attempt.kind == "simulated")))
        works = {work.id: work for work in session.scalars(select(Work))}
    return [
        (sample, works[sample.work])
        for sample in starter_samples()
        if attempt_id(sample) not in there and sample.work in works
    ]


def put_samples(gallery: Gallery, *, place: Place, advance: Callable[[int, int], object]) -> int:
    """Mark the samples that are missing and keep them; how many there were. Doing it twice changes
    nothing."""
    found = waiting(gallery)
    for done, (sample, work) in enumerate(found):
        advance(done, len(found))
        marked = worker.mark(
            place,
            data=sample.path.read_bytes(),
            work_id=work.id,
            digest=work.digest,
            script=work.script,
        )
        keep(
            gallery,
            marked,
            work_id=work.id,
            person_id=None,
            kind="simulated",
            attempt_id=attempt_id(sample),
        )
    return len(found)


def attempt_id(sample: Sample) -> str:
    """Fixed by the sample: it is never put in twice."""
    return f"simulated-{sample.id}"
