"""Photographs of one size, kept in their own bits: linear light is computed where it is asked for.

Twenty photographs of 24 megapixels take 0.5 GB in 8 bits and 1.9 GB as floats; sixty of 100 take 6 and 24.
So the samples stay as the files stored them, each with the curve that makes linear light of its levels, and
lie in a scratch file when memory is short. Whoever computes takes a range of pixels of all photographs at a
time.
"""

from __future__ import annotations

import mmap
import os
import tempfile
import threading
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, fields
from typing import Any, Protocol, Self, TypeVar

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.floating[Any]]
Samples = npt.NDArray[Any]
Pixels = npt.NDArray[np.integer[Any]]
Answer = TypeVar("Answer")

SATURATION = 0.998
"""Share of white from which a value says nothing but that there was more light."""
_LEVELS = {"uint8": 256, "uint16": 65536}
Progress = Callable[[str, int, int], None]
"""Called with what is being done, in English, how many parts of it are done, and how many there are."""
_FINER = 4  # times the side that is wanted, to which a large photograph is reduced in its own bits
_BAND = 2_000_000
"""Pixels of one photograph that are converted at a time when a whole one is asked for."""


def pixels_of(mask: npt.NDArray[np.bool_], *, about: int) -> npt.NDArray[np.intp]:
    """Numbers of about so many pixels of a mask (H, W), every k-th, counted row by row."""
    count = int(np.count_nonzero(mask))
    step = max(1, count // about)
    if count == mask.size:  # the numbers of all pixels would take more memory than the photographs
        return np.arange(0, count, step)
    return np.flatnonzero(mask)[::step].copy()


def begin(what: str, progress: Progress | None) -> None:
    """Tell that something is begun whose parts are not counted."""
    if progress is not None:
        progress(what, 0, 1)


class ScratchFile:
    """Samples of one photograph on disk, in a file without a name that goes with the last reference to it."""

    def __init__(self, samples: Samples) -> None:
        self.shape, self.dtype = samples.shape, samples.dtype
        self._file = tempfile.TemporaryFile(prefix="rumu-")  # noqa: SIM115  lives as long as this object
        self._lock = threading.Lock()
        self._file.write(np.ascontiguousarray(samples).data.cast("B"))
        self._file.flush()

    def range(self, start: int, stop: int) -> Samples:
        """(stop - start[, 3]), the samples of a range of pixels, counted row by row."""
        pixel = self.dtype.itemsize * int(np.prod(self.shape[2:], dtype=int))
        wanted = np.empty((stop - start, *self.shape[2:]), self.dtype)
        view = wanted.data.cast("B")
        if hasattr(os, "preadv"):
            done = 0
            while done < len(view):
                done += os.preadv(self._file.fileno(), [view[done:]], start * pixel + done)
        else:
            with self._lock:
                self._file.seek(start * pixel)
                self._file.readinto(view)  # type: ignore[attr-defined]
        return wanted

    def whole(self) -> Samples:
        """(H, W) or (H, W, 3), all samples."""
        return self.range(0, self.shape[0] * self.shape[1]).reshape(self.shape)

    def at(self, pixels: Pixels) -> Samples:
        """(P[, 3]), the samples of some pixels, by their numbers."""
        with mmap.mmap(self._file.fileno(), 0, access=mmap.ACCESS_READ) as mapped:
            whole = np.frombuffer(mapped, self.dtype).reshape(-1, *self.shape[2:])
            found = whole[pixels]
            del whole
        return np.asarray(found)


@dataclass(frozen=True, slots=True, eq=False)
class Photograph:
    """One photograph as its file stored it.

    samples: (H, W) or (H, W, 3) uint8, uint16 or float32, in memory or on disk. curve: (256,) or (65536,)
    float32, the linear light of each level; None where the samples are linear, of which white is 1. opaque:
    (H, W) bool, where the file shows the sheet and not what lies behind it; None where it does all over.
    """

    samples: Samples | ScratchFile
    curve: Floats | None = None
    opaque: npt.NDArray[np.bool_] | None = None

    def range(self, start: int, stop: int, *, out: Floats | None = None) -> Floats:
        """(stop - start[, 3]) float32, linear light of a range of pixels, counted row by row.

        out: where it is written, if it is given; float32, contiguous.
        """
        if isinstance(self.samples, ScratchFile):
            return self._linear(self.samples.range(start, stop), out)
        return self._linear(self.samples.reshape(-1, *self.samples.shape[2:])[start:stop], out)

    def at(self, pixels: Pixels) -> Floats:
        """(P[, 3]) float32, linear light of some pixels, by their numbers."""
        if isinstance(self.samples, ScratchFile):
            return self._linear(self.samples.at(pixels))
        return self._linear(self.samples.reshape(-1, *self.samples.shape[2:])[pixels])

    def light(self) -> Floats:
        """(H, W) or (H, W, 3) float32, linear light of the whole photograph."""
        height, width = self.samples.shape[:2]
        return self.range(0, height * width).reshape(self.samples.shape)

    def parts(self) -> Iterator[Floats]:
        """The whole photograph, a range of pixels at a time."""
        pixels = self.samples.shape[0] * self.samples.shape[1]
        return (self.range(start, min(start + _BAND, pixels)) for start in range(0, pixels, _BAND))

    def reduced(self, size: tuple[int, int]) -> Floats:
        """Linear light of a few times this size (w, h), or of the photograph's own where it has no more."""
        import cv2

        height, width = self.samples.shape[:2]
        if width <= _FINER * size[0] or height <= _FINER * size[1]:
            return self.light()
        whole = self.samples.whole() if isinstance(self.samples, ScratchFile) else self.samples
        finer = (_FINER * size[0], _FINER * size[1])
        return self._linear(np.asarray(cv2.resize(whole, finer, interpolation=cv2.INTER_AREA)))

    def _linear(self, samples: Samples, out: Floats | None = None) -> Floats:
        values = np.empty(samples.shape, np.float32) if out is None else out
        levels = _LEVELS.get(samples.dtype.name)
        curve = None if self.curve is None else np.asarray(self.curve, dtype=np.float32)
        if curve is not None and samples.dtype == np.uint8:
            import cv2

            if samples.size:
                cv2.LUT(samples.reshape(1, -1), curve, dst=values.reshape(1, -1))
        elif curve is not None:
            np.take(curve, samples, out=values, mode="clip")
        elif levels is not None:
            np.divide(samples, np.float32(levels - 1), out=values, dtype=np.float32)
        else:
            values[...] = samples
        return values


class Gain(Protocol):
    """By what a photograph is multiplied in each place, such as where the light was uneven."""

    def at(self, pixels: Pixels) -> Floats:
        """(P,) float32 factors, above 0 and at most 1, of some pixels by their numbers."""


class ImageStack:
    """N photographs of one shape as linear light, computed where it is asked for.

    shape: (N, H, W) or (N, H, W, 3). dark: a photograph with all lamps off, taken from each, as far as that
    leaves 0. peak: by which all are divided. gains: those of each photograph, by which it is multiplied; what
    was saturated stays so.
    """

    def __init__(
        self,
        photographs: Sequence[Photograph],
        *,
        dark: Photograph | None = None,
        peak: float = 1.0,
        gains: Sequence[tuple[Gain, ...]] = (),
    ) -> None:
        self._photographs = tuple(photographs)
        self._dark, self._peak = dark, np.float32(peak)
        self._gains = tuple(gains) or ((),) * len(self._photographs)
        self.shape: tuple[int, ...] = (len(self._photographs), *self._photographs[0].samples.shape)

    @classmethod
    def of_arrays(cls, images: Sequence[Floats] | Floats) -> ImageStack:
        """The stack of arrays (H, W) or (H, W, 3) of one shape that are linear light already."""
        return cls([Photograph(np.asarray(image)) for image in images])

    def __len__(self) -> int:
        return self.shape[0]

    def __iter__(self) -> Iterator[Floats]:
        return (self.frame(i) for i in range(len(self)))

    @property
    def pixels(self) -> int:
        """How many pixels a photograph has."""
        return self.shape[1] * self.shape[2]

    @property
    def stored_as_light(self) -> bool:
        """Whether whole numbers were taken for light as they are, in any of the photographs."""
        return any(one.curve is None and one.samples.dtype.kind == "u" for one in self._photographs)

    @property
    def is_colour(self) -> bool:
        """Whether the photographs have three channels."""
        return len(self.shape) == 4

    def chosen(self, numbers: Sequence[int]) -> ImageStack:
        """The stack of some of the photographs, by their numbers from 0."""
        photographs, gains = [self._photographs[i] for i in numbers], [self._gains[i] for i in numbers]
        return ImageStack(photographs, dark=self._dark, peak=float(self._peak), gains=gains)

    def mapped(self, work: Callable[[int, Photograph], Photograph]) -> ImageStack:
        """The stack of what `work` makes of the number of each photograph and the photograph itself."""
        photographs = [work(number, one) for number, one in enumerate(self._photographs)]
        return ImageStack(photographs, dark=self._dark, peak=float(self._peak), gains=self._gains)

    def times(self, gains: Sequence[Gain]) -> ImageStack:
        """The stack whose photographs are multiplied by one gain each, beside those that there are."""
        both = [(*before, one) for before, one in zip(self._gains, gains, strict=True)]
        return ImageStack(self._photographs, dark=self._dark, peak=float(self._peak), gains=both)

    def range(self, start: int, stop: int) -> Floats:
        """(N, stop - start[, 3]) float32, a range of pixels of every photograph, counted row by row."""
        found = np.empty((len(self), stop - start, *self.shape[3:]), np.float32)
        dark = None if self._dark is None else self._dark.range(start, stop)
        pixels = np.arange(start, stop) if any(self._gains) else np.empty(0, int)
        factors = self._factors(pixels)
        for values, photograph, factor in zip(found, self._photographs, factors, strict=True):
            self._calibrated(photograph.range(start, stop, out=values), dark, factor)
        return found

    def at(self, pixels: Pixels) -> Floats:
        """(N, P[, 3]) float32, some pixels of every photograph, by their numbers."""
        dark = None if self._dark is None else self._dark.at(pixels)
        pairs = zip(self._photographs, self._factors(pixels), strict=True)
        return np.stack([self._calibrated(one.at(pixels), dark, factor) for one, factor in pairs])

    def rows(self, first: int, last: int) -> Floats:
        """(N, last - first, W[, 3]) float32, some rows of every photograph."""
        width = self.shape[2]
        return self.range(first * width, last * width).reshape(len(self), last - first, *self.shape[2:])

    def frame(self, number: int) -> Floats:
        """(H, W) or (H, W, 3) float32, one whole photograph, counted from 0."""
        found = np.empty((self.pixels, *self.shape[3:]), np.float32)
        for start in range(0, self.pixels, _BAND):
            part = slice(start, min(start + _BAND, self.pixels))
            dark = None if self._dark is None else self._dark.range(part.start, part.stop)
            factor = self._factor(number, np.arange(part.start, part.stop)) if self._gains[number] else None
            light = self._photographs[number].range(part.start, part.stop)
            found[part] = self._calibrated(light, dark, factor)
        return found.reshape(self.shape[1:])

    def reduced(self, number: int, size: tuple[int, int]) -> Floats:
        """(h, w) or (h, w, 3) float32, one photograph by means over pixels. size: (w, h), not larger than it.

        What is made much smaller is first brought to a few times that size in its own bits.
        """
        import cv2

        dark = None if self._dark is None else self._dark.reduced(size)
        light = self._photographs[number].reduced(size)
        light = self._calibrated(light, dark, self._factor_in_cells(number, light.shape[:2]))
        return np.asarray(cv2.resize(light, size, interpolation=cv2.INTER_AREA))

    def floats(self) -> Floats:
        """(N, H, W) or (N, H, W, 3) float32: everything at once, which takes four bytes for each value."""
        return np.stack(list(self))

    def _factors(self, pixels: Pixels) -> list[Floats | None]:
        """What each photograph is multiplied by in some pixels; a gain that all share is computed once."""
        if len(set(self._gains)) == 1:
            return [self._factor(0, pixels)] * len(self)
        return [self._factor(number, pixels) for number in range(len(self))]

    def _factor_in_cells(self, number: int, cells: tuple[int, ...]) -> Floats | None:
        """(h, w): what a photograph is multiplied by in the middles of so many cells."""
        if not self._gains[number]:
            return None
        rows, columns = (
            ((np.arange(few) + 0.5) * many / few).astype(int)
            for few, many in zip(cells, self.shape[1:3], strict=True)
        )
        factor = self._factor(number, (rows[:, None] * self.shape[2] + columns).reshape(-1))
        return None if factor is None else factor.reshape(cells)

    def _factor(self, number: int, pixels: Pixels) -> Floats | None:
        factor: Floats | None = None
        for gain in self._gains[number]:
            factor = gain.at(pixels) if factor is None else factor * gain.at(pixels)
        return factor

    def _calibrated(self, values: Floats, dark: Floats | None, factor: Floats | None) -> Floats:
        """The values, changed in place: less the dark frame, divided by the peak, times a factor."""
        white = None if factor is None else values >= SATURATION * self._peak
        if dark is not None:
            np.subtract(values, dark, out=values)
            np.maximum(values, 0, out=values)
        if self._peak != 1:
            values /= self._peak
        if factor is not None and white is not None:
            values *= factor if values.ndim == factor.ndim else factor[..., None]
            values[white] = 1.0
        return values


def each_range(
    work: Callable[[slice], Answer], pixels: int, *, size: int, label: str, progress: Progress | None = None
) -> Iterator[Answer]:
    """What `work` makes of each range of `size` pixels or rows, in order, by threads; it must let others run.

    pixels: how many there are, of pixels or rows. label: what is being done, for `progress`.
    """
    parts = [slice(start, min(start + size, pixels)) for start in range(0, pixels, size)]
    with ThreadPoolExecutor(max_workers=os.cpu_count()) as pool:
        for done, answer in enumerate(pool.map(work, parts), start=1):
            if progress is not None:
                progress(label, done, len(parts))
            yield answer


class _LinearImages:
    """An attribute: an array (N, H, W[, 3]) however the photographs are kept, computed when it is needed."""

    def __get__(self, capture: Any, owner: type) -> Any:
        if capture is None:
            raise AttributeError("images")  # so that a dataclass finds no default
        given = capture.__dict__["images"]
        if not isinstance(given, ImageStack):
            return given
        if "linear" not in capture.__dict__:
            capture.__dict__["linear"] = given.floats()
        return capture.__dict__["linear"]

    def __set__(self, capture: Any, images: Any) -> None:
        capture.__dict__["images"] = images


class KeepsPhotographs:
    """A dataclass whose field `images` may be given as an array or as an `ImageStack`."""

    images = _LinearImages()

    @property
    def photographs(self) -> ImageStack:
        """The photographs in their own bits."""
        given = self.__dict__["images"]
        return given if isinstance(given, ImageStack) else ImageStack.of_arrays(given)

    @property
    def gray(self) -> Floats:
        """(N, H, W) float32: mean of the colour channels."""
        images: Floats = self.images
        return images if images.ndim == 3 else np.asarray(images.mean(axis=3))

    def changed(self, **changes: Any) -> Self:
        """The same with other values of some fields; unlike `replace` it leaves photographs in their bits."""
        kept: dict[str, Any] = {one.name: self.__dict__[one.name] for one in fields(self)}  # type: ignore[arg-type]
        return type(self)(**(kept | changes))
