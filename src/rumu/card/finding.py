"""The card in a photograph: its markers, and the map from millimetres on it to pixels."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt

from rumu.capture.image import read_colours
from rumu.capture.photographs import capture_error
from rumu.card.layout import FIRST_MARKER, MARKER_SIDE, MARKERS, CardLayout
from rumu.errors import ImageError
from rumu.pages.marker_light import MarkerLight, measure_markers
from rumu.pages.sheet_layout import Paper
from rumu.pages.sheet_markers import find_markers
from rumu.values import FloatArray

_DIAGONAL_35 = 43.2666  # millimetres, of 35-mm film
_NUMBERS = range(min(FIRST_MARKER.values()), max(FIRST_MARKER.values()) + MARKERS)
_USUAL_FOCAL = 26.0  # millimetres for 35-mm film, of the main lens of most phones


@dataclass(frozen=True, slots=True)
class CardFindingSettings:
    """When a card is found.

    fewest: markers that must be seen. spread: share of the card's sides over which they must lie. contrast:
    least gray levels between their black and the white. blur: most millimetres by which edges are smeared.
    off: share of a marker's side by which a corner may lie beside a flat card; beyond, it does not count.
    bent: millimetres, root mean square, by which they may all lie beside it before the card is not flat.
    """

    fewest: int = 8
    spread: float = 0.6
    contrast: float = 35.0
    blur: float = 0.5
    off: float = 0.25
    bent: float = 1.0


@dataclass(frozen=True, slots=True, eq=False)
class CardView:
    """The card as one photograph shows it.

    layout: which card. homography: (3, 3), from millimetres on the card (x right, y down, from its upper left
    corner) to pixels, (0, 0) the middle of the first. off: millimetres, root mean square, by which the
    markers' corners lie beside that. blur: millimetres of the standard deviation by which edges are smeared.
    shape: (H, W) of the photograph. focal: in pixels. focal_is_known: whether the photograph said it.
    """

    layout: CardLayout
    homography: FloatArray
    off: float
    blur: float
    shape: tuple[int, int]
    focal: float
    focal_is_known: bool

    def pixels(self, points: FloatArray) -> FloatArray:
        """(n, 2): where points (n, 2) of the card lie in the photograph."""
        seen = np.column_stack([points, np.ones(len(points))]) @ self.homography.T
        return np.asarray(seen[:, :2] / seen[:, 2:])

    def out(self, pixels: FloatArray) -> FloatArray:
        """(n,): squared distances of pixels (n, 2) from the picture's middle, 1 in its corners."""
        height, width = self.shape
        x, y = pixels.T
        away = (x - (width - 1) / 2) ** 2 + (y - (height - 1) / 2) ** 2
        return np.asarray(away / ((height / 2) ** 2 + (width / 2) ** 2))

    def lens(self) -> FloatArray:
        """(3, 3): from rays (x right, y down, 1) to pixels."""
        height, width = self.shape
        return np.array([[self.focal, 0, (width - 1) / 2], [0, self.focal, (height - 1) / 2], [0, 0, 1]])

    def scale(self) -> float:
        """Pixels for each millimetre in the middle of the window."""
        window = self.layout.window
        middle = np.array([window.left + window.width / 2, window.top + window.height / 2])
        square = self.pixels(middle + np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]))
        x, y = square.T
        return float(np.sqrt(abs(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1))) / 2) / 2)

    def camera(self) -> tuple[FloatArray, FloatArray]:
        """Where the camera is, (3,) millimetres from the card's middle (x right, y up, z off it).

        And its axes, (3, 3): rows are right, down and forward in the picture.
        """
        width, height = self.layout.size
        centred = np.array([[1, 0, width / 2], [0, -1, height / 2], [0, 0, 1.0]])
        M = np.linalg.solve(self.lens(), self.homography @ centred)
        M /= np.sqrt(np.linalg.norm(M[:, 0]) * np.linalg.norm(M[:, 1]))
        M *= np.sign(M[2, 2])
        first, second, shift = M.T
        U, _, Vt = np.linalg.svd(np.column_stack([first, second, np.cross(first, second)]))
        R = U @ np.diag([1.0, 1.0, float(np.sign(np.linalg.det(U @ Vt)))]) @ Vt
        return -R.T @ shift, R


def shows_card(path: Path) -> bool:
    """Whether a picture shows a capture card, whatever its state. False for what is no picture."""
    import cv2

    try:
        picture = read_colours(path)
    except ImageError:
        return False
    gray = np.asarray(cv2.cvtColor(picture, cv2.COLOR_RGB2GRAY), np.uint8)
    return len(find_markers(gray, among=_NUMBERS)) >= CardFindingSettings().fewest // 2


