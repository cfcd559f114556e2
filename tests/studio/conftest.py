"""A gallery with three works and some people in it, and pictures to send."""

from __future__ import annotations

import io
from pathlib import Path

import numpy as np
import pytest
from PIL import Image, ImageDraw

from conftest import copy_home
from rumu.gallery.catalog import open_gallery
from rumu.gallery.starter import starter_samples
from rumu.gallery.store import Gallery
from rumu.studio.people import Identity, create_person, identity
from rumu.studio.storage import Storage

PASSWORD = "a long password"


@pytest.fixture
def storage(tmp_path: Path) -> Storage:
    return Storage(database=str(tmp_path / "rumu.sqlite"), files=str(tmp_path / "files"))


@pytest.fixture
def gallery(storage: Storage, tmp_path: Path, starter_home: Path) -> Gallery:
    copy_home(starter_home, tmp_path)
    return open_gallery(database=storage.database, files=storage.files)


@pytest.fixture
def person(gallery):
    """Make somebody: person("林", "teacher")."""

    def make(name: str, role: str = "pupil") -> Identity:
        with gallery.database.writing() as session:
            return identity(create_person(session, name=name, password=PASSWORD, role=role))

    return make


@pytest.fixture
def copy_of():
    """A simulated copy's bytes, by work and degree."""

    def read(work: str = "regular-tian", degree: str = "good") -> bytes:
        return next(s for s in starter_samples(work=work) if s.degree == degree).path.read_bytes()

    return read


@pytest.fixture
def packed():
    """An array or an Image as an encoded file."""

    def pack(image, kind: str = "PNG", **settings) -> bytes:
        stream = io.BytesIO()
        (Image.fromarray(image) if isinstance(image, np.ndarray) else image).save(stream, kind, **settings)
        return stream.getvalue()

    return pack


@pytest.fixture
def cross():
    """十 in ink, (rows, columns) of any size."""

    def draw(width: int = 200, height: int = 200) -> Image.Image:
        page = Image.new("L", (width, height), 255)
        pen = ImageDraw.Draw(page)
        w, h = width, height
        pen.rectangle((0.2 * w, 0.45 * h, 0.8 * w, 0.52 * h), fill=20)
        pen.rectangle((0.47 * w, 0.15 * h, 0.54 * w, 0.85 * h), fill=20)
        return page

    return draw
