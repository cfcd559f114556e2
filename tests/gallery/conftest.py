"""Galleries of each kind of database, small ones, and folders to import."""

from __future__ import annotations

import csv
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

from conftest import copy_home
from rumu.database.engine import Database, open_database
from rumu.gallery.assets import assets_of
from rumu.gallery.catalog import work
from rumu.gallery.store import Gallery, Store
from rumu.values import Surface


@pytest.fixture
def database(database_url: str) -> Iterator[Database]:
    opened = open_database(database_url)
    yield opened
    opened.close()


@pytest.fixture(params=["sqlite", "postgresql"])
def gallery(request: pytest.FixtureRequest, tmp_path: Path, starter_home: Path) -> Iterator[Gallery]:
    """The starter gallery, on SQLite and on PostgreSQL."""
    url = f"sqlite:///{copy_home(starter_home, tmp_path) / 'rumu.sqlite'}"
    if request.param == "postgresql":
        url = request.getfixturevalue("new_postgresql")(request.getfixturevalue("starter_postgresql"))
    opened = open_database(url)
    yield Gallery(opened, Store.open(tmp_path / "files"))
    opened.close()


@pytest.fixture
def bare(tmp_path: Path) -> Iterator[Gallery]:
    """A gallery without works, on SQLite."""
    opened = open_database(tmp_path / "bare.sqlite")
    yield Gallery(opened, Store.open(tmp_path / "bare-files"))
    opened.close()


def surface(gallery: Gallery, work_id: str) -> Surface:
    """The surface of a work."""
    return assets_of(gallery.store, work(gallery, work_id)).surface()


def drawn(number: int, *, side: int = 48) -> Image.Image:
    """A small cross of ink on white whose place tells the number."""
    page = np.full((side, side), 255, np.uint8)
    row, column = 8 + number % 29, 8 + number // 29 % 29
    page[row - 3 : row + 3, 4:-4] = 0
    page[4:-4, column - 3 : column + 3] = 0
    page[0, : number % side] = 250  # no two alike
    page[1, : number // side] = 250
    return Image.fromarray(page)


@pytest.fixture
def labelled(tmp_path: Path) -> Callable[..., Path]:
    """A function of a number of works: the folder with their pictures and labels.csv."""

    def make(count: int, *, name: str = "set", **more: str) -> Path:
        folder = tmp_path / name
        (folder / "img").mkdir(parents=True)
        columns = ("file", "character", "calligrapher", "calligrapher_zh", "work", "dynasty", "script")
        with (folder / "labels.csv").open("w", encoding="utf-8", newline="") as stream:
            rows = csv.DictWriter(stream, (*columns, *more))
            rows.writeheader()
            for number in range(count):
                file = f"img/{number:05d}.png"
                drawn(number).save(folder / file)
                facts = (
                    file,
                    "永和九年歲"[number % 5],
                    "yu_shinan_attr",
                    "虞世南(傳)",
                    "蘭亭序",
                    "Tang",
                    "running",
                )
                rows.writerow(dict(zip(columns, facts, strict=True)) | more)
        return folder

    return make


@pytest.fixture
def everything() -> Callable[[Gallery], dict[str, list[dict[str, Any]]]]:
    """A function of a gallery: all rows of works and what is said of them, to compare galleries."""
    from sqlalchemy import select

    from rumu.database.tables import Annotation, Collection, Tour, Work

    def rows(gallery: Gallery, table: Any) -> list[dict[str, Any]]:
        with gallery.database.reading() as session:
            found = [
                {column.name: getattr(row, column.name) for column in table.__table__.columns}
                for row in session.scalars(select(table))
            ]
        return sorted(found, key=lambda row: str(row["id"]))

    tables = (Collection, Work, Annotation, Tour)
    return lambda gallery: {table.__tablename__: rows(gallery, table) for table in tables}
