"""Printed practice sheets with leaning copies in some cells, photographed by the laboratory's camera."""

from __future__ import annotations

import io
from collections.abc import Sequence

import cv2
import numpy as np
import pypdfium2
from PIL import Image

from rumu.gallery.sheet_masters import choose_masters
from rumu.pages.sheet_layout import SheetPage, lay_out
from rumu.pages.sheet_pdf import sheet_pdf
from rumu_lab.simulation.camera import Conditions, take_photograph

DPI = 150


def written_sheet(
    text: str = "人水",
    *,
    sources: Sequence[str] = (),
    pupil: str = "",
    cells: Sequence[tuple[int, int]] = ((0, 1), (1, 0)),
    lean: float = 5.0,
    side: float = 45.0,
    times: int = 3,
) -> np.ndarray:
    """(H, W, 3) uint8: a sheet as a scanner sees it, with the masters, leaning, in these cells."""
    masters = choose_masters(text, sources)
    (page,) = lay_out(SheetPage(text, masters.name, cell=side, times=times, strokes=False, pupil=pupil))
    document = pypdfium2.PdfDocument(sheet_pdf([page], masters.shapes))
    flat = np.asarray(document[0].render(scale=DPI / 72).to_pil().convert("RGB")).astype(np.float32)
    for cell in page.cells:
        if (cell.row, cell.column) in cells:
            left, top, size = (round(v * DPI / 25.4) for v in (cell.box.left, cell.box.top, cell.box.width))
            ink = masters.by_character[cell.character].ink
            turned = cv2.warpAffine(ink, cv2.getRotationMatrix2D((256, 256), -lean, 0.92), (512, 512))
            small = cv2.resize(turned, (size, size), interpolation=cv2.INTER_AREA)
            flat[top : top + size, left : left + size] *= 1 - 0.9 * small[..., None]
    return np.clip(flat, 0, 255).astype(np.uint8)


def photograph(
    flat: np.ndarray, *, turn: float = 10.0, blur: float = 0.8, megapixels: float = 3
) -> np.ndarray:
    """(H, W, 3) uint8: the sheet from aside. turn: degrees. blur: standard deviation in pixels."""
    conditions = Conditions(
        tilt=20, towards=40, turn=turn, megapixels=megapixels, blur=blur, noise=2, light=0.3
    )
    return take_photograph(flat, conditions).picture


def encoded(picture: np.ndarray, kind: str = "JPEG") -> bytes:
    """A picture as a file."""
    stream = io.BytesIO()
    Image.fromarray(picture).save(stream, kind, quality=92)
    return stream.getvalue()
