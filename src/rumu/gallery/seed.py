"""Seeding of an empty gallery with the starter works, so that there is something to look at and to copy."""

from __future__ import annotations

import json
import zipfile
from importlib import resources
from pathlib import Path
from typing import Any

from sqlalchemy import select

from rumu.database.tables import Annotation, Tour, Work
from rumu.gallery.assets import capture_key, folder_digest, picture_key, store_files, surface_key
from rumu.gallery.metadata import (
    CollectionMetadata,
    StoredFiles,
    WorkMetadata,
    insert_rows,
    insert_works,
    work_digest,
    work_row,
)
from rumu.gallery.starter import StarterWork, brush_works, starter_works
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
BRUSH = CollectionMetadata(
    id="starter-brush",
    title=Bilingual(zh="四家寫「永」「之」", en="永 and 之 by four brush hands"),
    note=Bilingual(
        zh="同樣兩個字，楷書一家、行書兩家、草書一家，由可自由使用的毛筆字型繪成，並非原跡照片。",
        en="The same two characters by one regular, two running hands and a cursive one, drawn from freely "
        "usable brush fonts; not photographs of originals.",
    ),
    source="fonts, named with each work",
    licence="named with each work",
)
SIDE = 512  # pixels of a starter picture
STELE = CollectionMetadata(
    id="starter-stele",
    title=Bilingual(zh="一塊模擬的碑", en="A simulated stele"),
    note=Bilingual(
        zh="沒有這塊石頭：程式算出刻了字的石面在十盞燈下的樣子，再由這十張圖以光度立體法量出高低，"
        "和量一塊真的碑一樣。",
        en="There is no such stone: a program computed how a carved slab looks under ten lamps, and "
        "photometric stereo measured its relief from these ten pictures, as it does with a real one.",
    ),
    source="scripts/make_stele.py of rumu",
    licence="CC0-1.0",
)
"""The measured work that comes with the package."""
_STELE_WORK = WorkMetadata(
    title=Bilingual(zh="「入木三分」碑（模擬）", en="入木三分, a simulated stele"),
    script="regular",
    hand=Bilingual(zh="馬善政楷書（字型）", en="Ma Shan Zheng (the typeface)"),
    dynasty="contemporary",
    period=Bilingual(zh="當代（字型版本 2.003）", en="contemporary (font version 2.003)"),
    material=Bilingual(
        zh="程式模擬的刻石：石面、刻痕與十盞燈都由程式算出",
        en="a carved stone simulated by a program: slab, grooves and ten lamps are computed",
    ),
    source="scripts/make_stele.py of rumu, with four characters of Ma Shan Zheng, "
    "https://github.com/googlefonts/mashanzheng",
    licence="CC0-1.0",
    attribution="rumu; drawing of the characters: Copyright 2018 The MaShanZheng Project Authors (OFL-1.1)",
    origin="starter_stele",
)
DERIVED = "starter_derived.zip"
"""What the first pages show, by its keys in the store: scripts/make_starter_derived.py writes it."""
_STELE_PICTURE = "mean.jpg"  # beside the photographs, and none of them
_STELE_SPACING = 0.35  # mm for each pixel, as its capture.json says


def add_starter_works(gallery: Gallery) -> bool:
    """Add the starter works, annotations and tours to a gallery without works; whether it had none.

    Two processes may do so at the same time: rows that exist stay as they are.
    """
    with gallery.database.reading() as session:
        if session.scalar(select(Work.id).limit(1)) is not None:
            return False
    rows, brush = (
        [_work_row(gallery, work, position, of=collection) for position, work in enumerate(of_it)]
        for collection, of_it in ((STARTER, starter_works()), (BRUSH, brush_works()))
    )
    stele = _stele_row(gallery)
    _store_derived(gallery)
    file = resources.files("rumu.gallery").joinpath("starter_tours.json")
    texts = json.loads(file.read_text(encoding="utf-8"))
    annotations = [_split_languages(one) | {"position": n} for n, one in enumerate(texts["annotations"])]
    tours = [
        _split_languages(one) | {"steps": [_split_languages(step) for step in one["steps"]]}
        for one in texts["tours"]
    ]
    with gallery.database.writing() as session:
        insert_works(session, STARTER, rows)
        insert_works(session, BRUSH, brush)
        insert_works(session, STELE, [stele])
        insert_rows(session, Annotation, [row | {"work_id": row.pop("work")} for row in annotations])
        insert_rows(session, Tour, tours)
    return True


def _work_row(
    gallery: Gallery, work: StarterWork, position: int, *, of: CollectionMetadata
) -> dict[str, Any]:
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
    return work_row(metadata, files, work_id=work.id, collection=of, position=position)


def _stele_row(gallery: Gallery) -> dict[str, Any]:
    """Store the stele's photographs; its surface is reconstructed from them when somebody looks at it."""
    from PIL import Image

    folder = Path(str(resources.files("rumu.gallery").joinpath("starter_stele")))
    files = {path.name: path for path in sorted(folder.iterdir()) if path.name != _STELE_PICTURE}
    digest = folder_digest(files)
    store_files(gallery.store, capture_key(digest), files.values())
    picture = (folder / _STELE_PICTURE).read_bytes()
    key = picture_key(picture, suffix=".jpg")
    gallery.store.write(key, picture)
    with Image.open(folder / _STELE_PICTURE) as image:
        width, height = image.size
    stored = StoredFiles(
        picture=key,
        digest=_STELE_WORK.digest(digest),
        width=width,
        height=height,
        kind="capture",
        height_source="photometric",
        surface=surface_key(digest),
        capture=capture_key(digest),
        spacing=_STELE_SPACING,
    )
    return work_row(_STELE_WORK, stored, work_id="stele-ru-mu-san-fen", collection=STELE, position=0)


def _store_derived(gallery: Gallery) -> None:
    """Store what the first pages show, so that the first visitor waits for none of it to be computed.

    A file whose key has changed with the version of derived files is never asked for.
    """
    packed = resources.files("rumu.gallery").joinpath(DERIVED)
    if not packed.is_file():
        return
    with packed.open("rb") as file, zipfile.ZipFile(file) as files:
        for key in files.namelist():
            gallery.store.write(key, files.read(key))


def _split_languages(entry: dict[str, Any]) -> dict[str, Any]:
    """A JSON entry as columns: {"title": {"zh", "en"}} becomes title_zh and title_en."""
    row = {name: value for name, value in entry.items() if name not in ("title", "text")}
    for name in ("title", "text"):
        if name in entry:
            row |= {f"{name}_{language}": entry[name][language] for language in ("zh", "en")}
    return row
