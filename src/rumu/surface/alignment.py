"""Photographs between which the camera moved a little, laid on each other before they are solved.

Under other lamps a sheet looks other: only its edges stay. So each photograph is laid, by the strength of
its edges, first on what all have in common (phase correlation, which finds shifts of any size), then on
what the others say it should look like under its lamp, by shift and turn (ECC: Evangelidis and Psarakis,
"Parametric Image Alignment using Enhanced Correlation Coefficient Maximization", 2008), a few times over.
Both are OpenCV's.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from rumu.errors import CaptureError
from rumu.image_stack import ImageStack, Photograph, Progress, ScratchFile
from rumu.surface.frame_check import displacement
from rumu.values import Bilingual, BoolArray, Capture, FloatArray

_FLOOR = np.float32(1e-3)  # of white, so that noise in the dark makes no edges


@dataclass(frozen=True, slots=True)
class FrameAlignmentSettings:
    """How photographs are laid on each other.

    side: pixels of the longer side at which that is found. rounds: times that each is laid, first on what all
    have in common, then on what the others say.
    wide: spread of the light around, in pixels, that is taken out before edges are looked for. least:
    pixels of the photograph below which it is left as it is, since every move softens. warned: pixels from
    which a photograph is named. farthest: share of the shorter side, beyond which a shift is no camera's
    that moved.
    likeness: least correlation of the edges in the end. clearly: share of what it lacked of 1 that may be
    left, since light moves edges, too. steps, step: most steps of ECC, and the gain at which it ends.
    blur: width of its filter, in pixels. repeated: correlation of the edges with themselves, moved, from
    which a sheet repeats itself. doubted: share of that move from which a photograph may have moved so far,
    or so far less.
    """

    side: int = 1600
    rounds: int = 2
    wide: float = 12.0
    least: float = 0.08
    warned: float = 3.0
    farthest: float = 0.15
    likeness: float = 0.25
    clearly: float = 0.85
    steps: int = 60
    step: float = 1e-6
    blur: int = 5
    repeated: float = 0.75
    doubted: float = 0.2


@dataclass(frozen=True, slots=True, eq=False)
class AlignedCapture:
    """A capture whose photographs lie on each other.

    capture: the photographs, and a mask of what all show. moved: (N,) pixels by which each was moved, the
    most of any corner; 0 of one that was left as it was.
    """

    capture: Capture
    moved: FloatArray


def align_photographs(
    capture: Capture, *, settings: FrameAlignmentSettings | None = None, progress: Progress | None = None
) -> AlignedCapture:
    """Lay the photographs of a capture on each other, to fractions of a pixel.

    Parameters
    ----------
    capture
        Four photographs or more; with three lamps nothing says what one should look like, and they are laid
        on what all have in common.
    settings, progress
        See `FrameAlignmentSettings`; called with what is done, how many parts are done, and of how many.

    Returns
    -------
    AlignedCapture
        Most photographs stay where they are; those that lie beside them are moved and turned. Notes name
        those that moved by more than three pixels, and those that could not be laid on the others and stay
        as they are.

    Raises
    ------
    CaptureError
        When the photographs have nothing in common after being moved.
    """
    settings = settings or FrameAlignmentSettings()
    stack = capture.photographs
    height, width = stack.shape[1:3]
    scale = max(1.0, max(height, width) / settings.side)
    size = (round(width / scale), round(height / scale))
    frames = np.stack([_gray(stack.reduced(i, size)) for i in range(len(stack))])
    finder = _Finder(frames, capture.lights, settings)
    poses, lost, period = finder.poses(progress)
    ratio = np.array([width / size[0], height / size[1]])
    maps = [_at_full_size(finder.matrix(pose), ratio) for pose in poses]
    moved = np.array([_farthest(one, (height, width)) for one in maps])
    moved[moved < settings.least] = 0.0
    if len(lost) == len(stack):
        raise CaptureError(
            "expected photographs of one sheet, got some that cannot be laid on each other",
            zh="這些照片無法互相對齊；應是同一張紙的照片。",
        )
    seen = capture.mask.copy()
    for far, one in zip(moved, maps, strict=True):
        if far:
            seen &= _is_seen(one, (height, width))
    if not seen.any():
        raise CaptureError(
            "expected something that all photographs show, got nothing after they were laid on each other",
            zh="對齊之後，沒有所有照片都拍到的部分。",
        )

    def laid(number: int, photograph: Photograph) -> Photograph:
        if progress is not None:
            progress("Laying photographs on each other", number + 1, len(stack))
        return photograph if not moved[number] else _warped(photograph, maps[number])

    names = [*capture.names] or [f"photograph {i + 1}" for i in range(len(moved))]
    notes = _notes(names, moved, lost, settings, period=scale * period)
    whole: ImageStack = stack.mapped(laid)
    return AlignedCapture(capture.changed(images=whole, mask=seen, notes=(*capture.notes, *notes)), moved)


@dataclass(frozen=True, slots=True, eq=False)
class _Finder:
    """Reduced photographs (N, h, w) under their lamps (N, 3)."""

    frames: FloatArray
    lights: FloatArray
    settings: FrameAlignmentSettings

    def poses(self, progress: Progress | None) -> tuple[FloatArray, list[int], float]:
        """(N, 3): x, y and turn of each frame against most; the numbers of those that are lost; `_period`."""
        edges = np.stack([self._edges(frame) for frame in self.frames])
        poses = self._shifts(edges)
        rounds, lost = self.settings.rounds, set[int]()
        for turn in range(rounds):
            laid = np.stack([_moved(f, self.matrix(p)) for f, p in zip(self.frames, poses, strict=True)])
            common = np.median([self._edges(one) for one in laid], axis=0) if turn == 0 else None
            found = poses.copy()
            lost.clear()
            for number in range(len(edges)):
                wanted = self._edges(self._wanted(laid, number)) if common is None else common
                pose = self._refined(wanted, edges[number], poses[number])
                if pose is None:
                    pose = self._by_the_others(laid, edges[number], number)
                if pose is None:
                    lost.add(number)
                    found[number] = 0.0
                else:
                    found[number] = pose
                if progress is not None:
                    done = turn * len(edges) + number + 1
                    progress("Finding how the camera moved", done, rounds * len(edges))
            kept = [i for i in range(len(found)) if i not in lost]
            poses = found - (np.median(found[kept], axis=0) if kept else 0.0)
            poses[sorted(lost)] = 0.0
        return poses, sorted(lost), self._usual_period(edges) if np.abs(poses[:, :2]).max() > 1 else np.inf

    def _usual_period(self, edges: FloatArray) -> float:
        """The `_period` of a few frames, each of which shows it by itself, whether it moved or not."""
        some = edges[:: max(1, len(edges) // 3)][:3]
        return float(np.median([_period(one, self.settings) for one in some]))

    @property
    def _middle(self) -> FloatArray:
        """(2,) x and y of the middle of a frame."""
        return (np.array(self.frames.shape[:0:-1]) - 1) / 2

    def matrix(self, pose: FloatArray) -> FloatArray:
        """(2, 3) float64: from a place of the sheet to its place in a frame turned about its middle."""
        x, y, turn = pose
        turned = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
        return np.column_stack([turned, self._middle - turned @ self._middle + (x, y)])

    def _edges(self, frame: FloatArray) -> FloatArray:
        """(h, w) float32: how strong the edges are, beside the light around them."""
        import cv2

        even = frame / (cv2.GaussianBlur(frame, (0, 0), self.settings.wide) + _FLOOR)
        smooth = cv2.GaussianBlur(even, (0, 0), 0.8)
        strength = np.hypot(cv2.Sobel(smooth, cv2.CV_32F, 1, 0), cv2.Sobel(smooth, cv2.CV_32F, 0, 1))
        return np.asarray(np.minimum(strength, 4 * np.quantile(strength[::4, ::4], 0.95)), np.float32)

    def _shifts(self, edges: FloatArray) -> FloatArray:
        """(N, 3) x, y and a turn of 0, by phase correlation with the median of all edges."""
        import cv2

        common = np.median(edges, axis=0).astype(np.float32)
        window = cv2.createHanningWindow(common.shape[::-1], cv2.CV_32F)
        shifts = np.array([cv2.phaseCorrelate(common, one, window)[0] for one in edges])
        shifts -= np.median(shifts, axis=0)
        too_far = np.hypot(*shifts.T) > self.settings.farthest * min(common.shape)
        shifts[too_far] = 0.0
        return np.column_stack([shifts, np.zeros(len(shifts))])

    def _wanted(self, laid: FloatArray, number: int) -> FloatArray:
        """(h, w) what the others say that a frame should look like; their mean under three lamps."""
        others = np.delete(np.arange(len(laid)), number)
        if len(others) < 3 or np.linalg.matrix_rank(self.lights[others], tol=0.05) < 3:
            return np.asarray(laid[others].mean(axis=0), np.float32)
        weights = (self.lights[number] @ np.linalg.pinv(self.lights[others])).astype(np.float32)
        return np.maximum(np.tensordot(weights, laid[others], axes=1), np.float32(0))

    def _by_the_others(self, laid: FloatArray, edges: FloatArray, number: int) -> FloatArray | None:
        """The pose of one frame, begun where its brightness lies on what the others say; None for none.

        For writing that is alike in many places, so that edges alone lead astray.
        """
        wanted = self._wanted(laid, number)
        start = (*displacement(self.frames[number], wanted), 0.0)
        return self._refined(self._edges(wanted), edges, np.array(start))

    def _refined(self, wanted: FloatArray, edges: FloatArray, start: FloatArray) -> FloatArray | None:
        """(3,) the pose of one frame's edges on those that are wanted; None where it has none."""
        import cv2

        s = self.settings
        criteria = (cv2.TERM_CRITERIA_EPS | cv2.TERM_CRITERIA_COUNT, s.steps, s.step)
        first = self.matrix(start).astype(np.float32)
        before = _likeness(wanted, edges)
        try:
            _, matrix = cv2.findTransformECC(
                wanted, edges, first, cv2.MOTION_EUCLIDEAN, criteria, np.empty(0, np.uint8), s.blur
            )
        except cv2.error:  # it does not converge
            return None
        shift = matrix @ (*self._middle, 1) - self._middle
        pose = np.array([*shift, np.arctan2(matrix[1, 0], matrix[0, 0])], np.float64)
        if np.hypot(*shift) + abs(pose[2]) * np.hypot(*self._middle) > s.farthest * min(edges.shape):
            return None
        after = _likeness(wanted, _moved(edges, self.matrix(pose)))
        if after < s.likeness:
            return None
        return pose if 1 - after < s.clearly * (1 - before) else np.zeros(3)


