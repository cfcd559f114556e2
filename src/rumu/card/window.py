"""The window of the card laid flat: one photograph on the other, in their own bits, without the lens."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from rumu.capture.flat_frames import smooth_gains
from rumu.capture.frames import kept
from rumu.capture.image import to_linear
from rumu.card.finding import CardView
from rumu.card.light_fit import LightFit, light_of, passed_by_lens
from rumu.image_stack import ImageStack, Photograph, Progress, ScratchFile
from rumu.values import FloatArray

_CELLS = 64  # of the longer side of the window, in which the lens is kept


@dataclass(frozen=True, slots=True, eq=False)
class FlatWindow:
    """The window of a card, laid flat.

    view: of any photograph. scale: pixels for each millimetre. inset: millimetres that are left out along
    each side.
    """

    view: CardView
    scale: float
    inset: float

    @property
    def size(self) -> tuple[int, int]:
        """Width and height in pixels."""
        window = self.view.layout.window
        width, height = (int((side - 2 * self.inset) * self.scale) for side in (window.width, window.height))
        return width, height

    def matrix(self, view: CardView) -> FloatArray:
        """(3, 3) from pixels of the flat window to those of a photograph; both have the same middle."""
        window, (width, height) = view.layout.window, self.size
        left = window.left + (window.width - (width - 1) / self.scale) / 2
        top = window.top + (window.height - (height - 1) / self.scale) / 2
        to_card = np.array([[1 / self.scale, 0, left], [0, 1 / self.scale, top], [0, 0, 1.0]])
        return np.asarray(view.homography @ to_card)

    def stack(
        self,
        frames: Sequence[Photograph],
        views: Sequence[CardView],
        light: LightFit,
        progress: Progress | None,
    ) -> ImageStack:
        """The photographs laid flat, as linear light, and even as far as the lens goes."""
        flat = []
        for number, (frame, view) in enumerate(zip(frames, views, strict=True)):
            if progress is not None:
                progress("Laying photographs flat", number, len(frames))
            one = self._flat(frame, view, light.curve)
            flat.append(kept(one, on_disk=isinstance(frame.samples, ScratchFile)))
        grids = [self._lens(view, light.lens) for view in views]
        return ImageStack(flat).times(smooth_gains(grids, self.size[::-1]))

    def _flat(self, photograph: Photograph, view: CardView, curve: FloatArray) -> Photograph:
        """One photograph laid flat in 16 bits, with the curve that makes light of them."""
        import cv2

        samples = photograph.samples
        if isinstance(samples, ScratchFile):
            samples = samples.whole()
        flags = cv2.INTER_CUBIC | cv2.WARP_INVERSE_MAP
        laid = cv2.warpPerspective(samples.astype(np.float32), self.matrix(view), self.size, flags=flags)
        if samples.dtype.kind == "f":
            return Photograph(light_of(np.maximum(laid, 0), curve).astype(np.float32))
        full = np.iinfo(samples.dtype).max
        levels = np.round(np.clip(laid * (65535 / full), 0, 65535)).astype(np.uint16)
        stored = np.arange(65536, dtype=np.float32) / np.float32(65535)
        if photograph.curve is not None:
            stored = to_linear(stored)
        return Photograph(levels, np.clip(light_of(stored, curve), 0, 1).astype(np.float32))

    def _lens(self, view: CardView, lens: FloatArray) -> FloatArray:
        """(h, w): by what the light that the lens took has to be multiplied, in cells of the window."""
        width, height = self.size
        scale = max(width, height) / _CELLS
        columns, rows = max(2, round(width / scale)), max(2, round(height / scale))
        x, y = np.meshgrid(
            (np.arange(columns) + 0.5) * width / columns - 0.5, (np.arange(rows) + 0.5) * height / rows - 0.5
        )
        seen = np.stack([x.ravel(), y.ravel(), np.ones(x.size)]).T @ self.matrix(view).T
        seen = seen[:, :2] / seen[:, 2:]
        return np.exp(-passed_by_lens(view.out(seen), lens)).reshape(rows, columns)
