"""Licences by the address that IIIF knows them by, and by their short names."""

from __future__ import annotations

import re

RIGHTS = {
    "CC-BY-ND-3.0-TW": "http://creativecommons.org/licenses/by-nd/3.0/tw/",
    "public domain": "http://creativecommons.org/publicdomain/mark/1.0/",
    "CC0-1.0": "http://creativecommons.org/publicdomain/zero/1.0/",
    "CC-BY-4.0": "http://creativecommons.org/licenses/by/4.0/",
    "CC-BY-SA-4.0": "http://creativecommons.org/licenses/by-sa/4.0/",
}
"""The start of a licence as the gallery has it -> its address."""

_CREATIVE_COMMONS = re.compile(
    r"https?://creativecommons\.org/licenses/([a-z-]+)/([0-9.]+)(?:/([a-z]{2})\b)?", re.IGNORECASE
)
_ADDRESS = re.compile(r"https?://[A-Za-z0-9.-]+(:[0-9]+)?(/[^\s<>\"{}|\\^`]*)?")
_MARK = re.compile(r"https?://creativecommons\.org/publicdomain/(mark|zero)/1\.0", re.IGNORECASE)


def rights_address(licence: str) -> str | None:
    """The address of a licence, None where it has none."""
    if is_address(licence):
        return licence
    return next((url for name, url in RIGHTS.items() if licence.startswith(name)), None)


def is_address(text: str) -> bool:
    """Whether a text is an address of the web."""
    return _ADDRESS.fullmatch(text) is not None


def licence_of(address: str) -> str:
    """The short name of the licence at an address; another address stays as it is, '' is none."""
    if mark := _MARK.match(address):
        return "CC0-1.0" if mark[1].lower() == "zero" else "public domain"
    if match := _CREATIVE_COMMONS.match(address):
        place = f"-{match[3].upper()}" if match[3] else ""
        return f"CC-{match[1].upper()}-{match[2]}{place}"
    return address[:200]
