"""An empty gallery begins with the starter works, so that there is something to see and to copy at once."""

from __future__ import annotations

import json
from importlib import resources
from typing import Any

from sqlalchemy import select

from rumu.database.tables import Annotation, Tour, Work
from rumu.gallery.entries import Entry, Kept, Room, digest_of, put_collection, put_others, put_works, work_row
from rumu.gallery.gallery import Gallery
from rumu.gallery.originals import picture_key
from rumu.gallery.works import Work as StarterWork
from rumu.gallery.works import starter_works
from rumu.values import Bilingual

STARTER = Room(
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


def put_starter(gallery: Gallery) -> bool:
    """Put the starter works, annotations and tours into a gallery without works; whether that was needed.

    Two processes may do so at once: what is there already stays as it is.
    """
    with gallery.database.reading() as session:
        if session.scalar(select(Work.id).limit(1)) is not None:
            return False
    rows = [_kept(gallery, work, position) for position, work in enumerate(starter_works())]
    said = json.loads(
        resources.files("rumu.gallery").joinpath("starter_tours.json").read_text(encoding="utf-8")
    )
    with gallery.database.writing() as session:
        put_collection(session, STARTER)
        put_works(session, rows)
        put_others(session, Annotation, [_annotation(n, one) for n, one in enumerate(said["annotations"])])
        put_others(session, Tour, [_tour(one) for one in said["tours"]])
    return True


def _kept(gallery: Gallery, work: StarterWork, position: int) -> dict[str, Any]:
    data = work.path.read_bytes()
    key = picture_key(data, suffix=".png")
    gallery.store.write(key, data)
    entry = Entry(
        title=work.title,
        character=work.character,
        script=work.script,
        hand=work.hand,
        dynasty="contemporary",
        period=work.period,
        material=work.material,
        source=work.source,
        licence=work.licence,
        attribution=work.attribution,
        origin=work.path.name,
    )
    kept = Kept(picture=key, digest=digest_of(data, work.id), width=SIDE, height=SIDE)
    return work_row(entry, kept, work_id=work.id, room=STARTER, position=position)


def _texts(one: dict[str, Any]) -> dict[str, Any]:
    """A JSON entry as columns: {"title": {"zh", "en"}} becomes title_zh and title_en."""
    row = {name: value for name, value in one.items() if name not in ("title", "text")}
    for name in ("title", "text"):
        if name in one:
            row |= {f"{name}_{language}": one[name][language] for language in ("zh", "en")}
    return row


def _annotation(number: int, one: dict[str, Any]) -> dict[str, Any]:
    row = _texts(one)
    return row | {"work_id": row.pop("work"), "position": number}


def _tour(one: dict[str, Any]) -> dict[str, Any]:
    return _texts(one) | {"steps": [_texts(step) for step in one["steps"]]}
