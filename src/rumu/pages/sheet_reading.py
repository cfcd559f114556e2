"""A photograph of a printed sheet -> what its code says, and what was written in each of its cells.

The recipe: find the markers, map the paper, read the code, map it again by the printed frames of its cells,
cut the cells out, take away what was printed.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from rumu.errors import RefusedImage
from rumu.pages.blurred_markers import blur_of_unread_markers
from rumu.pages.marker_light import measure_markers
from rumu.pages.marker_tone import MarkerTone, fit_tone
from rumu.pages.sheet_code import find_code
from rumu.pages.sheet_frames import FlatSheet, flatten, frame_grayness, refine_by_frames
from rumu.pages.sheet_layout import MARKER, PAPERS, Box, SheetCell, SheetPage
from rumu.pages.sheet_markers import (
    SIDE,
    PaperMap,
    find_markers,
    map_paper,
    refuse_cut_off,
)
from rumu.pages.sheet_models import MasterShape
from rumu.pages.sheet_print import take_print_away
from rumu.values import FloatArray

Picture = npt.NDArray[np.uint8]


@dataclass(frozen=True, slots=True)
class SheetReadingSettings:
    """When a photograph is refused, and how its cells are cut.

    flat: pixels of the flat page for each millimetre. contrast: least gray levels between the black and the
    white of the markers. blur: most millimetres of the standard deviation by which their edges are smeared.
    largest, smallest: side of a cell's picture in pixels. rim: of a cell, left out when it is judged empty,
    as a share of its side. ink: darkness from which a pixel is ink; written: least share of a cell that is.
    """

    flat: float = 6.0
    contrast: float = 45.0
    blur: float = 0.42
    largest: int = 480
    smallest: int = 320
    rim: float = 0.03
    ink: float = 0.35
    written: float = 0.002


@dataclass(frozen=True, slots=True, eq=False)
class LocatedSheet:
    """A sheet found in a photograph.

    picture: (H, W, 3) uint8, the photograph. page: what its code says. places: from the paper to pixels.
    flat: the page flattened. gamma: exponent that turns levels of the red channel, over the paper's, into
    light. blur: standard deviation by which edges are smeared in it, in millimetres. gray: how gray the print
    is, see `grayness`.
    """

    picture: Picture
    page: SheetPage
    places: PaperMap
    flat: FlatSheet
    gamma: float
    blur: float
    gray: float

    def name_picture(self) -> Picture:
        """The place of the pupil's name, as a picture on white paper."""
        part = self.flat.cut(self.page.name_box)
        paper = np.quantile(part, 0.8, axis=(0, 1))
        return np.asarray(np.clip(part * (250 / np.maximum(paper, 1.0)), 0, 255), np.uint8)


@dataclass(frozen=True, slots=True, eq=False)
class WrittenCell:
    """A cell that somebody wrote in.

    cell: which. picture: (n, n) uint8 gray, what was written in it, without the print; the whole is the cell.
    polygon: (4, 2) its corners in the photograph, in pixels, the upper left first.
    """

    cell: SheetCell
    picture: Picture
    polygon: FloatArray


def is_sheet(picture: Picture) -> bool:
    """Whether a picture (H, W, 3) shows a printed sheet of ours, even one that will be refused."""
    if len({number for number, _ in find_markers(_gray(picture))}) >= 3:
        return True
    blur = blur_of_unread_markers(picture)
    return blur is not None and blur > SheetReadingSettings().blur


def locate_sheet(picture: Picture, *, settings: SheetReadingSettings | None = None) -> LocatedSheet:
    """Find the sheet in a photograph.

    picture: (H, W, 3) uint8 sRGB; any rotation.
    Raises RefusedImage, with reason 'no sheet', 'two sheets', 'cut off', 'dark', 'blurred' or 'unreadable'.
    """
    import cv2

    settings = settings or SheetReadingSettings()
    gray = _gray(picture)
    markers = find_markers(gray)
    if len({number for number, _ in markers}) < 3:
        unread = blur_of_unread_markers(picture)
        if unread is not None and unread > settings.blur:
            raise _refuse_blurred()
        raise RefusedImage(
            "expected a practice sheet that rumu printed, found none of its black squares",
            reason="no sheet",
            zh="照片裡沒有找到練習紙四邊的黑色方塊；請把整張練習紙拍清楚。",
        )
    _check_light(gray, markers, settings)
    for paper in PAPERS:
        places = map_paper(markers, paper)
        page = _read_code(picture, places, scale=settings.flat)
        if page is not None:
            return _locate(
                picture,
                page,
                places,
                settings,
                fit_tone(np.asarray(cv2.extractChannel(picture, 0), np.uint8), markers),
            )
    raise RefusedImage(
        "expected the printed code of the sheet, it cannot be read; is it covered or creased?",
        reason="unreadable",
        zh="練習紙右上角的方塊碼讀不出來，可能被遮住或弄皺了。",
    )


