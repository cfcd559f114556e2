"""Rows of the database as what goes over the wire."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from rumu.database.tables import Annotation, Collection, Job, Person, Task, Tour, Work
from rumu.gallery.originals import VERSION
from rumu.studio.attempts import Shown


def both(row: Any, name: str) -> dict[str, str]:
    """A pair of columns as one text in two languages."""
    return {"zh": getattr(row, f"{name}_zh"), "en": getattr(row, f"{name}_en")}


def file_address(work: Work, kind: str) -> str:
    """The address of a file of a work; it changes when the file does, so that it may be kept for ever."""
    return f"/api/works/{work.id}/files/{kind}?v={file_version(work)}"


def file_version(work: Work) -> str:
    """Changes when any file of a work may."""
    return f"{work.digest[:8]}{int(work.changed.timestamp()):x}-{VERSION}"


def work_card(work: Work) -> dict[str, Any]:
    """See shapes.WorkSummary."""
    return {
        "id": work.id,
        **{name: both(work, name) for name in ("title", "hand", "period")},
        "character": work.character,
        "script": work.script,
        "dynasty": work.dynasty,
        "collection": work.collection_id,
        "kind": work.kind,
        "height_source": work.height_source,
        "width": work.width,
        "height": work.height,
        "thumb": file_address(work, "thumb"),
        "thumb_normals": file_address(work, "thumb-normals"),
    }


_FILES = {
    **{name: name for name in ("picture", "albedo", "normals", "mask", "glb", "stl", "ply")},
    "normals16": "normals-16",
    "height": "height16",
    "heights": "heights",
}


def work_facts(
    work: Work,
    *,
    collection: Collection,
    annotations: Sequence[Annotation],
    neighbours: tuple[str | None, str | None],
) -> dict[str, Any]:
    """See shapes.WorkRead."""
    files = {name: file_address(work, kind) for name, kind in _FILES.items()}
    return work_card(work) | {
        "material": both(work, "material"),
        "source": work.source,
        "licence": work.licence,
        "attribution": work.attribution,
        "collection_title": both(collection, "title"),
        "files": files | {"manifest": f"/iiif/works/{work.id}/manifest.json"},
        "annotations": [annotation_facts(one) for one in annotations],
        "spacing": work.spacing,
        "created": work.created,
        "previous": neighbours[0],
        "next": neighbours[1],
    }


def annotation_facts(row: Annotation) -> dict[str, Any]:
    """See shapes.AnnotationRead."""
    return {"id": row.id, "x": row.x, "y": row.y, "title": both(row, "title"), "text": both(row, "text")}


def collection_facts(row: Collection, count: int) -> dict[str, Any]:
    """See shapes.CollectionRead."""
    told = {"id": row.id, "source": row.source, "licence": row.licence, "works": count}
    return told | {"title": both(row, "title"), "note": both(row, "note")}


def tour_facts(row: Tour) -> dict[str, Any]:
    """See shapes.TourRead."""
    steps = [
        {
            "work": step["work"],
            "view": step.get("view", ""),
            **{
                name: {language: step.get(f"{name}_{language}", "") for language in ("zh", "en")}
                for name in ("title", "text")
            },
        }
        for step in row.steps
    ]
    return {"id": row.id, "title": both(row, "title"), "steps": steps}


def person_facts(row: Person) -> dict[str, Any]:
    """See shapes.PersonRead."""
    return {
        "id": row.id,
        "name": row.name,
        "role": row.role,
        "language": row.language,
        "active": row.active,
    }


def writer(row: Person | None) -> dict[str, str] | None:
    """Id and name."""
    return None if row is None else {"id": row.id, "name": row.name}


def attempt_facts(shown: Shown, *, residual: dict[str, Any] | None = None) -> dict[str, Any]:
    """See studio_shapes.AttemptRead."""
    attempt = shown.attempt
    return {
        "id": attempt.id,
        "work": work_card(shown.work),
        "person": writer(shown.person),
        "kind": attempt.kind,
        "grid": attempt.grid,
        "created": attempt.created,
        "task": attempt.task_id,
        "picture": f"/api/attempts/{attempt.id}/picture",
        "strokes": attempt.strokes and f"/api/attempts/{attempt.id}/strokes",
        "mark": attempt.mark | {"residual": residual},
        "teacher_marks": [
            {"teacher": person.name, "mark": mark.mark, "note": mark.note}
            for person, mark in shown.teacher_marks
        ],
        "simulated": attempt.kind == "simulated",
    }


def task_facts(task: Task, work: Work) -> dict[str, Any]:
    """See studio_shapes.TaskRead."""
    return {
        "id": task.id,
        "class_id": task.class_id,
        "work": work_card(work),
        "title": task.title,
        "note": task.note,
        "due": task.due,
        "created": task.created,
    }


def job_facts(job: Job) -> dict[str, Any]:
    """See studio_shapes.JobRead."""
    names = ("id", "kind", "state", "done", "total", "message", "result")
    error = both(job, "error") if job.error_en or job.error_zh else None
    return {name: getattr(job, name) for name in names} | {"error": error}