def _period(edges: FloatArray, settings: FrameAlignmentSettings) -> float:
    """The shortest move, in pixels, after which edges (h, w) are much as before; infinite where none is."""
    from scipy import fft, ndimage

    height, width = edges.shape
    sides = [np.hanning(size).astype(np.float32) for size in (height, width)]
    window = np.outer(*sides)
    uneven = (edges - np.average(edges, weights=window)).astype(np.float32) * window
    power = np.abs(fft.rfft2(uneven, (2 * height, 2 * width), workers=-1)) ** 2
    alike = fft.fftshift(fft.irfft2(power, (2 * height, 2 * width), workers=-1))
    common = np.outer(*(np.pad(np.correlate(one, one, "full"), (1, 0)) for one in sides))
    middle = (height // 2, width // 2)
    near = tuple(slice(size - half, size + half) for size, half in zip((height, width), middle, strict=True))
    alike = alike[near] / np.maximum(common[near], 1e-6 * common.max())
    share = alike / max(float(alike[middle]), 1e-12)
    parts, count = ndimage.label(share > settings.repeated)
    if not alike[middle] > 0 or count < 2:
        return np.inf
    numbers = [number for number in range(1, count + 1) if number != parts[middle]]
    peaks = ndimage.maximum_position(share, parts, numbers)
    return float(np.hypot(*(np.array(peaks) - middle).T).min())


def _gray(frame: FloatArray) -> FloatArray:
    return np.ascontiguousarray(frame if frame.ndim == 2 else frame.mean(axis=2), np.float32)


def _moved(frame: FloatArray, matrix: FloatArray) -> FloatArray:
    """A frame as it would be if the camera had not moved; of any type of samples."""
    import cv2

    flags = cv2.INTER_CUBIC | cv2.WARP_INVERSE_MAP
    size = (frame.shape[1], frame.shape[0])
    moved = cv2.warpAffine(frame, matrix, size, flags=flags, borderMode=cv2.BORDER_REPLICATE)
    return np.asarray(np.maximum(moved, 0), frame.dtype)  # a cubic swings below black


def _likeness(wanted: FloatArray, edges: FloatArray) -> float:
    """Correlation of edges, from -1 to 1, without a margin where moving left nothing."""
    margin = max(2, min(wanted.shape) // 20)
    a, b = (one[margin:-margin, margin:-margin].reshape(-1) for one in (wanted, edges))
    return float(np.corrcoef(a, b)[0, 1]) if a.std() > 0 and b.std() > 0 else 0.0


def _at_full_size(matrix: FloatArray, ratio: FloatArray) -> FloatArray:
    """(2, 3): the same in pixels of the photograph. ratio: (2,) of them for each reduced pixel, x and y."""
    grow = np.array([[ratio[0], 0, (ratio[0] - 1) / 2], [0, ratio[1], (ratio[1] - 1) / 2], [0, 0, 1]])
    whole = grow @ np.vstack([matrix, (0, 0, 1)]) @ np.linalg.inv(grow)
    return np.asarray(whole[:2])


def _farthest(matrix: FloatArray, shape: tuple[int, int]) -> float:
    """By how many pixels the farthest corner of a photograph moves."""
    height, width = shape
    corners = np.array([[0, 0, 1], [width - 1, 0, 1], [0, height - 1, 1], [width - 1, height - 1, 1]], float)
    return float(np.hypot(*(corners @ matrix.T - corners[:, :2]).T).max())


def _is_seen(matrix: FloatArray, shape: tuple[int, int]) -> BoolArray:
    """(H, W) bool: what a photograph that was moved shows, but for its outermost pixels."""
    import cv2

    inside = np.zeros(shape, np.uint8)
    inside[2:-2, 2:-2] = 1
    flags = cv2.INTER_NEAREST | cv2.WARP_INVERSE_MAP
    return np.asarray(cv2.warpAffine(inside, matrix, shape[::-1], flags=flags)) > 0


def _warped(photograph: Photograph, matrix: FloatArray) -> Photograph:
    """A photograph moved in its own bits; it stays in memory or on disk as it was."""
    samples = photograph.samples
    if not isinstance(samples, ScratchFile):
        return replace(photograph, samples=_moved(samples, matrix))
    return replace(photograph, samples=ScratchFile(_moved(samples.whole(), matrix)))


def _notes(
    names: list[str], moved: FloatArray, lost: list[int], settings: FrameAlignmentSettings, *, period: float
) -> list[Bilingual]:
    """period: in pixels of the photograph, see `_period`."""
    notes = []
    doubtful = [name for name, by in zip(names, moved, strict=True) if by > settings.doubted * period]
    if doubtful:
        notes.append(
            Bilingual(
                f"這張紙每 {period:.0f} 像素就重複一次（如織物、印好的格子），"
                f"所以 {'、'.join(doubtful)} 也可能對錯了一格；請看結果，或固定好相機再拍。",
                f"the sheet repeats itself every {period:.0f} pixels, as cloth or a printed grid does, so "
                f"{', '.join(doubtful)} may lie off by just that: look at the result, or photograph again "
                "with a camera that stands still",
            )
        )
    far = [f"{name} ({by:.1f})" for name, by in zip(names, moved, strict=True) if by > settings.warned]
    if far:
        notes.append(
            Bilingual(
                f"移動超過 {settings.warned:g} 像素：{'、'.join(far)}；已對齊，但相機應固定好再拍。",
                f"moved by more than {settings.warned:g} pixels: {', '.join(far)}; laid on the others, but "
                "the camera should stand still",
            )
        )
    if lost:
        which = [names[i] for i in lost]
        notes.append(
            Bilingual(
                f"{'、'.join(which)}：無法與其他照片對齊，保持原樣。",
                f"{', '.join(which)}: cannot be laid on the others, left as it was",
            )
        )
    return notes
