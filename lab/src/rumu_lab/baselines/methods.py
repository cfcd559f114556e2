"""All methods beside ours, under one signature: `raw(probe: Cell, reference: Cell) -> Raw`.

    METHODS["GFSE"](cell_of(copy), cell_of(master)).raw

A constant is no method; it is what the calibrator falls back to where a raw grade has no spread.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from importlib import import_module
from types import MappingProxyType

from rumu_lab.baselines.cell import Cell, Raw

Method = Callable[[Cell, Cell], Raw]

_FUNCTIONS: Mapping[str, tuple[str, str]] = {
    "MBSE": ("mbse", "raw"),
    "GFSE": ("gfse", "raw"),
    "IGLS": ("igls", "raw"),
    "VICP": ("vicp", "raw"),
    "AEST": ("aest", "raw"),
    "IoU (cell)": ("overlap", "raw"),
    "IoU (aligned)": ("overlap", "raw_aligned"),
    "SSIM": ("ssim", "raw"),
    "Hausdorff (95 %)": ("hausdorff", "raw"),
    "ink ratio": ("ink_ratio", "raw"),
    "HOG cosine": ("hog", "raw"),
}
RECONSTRUCTED: tuple[str, ...] = ("MBSE", "GFSE", "IGLS", "VICP", "AEST")
"""Published methods of which only the abstract was read: their names say so wherever they are printed."""


def _call(location: tuple[str, str], probe: Cell, reference: Cell) -> Raw:
    """Load the method's module when it is first used, and ask it."""
    module, function = location
    answer: Raw = getattr(import_module(f"rumu_lab.baselines.{module}"), function)(probe, reference)
    return answer


METHODS: Mapping[str, Method] = MappingProxyType(
    {name: partial(_call, location) for name, location in _FUNCTIONS.items()}
)
"""Name -> method. Every one takes (probe, reference), loads its module when called, and can be pickled."""
