"""The copy of a capture that the store keeps: photographs, lamps and all that is needed to read them again.

A capture may name files anywhere and in any script. The copy has photographs under plain names, lights.lp (of
lamps near the sheet lights.dome, which tells their places), mask.png, ambient and capture.json in one folder;
names.json holds the original names. Of photographs of the printed card it holds what they show in the card's
window, laid flat.
"""

from __future__ import annotations

import io
import json
import shutil
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from rumu.gallery.assets import folder_digest
from rumu.image_stack import ImageStack, pixels_of

if TYPE_CHECKING:
    from rumu.card.capture import CardCapture
    from rumu.values import Capture

_LOOKED_AT = 500_000  # pixels of a capture that tell how bright its picture is to be
_BAND = 200_000  # of its pixels that are brought together at a time


def copy_capture(capture: Capture, folder: Path, target: Path) -> str:
    """Copy the files of a capture into a new folder; the digest of all. folder: where it was read."""
    from PIL import Image

    from rumu.capture.description import description_of

    target.mkdir(parents=True)
    plain = _plain_names(Path(name).suffix.lower() for name in capture.names)
    for one, name in zip(plain, capture.names, strict=True):
        shutil.copyfile(folder / name, target / one)
    if not capture.mask.all():
        Image.fromarray(capture.mask.astype(np.uint8) * 255).save(target / "mask.png")
    for dark in sorted(folder.glob("[aA]mbient.*")):
        shutil.copyfile(dark, target / f"ambient{dark.suffix.lower()}")
    encoding = description_of(folder).encoding
    _write_description(
        capture,
        target,
        orientation=capture.orientation,
        lamps_as_given=capture.lamps_as_given or None,
        encoding=encoding,
    )
    return _finish(capture, plain, target)


def copy_card_capture(made: CardCapture, folder: Path, target: Path) -> str:
    """Write what photographs of the card show in its window into a new folder; the digest of all.

    folder: of the photographs. They become PNGs of as many bits as their files have, as a screen shows them.
    """
    from rumu.capture.formats import read_header

    target.mkdir(parents=True)
    capture = made.capture
    plain = _plain_names(".png" for _ in capture.names)
    for number, (one, name) in enumerate(zip(plain, capture.names, strict=True)):
        deep = read_header(folder / name).sample_bytes > 1
        _write_photograph(made.flat, number, target / one, levels=65535 if deep else 255)
    _write_description(capture, target, orientation="stored", encoding="srgb")
    return _finish(capture, plain, target)


def mean_photograph(capture: Capture) -> bytes:
    """The mean of the photographs as a PNG, bright where nothing is overexposed."""
    from PIL import Image

    from rumu.surface.mesh import albedo_srgb

    stack = capture.photographs
    some = stack.at(pixels_of(capture.mask, about=_LOOKED_AT)).mean(axis=0)
    bright = float(np.percentile(some, 99.5)) or 1.0
    height, width = stack.shape[1:3]
    picture, step = np.empty((height, width, 3), np.uint8), max(1, _BAND // width)
    for top in range(0, height, step):
        mean = stack.rows(top, min(top + step, height)).mean(axis=0)
        picture[top : top + step] = albedo_srgb(np.clip(mean / bright, 0, 1))
    png = io.BytesIO()
    Image.fromarray(picture).save(png, "PNG", optimize=True)
    return png.getvalue()


def _plain_names(suffixes: Iterable[str]) -> list[str]:
    return [f"{number:03d}{suffix}" for number, suffix in enumerate(suffixes, start=1)]


def _write_photograph(stack: ImageStack, number: int, path: Path, *, levels: int) -> None:
    """Write one photograph of a stack as a PNG in sRGB; levels: that of white."""
    import cv2

    from rumu.capture.stored import to_srgb

    light = stack.frame(number)
    samples = np.empty(light.shape, np.uint16 if levels > 255 else np.uint8)
    step = max(1, _BAND // light.shape[1])
    for top in range(0, len(light), step):
        rows = slice(top, top + step)
        samples[rows] = np.round(levels * to_srgb(np.clip(light[rows], 0, 1)))
    written = samples if samples.ndim == 2 else samples[..., ::-1]  # B, G, R
    _, packed = cv2.imencode(".png", np.ascontiguousarray(written))
    path.write_bytes(packed.tobytes())


def _write_description(capture: Capture, target: Path, **told: Any) -> None:
    """Write capture.json, without what is None."""
    described = {"spacing_mm": capture.spacing, **told}
    described = {key: value for key, value in described.items() if value is not None}
    (target / "capture.json").write_text(json.dumps(described), encoding="utf-8")


def _finish(capture: Capture, plain: list[str], target: Path) -> str:
    """Write lamps and names; the digest of all files."""
    from rumu.capture.dome import dome_text

    told = capture.lights
    if capture.strengths is not None:
        told = np.column_stack([told, capture.strengths])
    if capture.positions is None:
        lines = [str(len(plain))]
        for one, values in zip(plain, told, strict=True):
            lines.append(f"{one} " + " ".join(f"{value:.9g}" for value in values))
        (target / "lights.lp").write_text("\n".join(lines) + "\n", encoding="utf-8")
    else:  # the photographs are numbered in the order of the lamps, which is how a .dome names them
        spacing, columns = capture.spacing or 1.0, capture.mask.shape[1]
        text = dome_text(capture.positions, capture.strengths, spacing=spacing, columns=columns)
        (target / "lights.dome").write_text(text, encoding="utf-8")
    names = dict(zip(plain, (Path(name).name for name in capture.names), strict=True))
    (target / "names.json").write_text(json.dumps(names, ensure_ascii=False), encoding="utf-8")
    return folder_digest({file.name: file for file in target.iterdir()})