def read_cells(
    sheet: LocatedSheet, masters: Mapping[str, MasterShape], *, settings: SheetReadingSettings | None = None
) -> tuple[WrittenCell, ...]:
    """What was written in the cells of a sheet, in reading order; empty cells are left out.

    masters: by character, as they were printed; only a sheet printed in black and white needs them.
    """
    import cv2

    settings = settings or SheetReadingSettings()
    red = np.asarray(cv2.extractChannel(sheet.picture, 0), np.uint8)
    cells = []
    for cell in sheet.page.cells:
        if not cell.is_for_writing:
            continue
        side = int(np.clip(round(cell.box.width * sheet.places.scale()), settings.smallest, settings.largest))
        gray = take_print_away(
            _cut(red, sheet, cell, side),
            cell,
            sheet.page.grid,
            masters.get(cell.character),
            gray=sheet.gray,
            gamma=sheet.gamma,
            blur=sheet.blur,
        )
        if _is_written(gray, settings):
            cells.append(WrittenCell(cell, gray, sheet.places.pixels(cell.box.corners)))
    return tuple(cells)


def _locate(
    picture: Picture, page: SheetPage, places: PaperMap, settings: SheetReadingSettings, tone: MarkerTone
) -> LocatedSheet:
    """The sheet whose code was read, mapped by all that is printed on it."""
    height, width = picture.shape[:2]
    corners = np.concatenate([cell.box.corners for cell in page.cells])
    flat = flatten(picture, places, scale=settings.flat)
    places = refine_by_frames(flat, page, places)
    x, y = places.pixels(corners).T
    if min(x.min(), y.min()) < 0 or x.max() > width - 1 or y.max() > height - 1:
        raise refuse_cut_off()
    flat = flatten(picture, places, scale=settings.flat)
    gray, blur = frame_grayness(flat, page), tone.smear * MARKER / SIDE
    return LocatedSheet(picture, page, places, flat, tone.gamma, blur, gray)


def _read_code(picture: Picture, places: PaperMap, *, scale: float) -> SheetPage | None:
    """What the code of a page says; None where there is none, or it says another paper."""
    box = SheetPage("一", "", paper=places.paper).code_box
    around = 2 * _BESIDE
    part = Box(box.left - around, box.top - around, box.width + 2 * around, box.height + 2 * around)
    flat = flatten(picture, places, scale=scale, box=part)
    corners = (box.corners - (part.left, part.top)) * scale - 0.5
    page = find_code(flat.red, corners, reach=_BESIDE * scale)
    return page if page is not None and page.paper == places.paper else None


def _gray(picture: Picture) -> Picture:
    import cv2

    return np.asarray(cv2.cvtColor(picture, cv2.COLOR_RGB2GRAY), np.uint8)


def _check_light(
    gray: Picture, markers: list[tuple[int, FloatArray]], settings: SheetReadingSettings
) -> None:
    """Raise RefusedImage where the markers are too dark or their edges smeared too far."""
    seen = measure_markers(gray, markers)
    if seen.contrast < settings.contrast:
        raise RefusedImage(
            "too dark: expected black squares on white paper, the picture hardly tells them apart",
            reason="dark",
            zh="照片太暗，黑白分不清；請在亮一點的地方再拍。",
        )
    if seen.blur * MARKER / seen.side > settings.blur:
        raise _refuse_blurred()


_BESIDE = 2.0  # millimetres by which the code of a bent page may lie beside its place


def _refuse_blurred() -> RefusedImage:
    return RefusedImage(
        "blurred: the edges of the printed squares are smeared; hold still, and let the camera focus",
        reason="blurred",
        zh="照片模糊；請拿穩、對好焦再拍。",
    )


def _cut(red: Picture, sheet: LocatedSheet, cell: SheetCell, side: int) -> npt.NDArray[np.float32]:
    """(side, side): a cell of a channel of the photograph over the paper around it, 1 on paper."""
    import cv2

    nodes = 17
    shares = np.linspace(0, 1, nodes)
    x, y = np.meshgrid(cell.box.left + shares * cell.box.width, cell.box.top + shares * cell.box.height)
    places = sheet.places.pixels(np.column_stack([x.ravel(), y.ravel()])).astype(np.float32)
    at = ((np.arange(side) + 0.5) / side * (nodes - 1)).astype(np.float32)
    column, row = np.meshgrid(at, at)
    maps = [
        cv2.remap(places[:, axis].reshape(nodes, nodes), column, row, cv2.INTER_LINEAR) for axis in (0, 1)
    ]
    pixels = cv2.remap(red, maps[0], maps[1], cv2.INTER_CUBIC, borderMode=cv2.BORDER_REPLICATE)
    paper = sheet.flat.red_paper(cell.box, side)
    return np.asarray(pixels.astype(np.float32) / np.maximum(paper, 1.0), np.float32)


def _is_written(gray: Picture, settings: SheetReadingSettings) -> bool:
    """Whether there is ink in a cell's picture."""
    rim = round(settings.rim * len(gray))
    inner = gray[rim:-rim, rim:-rim]
    dark = int(np.count_nonzero(inner < 255 * (1 - settings.ink)))
    return dark >= settings.written * inner.size
