"""Seeding of an empty gallery with the starter works, so that there is something to look at and to copy."""

from __future__ import annotations

import json
from importlib import resources
from typing import Any

from sqlalchemy import select

from rumu.database.tables import Annotation, Tour, Work
from rumu.gallery.assets import picture_key
from rumu.gallery.metadata import (
    CollectionMetadata,
    StoredFiles,
    WorkMetadata,
    insert_rows,
    insert_works,
    work_digest,
    work_row,
)
from rumu.gallery.starter import StarterWork, starter_works
from rumu.gallery.store import Gallery
from rumu.values import Bilingual

STARTER = CollectionMetadata(
    id="starter",
    title=Bilingual(zh="入門碑帖", en="Starter gallery"),
    note=Bilingual(
        zh="三十件作品：六個字、五種書體，由可自由使用的字型繪成，並非原跡照片。",
        en="Thirty works: six characters in five scripts, drawn from freely usable fonts; not "
        "photographs of originals.",
    ),
    source="fonts, named with each work",
    licence="named with each work",
)
SIDE = 512  # pixels of a starter picture


def add_starter_works(gallery: Gallery) -> bool:
    """Add the starter works, annotations and tours to a gallery without works; whether it had none.

    Two processes may do so at the same time: rows that exist stay as they are.
    """
    with gallery.database.reading() as session:
        if session.scalar(select(Work.id).limit(1)) is not None:
            return False
    rows = [_work_row(gallery, work, position) for position, work in enumerate(starter_works())]
    file = resources.files("rumu.gallery").joinpath("starter_tours.json")
    texts = json.loads(file.read_text(encoding="utf-8"))
    annotations = [_split_languages(one) | {"position": n} for n, one in enumerate(texts["annotations"])]
    tours = [
        _split_languages(one) | {"steps": [_split_languages(step) for step in one["steps"]]}
        for one in texts["tours"]
    ]
    with gallery.database.writing() as session:
        insert_works(session, STARTER, rows)
        insert_rows(session, Annotation, [row | {"work_id": row.pop("work")} for row in annotations])
        insert_rows(session, Tour, tours)
    return True


def _work_row(gallery: Gallery, work: StarterWork, position: int) -> dict[str, Any]:
    data = work.path.read_bytes()
    key = picture_key(data, suffix=".png")
    gallery.store.write(key, data)
    names = ("title", "character", "script", "hand", "period", "material", "source", "licence", "attribution")
    metadata = WorkMetadata(
        **{name: getattr(work, name) for name in names},
        dynasty="contemporary",
        origin=work.path.name,
    )
    files = StoredFiles(picture=key, digest=work_digest(data, work.id), width=SIDE, height=SIDE)
    return work_row(metadata, files, work_id=work.id, collection=STARTER, position=position)


def _split_languages(entry: dict[str, Any]) -> dict[str, Any]:
    """A JSON entry as columns: {"title": {"zh", "en"}} becomes title_zh and title_en."""
    row = {name: value for name, value in entry.items() if name not in ("title", "text")}
    for name in ("title", "text"):
        if name in entry:
            row |= {f"{name}_{language}": entry[name][language] for language in ("zh", "en")}
    return row
