"""JPEG files that end early: a few bytes do not matter, rows do."""

from __future__ import annotations

import io
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from rumu.capture.image import read_image
from rumu.errors import ImageError


def page(mode: str = "RGB") -> Image.Image:
    """Ink on white paper, with texture at the end, so that the last bytes hold pixels."""
    rng = np.random.default_rng(5)
    gray = np.full((200, 304), 235.0) + rng.normal(0, 3, (200, 304))
    gray[40:160, 100:130] = 30
    return Image.fromarray(gray.clip(0, 255).astype(np.uint8)).convert(mode)


def written(**options: object) -> bytes:
    stream = io.BytesIO()
    page(str(options.pop("mode", "RGB"))).save(stream, "JPEG", **options)
    return stream.getvalue()


@pytest.mark.parametrize(
    "options", [{}, {"mode": "L"}, {"subsampling": 0}, {"progressive": True}, {"quality": 40}]
)
@pytest.mark.parametrize("lost", [1, 2, 6, 12])
def test_a_few_lost_bytes_do_not_matter(tmp_path: Path, options: dict[str, object], lost: int) -> None:
    data = written(**options)
    (tmp_path / "whole.jpg").write_bytes(data)
    (tmp_path / "cut.jpg").write_bytes(data[:-lost])
    whole, cut = read_image(tmp_path / "whole.jpg"), read_image(tmp_path / "cut.jpg")
    assert cut.shape == whole.shape
    np.testing.assert_allclose(cut[:180], whole[:180], atol=0.02)
    assert np.abs(cut - whole).max() < 0.2  # what is missing continues the paper, and is no gray block


@pytest.mark.parametrize("progressive", [False, True])
@pytest.mark.parametrize("share", [0.3, 0.5, 0.8])
def test_lost_rows_are_refused(tmp_path: Path, progressive: bool, share: float) -> None:
    data = written(progressive=progressive)
    scans = data.count(b"\xff\xda")
    cut = data[: int(share * len(data))]
    if progressive and cut.count(b"\xff\xda") == scans:
        pytest.skip("every scan has begun: all rows are there")
    (tmp_path / "cut.jpg").write_bytes(cut)
    with pytest.raises(ImageError, match=r"cut\.jpg: the image is cut short or broken") as caught:
        read_image(tmp_path / "cut.jpg")
    assert caught.value.zh is not None and "不完整" in caught.value.zh


def test_a_progressive_jpeg_without_its_last_scan_is_refused(tmp_path: Path) -> None:
    data = written(progressive=True)
    (tmp_path / "cut.jpg").write_bytes(data[: data.rindex(b"\xff\xda")])
    with pytest.raises(ImageError, match="it ends before its last scan"):
        read_image(tmp_path / "cut.jpg")


def test_a_cut_photograph_of_two_pictures(tmp_path: Path) -> None:
    page().save(tmp_path / "a.mpo", save_all=True, append_images=[page().rotate(180)])
    page().save(tmp_path / "a.jpg")
    data = (tmp_path / "a.mpo").read_bytes()
    (tmp_path / "cut.mpo").write_bytes(data[: -len(data) // 3])
    assert read_image(tmp_path / "cut.mpo").shape == (200, 304, 3)
    np.testing.assert_allclose(read_image(tmp_path / "cut.mpo"), read_image(tmp_path / "a.jpg"), atol=0.02)


def test_other_formats_are_refused_when_cut(tmp_path: Path) -> None:
    page().save(tmp_path / "a.png")
    data = (tmp_path / "a.png").read_bytes()
    (tmp_path / "a.png").write_bytes(data[: len(data) // 2])
    with pytest.raises(ImageError, match="cut short"):
        read_image(tmp_path / "a.png")
