"""How each photograph of a capture fits the surface that was made of all: which one should be left out.

A photograph is compared with what Lambert's law makes of the surface under its lamp.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from rumu.capture.photographs import as_argument
from rumu.image_stack import SATURATION, pixels_of
from rumu.surface.frame_check import shift_between
from rumu.surface.near_lamps import shading
from rumu.surface.residual_map import is_lit, lamp_and_residuals, seen_and_law
from rumu.surface.stereo import SHADOW_FLOOR
from rumu.values import Bilingual, BoolArray, Capture, FloatArray, Surface

_EXCHANGED = 8  # most bad photographs among which exchanged lamps are looked for
_NAMED = 3  # bad photographs that are each given a sentence


@dataclass(frozen=True, slots=True)
class PhotographLimits:
    """When a photograph is named as bad.

    residual: times the median of all photographs, and at least this share of the brightness (least_residual).
    moved: pixels of the photograph. sharpness: share of what the surface shows. saturated: of the pixels.
    pixels: most that are looked at. side: of the square in the middle whose sharpness is judged, in pixels.
    """

    residual: float = 3.0
    least_residual: float = 0.03
    moved: float = 3.0
    sharpness: float = 0.5
    saturated: float = 0.2
    pixels: int = 20_000
    side: int = 512

    def bound(self, usual: float) -> float:
        """The residual beyond which a photograph is bad. usual: that of half of them."""
        return max(self.least_residual, self.residual * usual)


@dataclass(frozen=True, slots=True)
class PhotographRow:
    """One photograph.

    strength: of its lamp, mean 1, as the surface shows it. residual: median |brightness - law| in shares of
    the brightness. shadow, saturated: shares of the pixels. sharpness: strength of fine detail as a share of
    what the surface shows under this lamp. moved: pixels by which it lies beside that. aligned: pixels by
    which it was moved to lie there; None where that was not asked for. faults: what is bad about it; empty
    for a good one.
    """

    name: str
    strength: float
    residual: float
    shadow: float
    saturated: float
    sharpness: float
    moved: float
    aligned: float | None = None
    faults: tuple[Bilingual, ...] = ()


def photograph_table(
    capture: Capture,
    surface: Surface,
    *,
    aligned: FloatArray | None = None,
    limits: PhotographLimits | None = None,
) -> list[PhotographRow]:
    """A row for each photograph of a capture, in their order. surface: made of it, with nothing left out.

    aligned: (N,) pixels by which each was moved before, see `rumu.surface.alignment`.
    """
    limits = limits or PhotographLimits()
    chosen = pixels_of(surface.mask, about=limits.pixels)
    values, law = seen_and_law(capture, surface, chosen)
    strength, residual = np.array([_fit_of(one, lit) for one, lit in zip(values, law, strict=True)]).T
    beside = _beside_the_law(capture, surface, limits)
    usual = float(np.median(residual))
    names = capture.names or tuple(f"photograph {i + 1}" for i in range(len(values)))
    rows = []
    for i, name in enumerate(names):
        row = PhotographRow(
            name=name,
            strength=float(strength[i] / strength.mean()),
            residual=float(residual[i]),
            shadow=float((values[i] <= SHADOW_FLOOR).mean()),
            saturated=float((values[i] >= SATURATION).mean()),
            sharpness=beside[i][0],
            moved=beside[i][1],
            aligned=None if aligned is None else float(aligned[i]),
        )
        rows.append(_with_faults(row, usual, limits))
    for i, j in _exchanged(values, law, residual, limits.bound(usual)):
        rows[i] = _with_other_lamp(rows[i], rows[j].name)
    return rows


def _exchanged(
    values: FloatArray, law: FloatArray, residual: FloatArray, bound: float
) -> list[tuple[int, int]]:
    """Photographs that contradict the surface, each with the one whose lamp it fits, which fits its own.

    values, law: (N, P). residual: (N,). bound: residual up to which a photograph fits.
    """
    bad = [int(i) for i in np.flatnonzero(residual > bound)]
    if not 2 <= len(bad) <= _EXCHANGED:
        return []
    found = {i: min((_fit_of(values[i], law[j])[1], j) for j in bad if j != i) for i in bad}
    return [(i, j) for i, (left, j) in found.items() if left <= bound and found[j][1] == i]


def _with_other_lamp(row: PhotographRow, other: str) -> PhotographRow:
    """A row whose fault is that its lamp was exchanged with that of another photograph."""
    told = Bilingual(
        f"像是與 {other} 的燈對調了；若是如此，請在燈位檔裡對調回來",
        f"its lamp seems to be exchanged with that of {other}; if so, exchange them in the file of lamps",
    )
    return replace(row, faults=(told,))


def _fit_of(values: FloatArray, law: FloatArray) -> tuple[float, float]:
    """The strength of a lamp, and the median of what contradicts the law under it. Both arrays (P,)."""
    lit = is_lit(values, law)
    if not lit.any():
        return 1.0, 1.0
    strength, residuals = lamp_and_residuals(values[lit], law[lit])
    return strength, float(np.median(residuals))


def _beside_the_law(
    capture: Capture, surface: Surface, limits: PhotographLimits
) -> list[tuple[float, float]]:
    """Sharpness and movement of each photograph, in a square in the middle of what was measured."""
    width = capture.mask.shape[1]
    square = _square_within(surface.mask, limits.side)
    known = surface.mask[square]
    inner = _inner(known)
    normals, albedo = surface.normals[square], surface.albedo[square]
    albedo = albedo if albedo.ndim == 2 else albedo.mean(axis=2)
    rows, columns = np.ogrid[square[0], square[1]]
    rows, columns = rows[: len(normals)], columns[:, : normals.shape[1]]  # of a small photograph
    pixels = (rows * width + columns).reshape(-1)
    frames = capture.photographs.at(pixels)
    frames = (frames if frames.ndim == 2 else frames.mean(axis=2)).reshape(-1, *normals.shape[:2])
    shown = shading(capture, normals.reshape(-1, 3), pixels).astype(np.float32)
    found = []
    for frame, shade in zip(frames, shown, strict=True):
        wanted = np.maximum(shade.reshape(normals.shape[:2]), np.float32(0)) * albedo
        sharpness = _detail(frame, inner) / max(_detail(wanted, inner), 1e-9)
        found.append((sharpness, shift_between(frame, wanted, within=known)))
    return found


def _square_within(mask: BoolArray, side: int) -> tuple[slice, slice]:
    """Rows and columns of a square, or of what of it is in the picture, about the middle of a mask (H, W)."""
    found = []
    for axis, length in enumerate(mask.shape):
        weight = np.count_nonzero(mask, axis=1 - axis)
        middle = float(weight @ np.arange(length)) / max(1, int(weight.sum()))
        start = int(np.clip(round(middle - (side - 1) / 2), 0, max(0, length - side)))
        found.append(slice(start, start + side))
    return found[0], found[1]


def _inner(mask: BoolArray) -> BoolArray:
    """A mask (h, w) without its rim, over which details reach; the mask itself where nothing else is left."""
    import cv2

    inner = cv2.erode(mask.astype(np.uint8), np.ones((9, 9), np.uint8), borderValue=1) > 0
    return np.asarray(inner if inner.any() else mask)


def _detail(frame: FloatArray, within: BoolArray) -> float:
    """How strong the finest detail of a part of a frame (h, w) is beside its brightness, noise left out."""
    import cv2

    smooth = cv2.GaussianBlur(np.ascontiguousarray(frame, dtype=np.float32), (0, 0), 1.0)
    edges = np.abs(cv2.Laplacian(smooth, cv2.CV_32F))
    return float(np.quantile(edges[within], 0.95)) / max(float(frame[within].mean()), 1e-6)


def _with_faults(row: PhotographRow, usual: float, limits: PhotographLimits) -> PhotographRow:
    share = f"{100 * row.residual:.1f}%"
    tests = (
        (
            row.residual > limits.bound(usual),
            Bilingual(f"亮度有 {share} 與表面不合", f"{share} of its brightness contradicts the surface"),
        ),
        (
            row.moved > limits.moved,
            Bilingual(f"錯開了 {row.moved:.1f} 像素", f"it lies {row.moved:.1f} pixels beside the others"),
        ),
        (
            row.sharpness < limits.sharpness,
            Bilingual("不清晰", "it is blurred"),
        ),
        (
            row.saturated > limits.saturated,
            Bilingual(f"{100 * row.saturated:.0f}% 過曝", f"{100 * row.saturated:.0f}% of it is overexposed"),
        ),
    )
    return replace(row, faults=tuple(words for holds, words in tests if holds))


def fault_notes(rows: Sequence[PhotographRow]) -> tuple[Bilingual, ...]:
    """One sentence for each photograph that is named as bad, or one for all when they are many."""
    bad = [row for row in rows if row.faults]
    if len(bad) > _NAMED:
        worst = sorted(bad, key=lambda row: -row.residual)[:_NAMED]
        zh, en = ("、".join(row.name for row in worst), ", ".join(row.name for row in worst))
        return (
            Bilingual(
                f"有 {len(bad)} 張照片不合，最差的是 {zh}；可用 --leave-out 除去。",
                f"{len(bad)} photographs fit badly, {en} worst; --leave-out does without them",
            ),
        )
    return tuple(
        Bilingual(
            f"{row.name}：{'；'.join(fault.zh for fault in row.faults)}。"
            f"可用 --leave-out {as_argument(row.name)} 除去。",
            f"{row.name}: {'; '.join(fault.en for fault in row.faults)}. "
            f"--leave-out {as_argument(row.name)} does without it",
        )
        for row in bad
    )


def table_text(rows: Sequence[PhotographRow]) -> str:
    """The table as lines of text, one photograph in each."""
    width = max(len(row.name) for row in rows)
    was_aligned = any(row.aligned is not None for row in rows)
    head = f"  {'':<{width}}  strength  residual  shadow  white  sharpness  moved" + "  aligned" * was_aligned
    lines = [
        f"  {row.name:<{width}}{row.strength:10.2f}{100 * row.residual:8.1f}%{100 * row.shadow:6.0f}%"
        f"{100 * row.saturated:5.0f}%"
        f"{row.sharpness:11.2f}{row.moved:7.1f}" + (f"{row.aligned:9.2f}" if row.aligned is not None else "")
        for row in rows
    ]
    return "\n".join([head, *lines])
