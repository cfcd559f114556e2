"""Annotations on points of a work, in both languages."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from typing import Any

from sqlalchemy import func, select
from sqlalchemy.orm import Session

from rumu.database.tables import Annotation
from rumu.errors import GalleryError
from rumu.gallery.catalog import work
from rumu.gallery.store import Gallery

TEXTS = ("title_zh", "title_en", "text_zh", "text_en")
_MAX_LENGTHS = {"title_zh": 200, "title_en": 200, "text_zh": 5000, "text_en": 5000}


def annotations_of(gallery: Gallery, work_id: str) -> tuple[Annotation, ...]:
    """The annotations of a work, in order. Raises GalleryError when there is no such work."""
    work(gallery, work_id)
    with gallery.database.reading() as session:
        rows = select(Annotation).where(Annotation.work_id == work_id)
        return tuple(session.scalars(rows.order_by(Annotation.position, Annotation.id)))


def add_annotation(
    gallery: Gallery, work_id: str, facts: Mapping[str, Any], *, author: str | None = None
) -> Annotation:
    """Add an annotation to a point of a work, after the existing ones.

    facts: x and y (fractions of the picture, origin top left), title_zh, title_en, text_zh, text_en; at least
        one text. author: id of a person.
    Raises GalleryError for other facts, or an unknown work.
    """
    _check(facts)
    if not {"x", "y"} <= set(facts):
        raise GalleryError(f"expected x and y of an annotation, got {', '.join(sorted(facts)) or 'nothing'}")
    _require_text({name: facts.get(name, "") for name in TEXTS})
    work(gallery, work_id)
    with gallery.database.writing() as session:
        after_last = select(func.coalesce(func.max(Annotation.position) + 1, 0))
        position = session.scalar(after_last.where(Annotation.work_id == work_id))
        new = Annotation(work_id=work_id, author_id=author, **{"position": position} | dict(facts))
        session.add(new)
        session.flush()
        return new


def change_annotation(
    gallery: Gallery, annotation_id: str, facts: Mapping[str, Any], *, of: str | None = None
) -> Annotation:
    """Change some facts of an annotation. of: the work that it must belong to.

    Raises GalleryError for other facts, or an unknown annotation.
    """
    _check(facts)
    with gallery.database.writing() as session:
        row = _find(session, annotation_id, of)
        for name, value in facts.items():
            setattr(row, name, value)
        _require_text({name: getattr(row, name) for name in TEXTS})
        return row


def delete_annotation(gallery: Gallery, annotation_id: str, *, of: str | None = None) -> None:
    """Delete an annotation. of: the work that it must belong to. Raises GalleryError when there is none."""
    with gallery.database.writing() as session:
        session.delete(_find(session, annotation_id, of))


def _find(session: Session, annotation_id: str, of: str | None) -> Annotation:
    row = session.get(Annotation, annotation_id)
    if row is None or of not in (None, row.work_id):
        raise GalleryError(f"no annotation {annotation_id!r}" + (f" of work {of!r}" if of else ""))
    return row


def _check(facts: Mapping[str, Any]) -> None:
    check_facts(facts, {"x", "y", "position", *TEXTS}, _MAX_LENGTHS)
    for name in ("x", "y"):
        value = facts.get(name, 0.0)
        if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
            raise GalleryError(f"expected {name} as a number, got {value!r}")
        if not 0 <= value <= 1:
            raise GalleryError(f"expected {name} as a fraction of the picture, 0 to 1, got {value}")


def check_facts(facts: Mapping[str, Any], known: Collection[str], max_lengths: Mapping[str, int]) -> None:
    """Raise GalleryError for facts that are not known, and for values of another type or length."""
    unknown = sorted(set(facts) - set(known))
    if unknown:
        raise GalleryError(f"expected facts among {', '.join(sorted(known))}, got {', '.join(unknown)}")
    check_texts(facts, max_lengths)
    if not isinstance(facts.get("position", 0), int):
        raise GalleryError(f"expected position as a whole number, got {facts['position']!r}")


def check_texts(facts: Mapping[str, Any], max_lengths: Mapping[str, int]) -> None:
    """Raise GalleryError for a value that is no text or is too long. max_lengths: in characters, by name."""
    for name, most in max_lengths.items():
        text = facts.get(name, "")
        if not isinstance(text, str) or len(text) > most:
            got = f"{len(text)} characters" if isinstance(text, str) else repr(text)
            raise GalleryError(f"expected {name} as a text of at most {most} characters, got {got}")


def _require_text(texts: Mapping[str, str]) -> None:
    if not any(text.strip() for text in texts.values()):
        raise GalleryError("expected an annotation to say something, got four empty texts")
