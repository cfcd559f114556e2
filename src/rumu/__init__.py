"""rumu 入木: Chinese calligraphy as 3-D surfaces, and an honest mark for a learner's copy.

The public names are listed in `__all__`; each is loaded when it is first used, so that importing rumu
takes next to no time.
"""

from __future__ import annotations

TYPE_CHECKING = False  # as type checkers take it; importing typing takes longer than all else here
__version__ = "0.3.0"

_MODULES = {
    "read_capture": "rumu.capture.folder",
    "read_page": "rumu.gallery.page_reading",
    "reconstruct": "rumu.pipeline",
    "relief": "rumu.surface.relief",
    "relight": "rumu.surface.relight",
    "integrate": "rumu.surface.integrate",
    "register": "rumu.pipeline",
    "assess": "rumu.pipeline",
    "find": "rumu.gallery.search",
    "Page": "rumu.pages.page",
    "Capture": "rumu.values",
    "Surface": "rumu.values",
    "Registration": "rumu.values",
    "Assessment": "rumu.values",
    "RumuError": "rumu.errors",
}

__all__ = [
    "Assessment",
    "Capture",
    "Page",
    "Registration",
    "RumuError",
    "Surface",
    "assess",
    "find",
    "integrate",
    "read_capture",
    "read_page",
    "reconstruct",
    "register",
    "relief",
    "relight",
]

if TYPE_CHECKING:
    from rumu.capture.folder import read_capture as read_capture
    from rumu.errors import RumuError as RumuError
    from rumu.gallery.page_reading import read_page as read_page
    from rumu.gallery.search import find as find
    from rumu.pages.page import Page as Page
    from rumu.pipeline import assess as assess
    from rumu.pipeline import reconstruct as reconstruct
    from rumu.pipeline import register as register
    from rumu.surface.integrate import integrate as integrate
    from rumu.surface.relief import relief as relief
    from rumu.surface.relight import relight as relight
    from rumu.values import Assessment as Assessment
    from rumu.values import Capture as Capture
    from rumu.values import Registration as Registration
    from rumu.values import Surface as Surface


def __getattr__(name: str) -> object:
    from importlib import import_module

    if name not in _MODULES:
        raise AttributeError(f"module 'rumu' has no attribute {name!r}")
    return getattr(import_module(_MODULES[name]), name)


def __dir__() -> list[str]:
    return [*__all__, "__version__"]