def find_card(
    picture: npt.NDArray[np.uint8],
    path: Path,
    *,
    focal_35_mm: float | None = None,
    settings: CardFindingSettings | None = None,
) -> CardView:
    """Find the card in a photograph.

    picture: (H, W, 3) uint8, as shown on a screen; turned in any way. path: of its file, for messages.
    focal_35_mm: focal length for 35-mm film, None when it is not known.
    Raises CaptureError that names the photograph: without the card, cut off, with two, dark, blurred, bent.
    """
    import cv2

    settings = settings or CardFindingSettings()
    gray = np.asarray(cv2.cvtColor(picture, cv2.COLOR_RGB2GRAY), np.uint8)
    markers = find_markers(gray, among=_NUMBERS)
    paper = _paper_of(markers, path)
    layout = CardLayout(paper)
    markers = [(number, corners) for number, corners in markers if number in layout.markers]
    seen = _check_light(gray, markers, path, settings)
    _check_markers(markers, layout, path, settings)
    homography, off = _fit(markers, layout, path, side=seen.side, settings=settings)
    blur = seen.blur * MARKER_SIDE / seen.side
    longest = float(np.hypot(*picture.shape[:2]))
    focal = (focal_35_mm or _USUAL_FOCAL) / _DIAGONAL_35 * longest
    return CardView(layout, homography, off, blur, gray.shape, focal, focal_35_mm is not None)  # type: ignore[arg-type]


def _paper_of(markers: list[tuple[int, FloatArray]], path: Path) -> Paper:
    """Which card the numbers tell. Raises CaptureError where there is none."""
    votes = Counter(paper for number, _ in markers for paper in _papers_with(number))
    if not votes:
        raise capture_error(
            path,
            en="expected the capture card (rumu card) in the photograph, found none of its black squares",
            zh="照片裡找不到拍攝卡（rumu card）的黑色方塊",
        )
    return votes.most_common(1)[0][0]


def _papers_with(number: int) -> list[Paper]:
    return [paper for paper, first in FIRST_MARKER.items() if first <= number < first + MARKERS]


def _check_light(
    gray: npt.NDArray[np.uint8],
    markers: list[tuple[int, FloatArray]],
    path: Path,
    settings: CardFindingSettings,
) -> MarkerLight:
    """What the markers tell of the light. Raises CaptureError where it is too dark or blurred."""
    seen = measure_markers(gray, markers)
    if seen.contrast < settings.contrast:
        raise capture_error(
            path,
            en=f"too dark: black and white of the card are {seen.contrast:.0f} gray levels apart, expected "
            f"{settings.contrast:.0f} or more; expose longer, or move the lamp nearer",
            zh=f"太暗：卡上的黑與白只差 {seen.contrast:.0f} 階，至少要 {settings.contrast:.0f} 階；"
            "請延長曝光，或把燈移近",
        )
    blur = seen.blur * MARKER_SIDE / seen.side
    if blur > settings.blur:
        raise capture_error(
            path,
            en=f"blurred: edges of the card are smeared over {blur:.2f} mm, expected at most "
            f"{settings.blur:.2f}; put the camera on something firm, and let it focus",
            zh=f"模糊：卡上的邊緣糊了 {blur:.2f} 毫米，最多 {settings.blur:.2f}；請把相機放穩、對好焦",
        )
    return seen


def _check_markers(
    markers: list[tuple[int, FloatArray]], layout: CardLayout, path: Path, settings: CardFindingSettings
) -> None:
    """Raise CaptureError where there are two cards, or too little of one."""
    if len({number for number, _ in markers}) < len(markers):
        raise capture_error(
            path,
            en="expected one capture card, found the squares of two",
            zh="照片裡有兩張拍攝卡，應只有一張",
        )
    boxes = [layout.markers[number] for number, _ in markers]
    spread = np.ptp([(box.left, box.top) for box in boxes], axis=0) / np.array(layout.size)
    if len(markers) < settings.fewest or spread.min() < settings.spread:
        raise capture_error(
            path,
            en=f"expected the whole card, found {len(markers)} of its {MARKERS} squares; the rest is cut "
            "off, covered, or in deep shadow",
            zh=f"拍攝卡要拍全：{MARKERS} 個方塊只找到 {len(markers)} 個，其餘不在畫面內、被遮住或太暗",
        )


def _fit(
    markers: list[tuple[int, FloatArray]],
    layout: CardLayout,
    path: Path,
    *,
    side: float,
    settings: CardFindingSettings,
) -> tuple[FloatArray, float]:
    """The homography of most corners, and millimetres by which they lie beside it.

    side: of a marker, in pixels.
    """
    import cv2

    on_card = np.concatenate([layout.markers[number].corners for number, _ in markers])
    in_picture = np.concatenate([corners for _, corners in markers]).astype(np.float64)
    homography, inside = cv2.findHomography(on_card, in_picture, cv2.RANSAC, settings.off * side)
    if homography is None or np.count_nonzero(inside) < 4 * settings.fewest:
        raise _not_flat(path, 99.0, settings)
    chosen = inside.ravel() > 0
    homography, _ = cv2.findHomography(on_card[chosen], in_picture[chosen], 0)
    back = cv2.perspectiveTransform(in_picture[None, chosen], np.linalg.inv(homography))[0]
    off = float(np.sqrt(np.mean(np.sum((back - on_card[chosen]) ** 2, axis=1))))
    if off > settings.bent:
        raise _not_flat(path, off, settings)
    return np.asarray(homography, np.float64), off


def _not_flat(path: Path, off: float, settings: CardFindingSettings) -> Exception:
    return capture_error(
        path,
        en=f"expected a flat card, its squares lie up to {min(off, 10):.1f} mm beside their places "
        f"({settings.bent:g} at most); fix it on cardboard",
        zh=f"拍攝卡應平放，方塊卻偏了約 {min(off, 10):.1f} 毫米（最多 {settings.bent:g}）；請貼在硬紙板上",
    )
