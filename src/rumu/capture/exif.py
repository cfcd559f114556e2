"""What a camera wrote into a photograph beside the picture: EXIF; who made it and what it shows: IPTC."""

from __future__ import annotations

import contextlib
import struct
import warnings
from dataclasses import dataclass
from pathlib import Path
from typing import Any

_DETAILS = 0x8769  # the part of EXIF that tells of the exposure
_PNG_HEAD = 8  # bytes before the first part of a PNG
_LONGEST = 200  # characters of a text that are kept
_IPTC = {(2, 5): "title", (2, 80): "author", (2, 116): "rights", (2, 120): "caption"}


@dataclass(frozen=True, slots=True)
class PhotographFacts:
    """What one photograph says of itself; None where it says nothing.

    camera, lens: their makers' names. exposure: seconds. f_number. iso. focal_mm: focal length; focal_35_mm:
    the same for 35-mm film. taken: date and time as the camera's clock told them. software: that wrote it.
    title, author, rights, caption: by IPTC, or the EXIF entries of the same meaning.
    """

    camera: str | None = None
    lens: str | None = None
    exposure: float | None = None
    f_number: float | None = None
    iso: int | None = None
    focal_mm: float | None = None
    focal_35_mm: float | None = None
    taken: str | None = None
    software: str | None = None
    title: str | None = None
    author: str | None = None
    rights: str | None = None
    caption: str | None = None


def read_facts(path: Path) -> PhotographFacts:
    """What a file says of itself; nothing where it cannot be read, since the picture may still be."""
    from PIL import Image, IptcImagePlugin

    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            with Image.open(path) as image:
                told_first = {"exif", "Raw profile type exif"} & image.info.keys()
                if image.format == "PNG" and not told_first:
                    image.info["exif"] = _late_exif(path)  # or Pillow decodes the picture to look behind it
                exif = image.getexif()
                main, details = dict(exif), dict(exif.get_ifd(_DETAILS))
                told = IptcImagePlugin.getiptcinfo(image) or {}
    except (OSError, ValueError, SyntaxError, KeyError, TypeError, struct.error):
        return PhotographFacts()
    iptc = {name: _text(told.get(key)) for key, name in _IPTC.items()}
    maker, model = _text(main.get(0x010F)), _text(main.get(0x0110))
    if maker and model and model.lower().startswith(maker.lower()):
        maker = None
    return PhotographFacts(
        camera=" ".join(filter(None, (maker, model))) or None,
        lens=_text(details.get(0xA434)),
        exposure=_number(details.get(0x829A)),
        f_number=_number(details.get(0x829D)),
        iso=_whole(details.get(0x8827)),
        focal_mm=_number(details.get(0x920A)),
        focal_35_mm=_number(details.get(0xA405)),
        taken=_text(details.get(0x9003)) or _text(main.get(0x0132)),
        software=_text(main.get(0x0131)),
        title=iptc["title"],
        author=iptc["author"] or _text(main.get(0x013B)),
        rights=iptc["rights"] or _text(main.get(0x8298)),
        caption=iptc["caption"] or _text(main.get(0x010E)),
    )


def _late_exif(path: Path) -> bytes:
    """What a PNG says of itself behind its picture, which is passed over; nothing in most."""
    with path.open("rb") as file:
        file.seek(_PNG_HEAD)
        while len(head := file.read(8)) == 8:
            length, kind = struct.unpack(">I4s", head)
            if kind == b"eXIf":
                return b"Exif\0\0" + file.read(length)
            file.seek(length + 4, 1)  # and its check sum
    return b""


def _text(value: Any) -> str | None:
    """Plain text of an entry; None of what is none."""
    if isinstance(value, list):
        value = value[0] if value else None
    if isinstance(value, bytes):
        value = value.decode("utf-8", errors="replace")
    if not isinstance(value, str):
        return None
    with contextlib.suppress(UnicodeError):  # phones write UTF-8, which Pillow reads as Latin-1
        value = value.encode("latin-1").decode("utf-8")
    plain = "".join(sign if sign.isprintable() else " " for sign in value.split("\0")[0])
    return " ".join(plain.split())[:_LONGEST] or None


def _number(value: Any) -> float | None:
    """A positive number; None of what is none, such as a fraction over zero."""
    with contextlib.suppress(TypeError, ValueError, ZeroDivisionError, OverflowError):
        number = float(value)
        return number if 0 < number < float("inf") else None
    return None


def _whole(value: Any) -> int | None:
    number = _number(value[0] if isinstance(value, tuple) and value else value)
    return None if number is None else round(number)
