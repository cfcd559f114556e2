"""A glyph that a font lacks must stop the script that renders the gallery, whatever is drawn instead."""

from __future__ import annotations

import hashlib
import importlib.util
import sys
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest
from PIL import Image

from rumu.errors import GalleryError
from rumu.gallery.starter import starter_works

SCRIPT = Path(__file__).parents[2] / "scripts" / "make_starter.py"


@pytest.fixture(scope="module")
def make_starter() -> ModuleType:
    spec = importlib.util.spec_from_file_location("make_starter", SCRIPT)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules["make_starter"] = module  # its dataclasses look their module up
    spec.loader.exec_module(module)
    return module


def small_font(path: Path, *, stamped: str, empty: str, drawn: str) -> Path:
    """A font whose table claims all these characters, but which stamps, skips or draws them."""
    from fontTools.fontBuilder import FontBuilder
    from fontTools.pens.ttGlyphPen import TTGlyphPen

    def box(*corners: tuple[int, int]) -> object:
        pen = TTGlyphPen(None)
        pen.moveTo(corners[0])
        for corner in corners[1:]:
            pen.lineTo(corner)
        pen.closePath()
        return pen.glyph()

    square = ((50, 0), (50, 900), (950, 900), (950, 0))
    # The stamp has a glyph of its own for each character, as a font may that wants to look complete.
    glyphs = {".notdef": box(*square), "stray": box(*square)}
    cmap = {0x9F98: "stray"}  # 龘
    for character in stamped:
        glyphs[f"stamp{ord(character):X}"] = box(*square)
        cmap[ord(character)] = f"stamp{ord(character):X}"
    for character in empty:
        glyphs[f"empty{ord(character):X}"] = TTGlyphPen(None).glyph()
        cmap[ord(character)] = f"empty{ord(character):X}"
    for number, character in enumerate(drawn):
        glyphs[f"own{number}"] = box((100, 100), (500, 700 + number), (900, 100))
        cmap[ord(character)] = f"own{number}"
    builder = FontBuilder(1000, isTTF=True)
    builder.setupGlyphOrder(list(glyphs))
    builder.setupCharacterMap(cmap)
    builder.setupGlyf(glyphs)
    builder.setupHorizontalMetrics({name: (1000, 0) for name in glyphs})
    builder.setupHorizontalHeader(ascent=900, descent=-100)
    builder.setupNameTable({"familyName": "Small", "styleName": "Regular"})
    builder.setupOS2()
    builder.setupPost()
    builder.save(path)
    return path


def test_a_missing_glyph_is_refused_however_the_font_hides_it(
    make_starter: ModuleType, tmp_path: Path
) -> None:
    face = make_starter.Face(small_font(tmp_path / "small.ttf", stamped="水", empty="日", drawn="天"))
    with pytest.raises(GalleryError, match=r"small\.ttf: has no 月.*table of characters"):
        face.check("月")
    with pytest.raises(GalleryError, match=r"has no 日.*empty"):
        face.check("日")
    with pytest.raises(GalleryError, match=r"has no 水.*substitute"):
        face.check("水")
    face.check("天")
    picture = np.asarray(face.picture("天"))
    assert picture.shape == (512, 512)
    assert picture.min() == 0
    with pytest.raises(GalleryError, match="substitute"):
        face.picture("水")


@pytest.fixture(scope="module")
def faces(make_starter: ModuleType, data: Path) -> dict[str, Any]:
    fonts = {"seal": "LXGWSeal-Regular.ttf", "clerical": "TW-MOE-Li_eduli.woff2"}
    return {script: make_starter.Face(data / "fonts" / font) for script, font in fonts.items()}


def test_the_real_fonts_lack_what_they_lack(make_starter: ModuleType, faces: dict[str, Any]) -> None:
    for missing in "永木犇":  # drawn as a square stamp that says 字鍵
        with pytest.raises(GalleryError, match=rf"LXGWSeal-Regular\.ttf: has no {missing}"):
            faces["seal"].check(missing)
    with pytest.raises(GalleryError, match="has no 书"):
        faces["clerical"].check("书")
    for face in faces.values():
        for character in make_starter.CHARACTERS:
            face.check(character)


def test_the_kept_pictures_are_what_the_fonts_draw(make_starter: ModuleType, faces: dict[str, Any]) -> None:
    kept = {work.id: work for work in starter_works()}
    for script, face in faces.items():
        for character in "天書":
            name, _ = make_starter.CHARACTERS[character]
            with Image.open(kept[f"{script}-{name}"].path) as image:
                difference = np.abs(
                    np.asarray(image, dtype=int) - np.asarray(face.picture(character), dtype=int)
                )
            assert difference.mean() < 0.5, "other versions of the rasteriser may differ in a few edge pixels"


def test_a_missing_font_names_the_package_and_writes_nothing(
    make_starter: ModuleType,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    nowhere = tmp_path / "kouzan"
    monkeypatch.setattr(make_starter, "KOUZAN", nowhere)
    with pytest.raises(GalleryError, match="apt install fonts-kouzan-mouhitsu"):
        make_starter.Face(nowhere / "kouzan-mouhitsu.ttf")
    output = tmp_path / "starter"
    assert make_starter.main(["--fonts", str(tmp_path), "--output", str(output)]) == 1
    assert "LXGWSeal-Regular.ttf" in capsys.readouterr().err
    assert not output.exists()


def test_a_glyph_that_is_missing_late_leaves_the_old_gallery_alone(
    make_starter: ModuleType, tmp_path: Path, data: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    output = tmp_path / "starter"
    output.mkdir()
    (output / "works.json").write_text("[]", encoding="utf-8")
    before = hashlib.sha256((output / "works.json").read_bytes()).hexdigest()
    monkeypatch.setattr(make_starter, "CHARACTERS", {"天": ("tian", "heaven"), "永": ("yong", "forever")})
    assert make_starter.main(["--fonts", str(data / "fonts"), "--output", str(output)]) == 1
    assert hashlib.sha256((output / "works.json").read_bytes()).hexdigest() == before
    assert [p.name for p in output.iterdir()] == ["works.json"]
