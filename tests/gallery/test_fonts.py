"""What a font says of itself; what it lacks is tested beside scripts/make_starter.py."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from rumu.errors import GalleryError
from rumu.gallery.fonts import SIDE, Face


def test_a_font_tells_who_made_it_and_under_which_licence(data):
    face = Face(data / "fonts" / "LXGWSeal-Regular.ttf")
    assert "LXGW" in face.name("family") and "LXGW" in face.name("copyright")
    assert "SIL Open Font License" in face.name("licence")


def test_a_glyph_stands_in_the_middle(data):
    face = Face(data / "fonts" / "LXGWSeal-Regular.ttf")
    picture = np.asarray(face.picture("水"))
    assert picture.shape == (SIDE, SIDE) and picture[0].min() == 255
    rows, columns = np.nonzero(picture < 128)
    assert abs((rows.min() + rows.max()) / 2 - SIDE / 2) < 2
    assert abs((columns.min() + columns.max()) / 2 - SIDE / 2) < 2


def test_a_file_that_is_no_font_is_refused(tmp_path: Path):
    (tmp_path / "x.ttf").write_bytes(b"\0\1\0\0 no font")
    with pytest.raises(GalleryError, match="expected a font"):
        Face(tmp_path / "x.ttf")
    with pytest.raises(GalleryError, match="expected a font there; try another"):
        Face(tmp_path / "y.ttf", hint="; try another")
