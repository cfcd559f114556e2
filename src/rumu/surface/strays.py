"""What lies on a picture of writing and is not the writing: frames, seals, edges, specks, neighbours."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from rumu.surface.paper import FLAT, Bools, Bytes, Floats, ink_box

Doubles = npt.NDArray[np.float64]
Stats = npt.NDArray[np.int32]
Box = tuple[int, int, int, int]
"""Rows y0:y1 and columns x0:x1 of a picture."""


@dataclass(frozen=True, slots=True)
class StrayLimits:
    """When a connected part of the ink is no part of the character; lengths are shares of the side.

    speck: largest speck, in pixels of a 256 x 256 picture.
    speck_share: the same as a share of the ink, for small characters.
    rim, rim_share: a part that touches the border, lies wholly in this outer band, and is below this share
        of the ink.
    edge_contact: a part of the outer band that runs along the border for this long is an edge of the page.
    neighbour_share, neighbour_band, gap: a larger part that touches the border, within this band, and that
        stands clear of the rest by this gap, is the ink of a neighbouring character.
    caption_share, caption_band: a small part that stands clear in this outer band is a printed caption.
    """

    speck: float = 30.0
    speck_share: float = 0.01
    rim: float = 0.12
    rim_share: float = 0.05
    edge_contact: float = 0.35
    neighbour_share: float = 0.25
    neighbour_band: float = 0.30
    gap: float = 0.03
    caption_share: float = 0.03
    caption_band: float = 0.10


# --- the frame of a crop --------------------------------------------------------------------------


def inner_box(view: Bytes) -> Box:
    """The picture within a flat frame around it and within flat strips along its sides; all of it if none."""
    height, width = view.shape[:2]
    colours = view.reshape(height, width, -1)
    ring = np.concatenate([colours[0], colours[-1], colours[:, 0], colours[:, -1]])
    frame = np.median(ring, axis=0)
    if (np.abs(ring - frame).max(axis=1) <= 2 * FLAT).mean() > 0.98:
        return _within_frame(colours, frame)
    return _within_strips(colours)


def _within_frame(colours: Bytes, frame: Floats) -> Box:
    """The rectangle of paper inside a frame of one constant colour, as museums' crops are padded.

    Blank digital paper is flat too. There what lies inside is ink: it leaves flat paper between its strokes
    and no texture in the corners of its box. So all four corners must be busy, and no block may be flat.
    """
    import cv2

    whole = (0, colours.shape[0], 0, colours.shape[1])
    active = np.zeros(colours.shape[:2], np.uint8)
    for k in range(colours.shape[2]):
        active |= cv2.absdiff(colours[:, :, k], float(frame[k])).astype(np.uint8) > FLAT  # type: ignore[call-overload]
    rows, columns = (_shares(active, axis=axis) for axis in (1, 0))
    spans = []
    for share in (rows, columns):
        busy = share[share > 0.02]
        span = np.flatnonzero(share > (0.5 * np.median(busy) if len(busy) else 1.0))
        if len(span) < 8:
            return whole
        spans.append((int(span[0]), int(span[-1]) + 1))
    (y0, y1), (x0, x1) = spans
    if (y0, y1, x0, x1) == whole:
        return whole
    part = active[y0:y1, x0:x1]
    k = max(4, min(part.shape) // 16)
    corners = [part[:k, :k], part[:k, -k:], part[-k:, :k], part[-k:, -k:]]
    if part.size < 0.08 * active.size or min(float(c.mean()) for c in corners) < 0.3:
        return whole
    inside = np.median(colours[y0:y1, x0:x1].reshape(-1, colours.shape[2]), axis=0)
    if np.abs(inside - frame).max() > 60 or (cv2.blur(part.astype(np.float32), (9, 9)) < 0.01).mean() > 0.02:
        return whole
    return y0, y1, x0, x1


def _shares(active: Bytes, *, axis: int) -> Doubles:
    """Mean of 0 and 1 along an axis."""
    import cv2

    sums = cv2.reduce(active, axis, cv2.REDUCE_SUM, dtype=cv2.CV_32S)
    return np.asarray(sums.ravel() / active.shape[axis])


def _within_strips(colours: Bytes) -> Box:
    """Cut flat strips off each side (the white band of a site's watermark): rows of one colour, then none."""
    top, bottom = _strip(colours), _strip(colours[::-1])
    turned = colours.transpose(1, 0, 2)
    left, right = _strip(turned), _strip(turned[::-1])
    height, width = colours.shape[:2]
    return top, height - bottom, left, width - right


def _strip(rows: Bytes) -> int:
    """Rows to cut from the top: at most 15 % of the side; 0 where there is no strip."""
    depth = max(3, int(0.15 * rows.shape[0]))
    band = rows[: depth + 4].astype(np.int16)
    colour = np.median(band[0], axis=0)
    flat = (np.abs(band - colour).max(axis=2) <= 6 * FLAT).mean(axis=1)
    inside = np.flatnonzero(flat < 0.25)
    if flat[0] < 0.85 or len(inside) == 0 or inside[0] < 2 or inside[0] >= depth:
        return 0
    if flat[inside[0] + 1 : inside[0] + 4].max(initial=0.0) > 0.1:
        return 0
    return int(inside[0]) + 1


# --- colour ----------------------------------------------------------------------------------------


def red_marks(view: Bytes, *, paper: Doubles, on_dark: bool) -> Bools:
    """(H, W) bool: seals, red grids, printed addresses.

    view: (H, W, 3) uint8. paper: (3,) colour of the paper, 0-255; its own brown is divided out, so that silk
    does not count as red. On a dark ground there is nothing to divide by, and strokes are as brown as paper.
    Old ink is brown: a connected reddish part is a seal only if enough of it is plainly red.
    """
    import cv2

    gains = np.ones(3) if on_dark else np.maximum(paper.max(), 1.0) / np.maximum(paper, 1.0)
    table = np.stack([np.clip(np.arange(256) * g, 0, 255) for g in gains], axis=1).astype(np.uint8)
    r, g, b = cv2.split(cv2.LUT(view, table[:, None, :]))
    excess = cv2.subtract(r, cv2.max(g, b))
    if on_dark:
        return np.asarray((excess > 25) & (excess > cv2.convertScaleAbs(r, alpha=0.35)))
    reddish = (excess > 0.09 * float(paper.max())) & (excess > cv2.convertScaleAbs(r, alpha=0.2))
    if not reddish.any():
        return np.asarray(reddish)
    red = reddish & (excess > cv2.convertScaleAbs(r, alpha=0.35))
    _, parts = cv2.connectedComponents(reddish.astype(np.uint8), connectivity=8)
    share = np.bincount(parts[red], minlength=int(parts.max()) + 1) / np.bincount(parts.ravel())
    return np.asarray(reddish & (share > 0.2)[parts])


# --- parts of the ink ------------------------------------------------------------------------------


def drop_strays(mask: Bools, *, limits: StrayLimits) -> tuple[Bools, dict[str, int]]:
    """The ink without specks, edges of the page, neighbours' ink and captions; pixels of each kind."""
    import cv2

    left_out = {"speck": 0, "edge": 0, "neighbour": 0, "caption": 0}
    if not mask.any():
        return mask, left_out
    y0, y1, x0, x1 = ink_box(mask)
    box = (
        slice(y0, y1),
        slice(x0, x1),
    )  # labelling costs by the pixel; of OpenCV's ways this is the quickest
    _, labels, stats, _ = cv2.connectedComponentsWithStatsWithAlgorithm(
        mask[box].astype(np.uint8), 8, cv2.CV_32S, cv2.CCL_GRANA
    )
    stats[:, :2] += (x0, y0)
    area = stats[1:, cv2.CC_STAT_AREA].astype(np.int64)
    scale = mask.size / 65536.0
    limit = min(limits.speck * scale, limits.speck_share * float(area.sum()))
    kept = area > min(limit, area.max() - 1)
    left_out["speck"] = int(area[~kept].sum())
    for kind, test in (("edge", _edges), ("neighbour", _neighbours), ("caption", _captions)):
        stray = kept & test(stats[1:], mask.shape, kept, limits)
        left_out[kind] = int(area[stray].sum())
        kept = kept & ~stray
    if kept.all():
        return mask, left_out
    clean = np.zeros_like(mask)
    clean[box] = np.concatenate([[False], kept])[labels]
    return clean, left_out


def _sides(stats: Stats, shape: tuple[int, ...]) -> Doubles:
    """(N, 4, 2): nearest and farthest reach of each part from top, bottom, left and right, as shares."""
    height, width = shape
    x, y, w, h = (stats[:, k].astype(np.float64) for k in range(4))
    near = np.stack([y / height, 1 - (y + h) / height, x / width, 1 - (x + w) / width], axis=1)
    far = np.stack([(y + h) / height, 1 - y / height, (x + w) / width, 1 - x / width], axis=1)
    return np.stack([near, far], axis=2)


def _touches(sides: Doubles, shape: tuple[int, ...]) -> Bools:
    """(N, 4) bool: the part reaches the border, give or take a pixel."""
    height, width = shape
    pixel = np.array([1.01 / height, 1.01 / height, 1.01 / width, 1.01 / width])
    return np.asarray(sides[:, :, 0] <= pixel)


def _edges(stats: Stats, shape: tuple[int, ...], kept: Bools, limits: StrayLimits) -> Bools:
    """Parts at the border: small ones, and long ones that run along it."""
    sides = _sides(stats, shape)
    touch = _touches(sides, shape)
    area = stats[:, 4]
    in_rim = touch & (sides[:, :, 1] <= limits.rim)
    small = in_rim.any(axis=1) & (area < limits.rim_share * area[kept].sum())
    length = np.stack([stats[:, 2] / shape[1]] * 2 + [stats[:, 3] / shape[0]] * 2, axis=1)
    long = (in_rim & (length >= limits.edge_contact)).any(axis=1)
    others = area[kept & ~(small | long)].sum() if (kept & ~(small | long)).any() else 0
    return np.asarray(small | (long & (others > 0)))


def _clear_of_rest(stats: Stats, candidate: Bools, kept: Bools, shape: tuple[int, ...]) -> Doubles:
    """(N,) gap between the box of each candidate and the box of all other ink, as a share of the side."""
    rest = kept & ~candidate
    if not rest.any():
        return np.zeros(len(stats))
    x, y, w, h = (stats[:, k] for k in range(4))
    x0, y0 = x[rest].min(), y[rest].min()
    x1, y1 = (x + w)[rest].max(), (y + h)[rest].max()
    across = np.maximum(x0 - (x + w), x - x1) / shape[1]
    down = np.maximum(y0 - (y + h), y - y1) / shape[0]
    return np.asarray(np.maximum(across, down))


def _neighbours(stats: Stats, shape: tuple[int, ...], kept: Bools, limits: StrayLimits) -> Bools:
    sides = _sides(stats, shape)
    near = (_touches(sides, shape) & (sides[:, :, 1] <= limits.neighbour_band)).any(axis=1)
    candidate = kept & near & (stats[:, 4] < limits.neighbour_share * stats[kept, 4].sum())
    return np.asarray(candidate & (_clear_of_rest(stats, candidate, kept, shape) > limits.gap))


def _captions(stats: Stats, shape: tuple[int, ...], kept: Bools, limits: StrayLimits) -> Bools:
    in_band = (_sides(stats, shape)[:, :, 1] <= limits.caption_band).any(axis=1)
    candidate = kept & in_band & (stats[:, 4] < limits.caption_share * stats[kept, 4].sum())
    return np.asarray(candidate & (_clear_of_rest(stats, candidate, kept, shape) > limits.gap))
