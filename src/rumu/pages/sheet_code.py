"""The code of a sheet's page: a QR code that says all that the page's layout depends on.

It is read at its known place on the flattened page, module by module, which works at a quarter of the
resolution at which a code is found in a picture; its error correction is the standard's.
"""

from __future__ import annotations

import zlib

import numpy as np

from rumu.errors import RumuError
from rumu.pages.sheet_layout import GRIDS, HELPS, PAPERS, SheetPage
from rumu.values import BoolArray, FloatArray

_MAGIC = "rumu1"
_ALPHABET = "0123456789ABCDEFGHIJKLMNOPQRSTUVWXYZ $%*+-./:"  # what a QR code packs in 5.5 bits each
_QUIET = 4  # modules of white around a code, as the standard wants them
_VERSIONS = range(3, 15)
_MOST_LETTERS = 528  # that the last of them holds
_SEPARATOR = "\t"


def code_modules(page: SheetPage) -> BoolArray:
    """(n, n): the code of a page, True where it is dark, without the white around it.

    Raises RumuError when the page says more than a code can hold.
    """
    from reportlab.graphics.barcode import qrencoder

    letters = _pack(page)
    if len(letters) > _MOST_LETTERS:
        raise RumuError(
            f"expected a page that {_MOST_LETTERS} letters of a code can say, got {len(letters)}; "
            "print fewer characters on a page"
        )
    code = qrencoder.QRCode(None, qrencoder.QRErrorCorrectLevel.M)
    code.addData(qrencoder.QRAlphaNum(letters))
    code.make()
    side = range(code.getModuleCount())
    return np.array([[bool(code.isDark(row, column)) for column in side] for row in side])


def module_places(count: int) -> FloatArray:
    """(count * count, 2): the middles of a code's modules, x and y, as shares of its side."""
    middles = (np.arange(count) + 0.5) / count
    x, y = np.meshgrid(middles, middles)
    return np.column_stack([x.ravel(), y.ravel()])


def module_counts() -> tuple[int, ...]:
    """Modules along the side of each code that may be printed, from few to many."""
    return tuple(17 + 4 * version for version in _VERSIONS)


def looks_like_code(light: FloatArray) -> bool:
    """Whether modules show the patterns in the corners that each code has. light: (n, n), bright is large."""
    dark = light < _threshold(light)
    finder = np.zeros((7, 7), bool)
    finder[[0, -1]] = finder[:, [0, -1]] = True
    finder[2:5, 2:5] = True
    corners = dark[:7, :7], dark[:7, -7:], dark[-7:, :7]
    return all(np.count_nonzero(corner != finder) <= 6 for corner in corners)


def decode_modules(light: FloatArray) -> SheetPage | None:
    """The page that a code says; None where it is none of ours, or not legible.

    light: (n, n) how bright each module is, on any scale.
    """
    import cv2

    dark = light < _threshold(light)
    side = 6  # pixels of a module in the clean picture that is decoded
    clean = np.where(np.kron(np.pad(dark, _QUIET), np.ones((side, side), bool)), 0, 255).astype(np.uint8)
    low, high = _QUIET * side, (_QUIET + len(dark)) * side - 1
    corners = np.array([[[low, low], [high, low], [high, high], [low, high]]], np.float32)
    try:
        text, _ = cv2.QRCodeDetector().decode(clean, corners)
    except cv2.error:
        return None
    return _unpack(text) if text else None


def _threshold(light: FloatArray) -> FloatArray:
    """(n, n): the level between dark and bright around each module, so that a shadow does no harm."""
    import cv2

    values = light.astype(np.float32)
    reach = 2 * (len(values) // 6) + 1
    kernel = np.ones((reach, reach), np.uint8)
    low, high = cv2.erode(values, kernel), cv2.dilate(values, kernel)
    return np.asarray(cv2.blur((low + high) / 2, (reach, reach)))


def _pack(page: SheetPage) -> str:
    names = (page.paper, f"{page.cell:g}", page.grid, page.help, str(page.times), str(int(page.strokes)))
    fields = (
        _MAGIC,
        page.sheet,
        str(page.number),
        str(page.count),
        *names,
        page.master,
        page.text,
        page.pupil,
    )
    data = _SEPARATOR.join(fields).encode("gb18030")  # two bytes for nearly every character
    return _to_letters(data + zlib.crc32(data).to_bytes(4, "big"))


def _unpack(letters: str) -> SheetPage | None:
    data = _from_letters(letters)
    if data is None or len(data) < 5 or zlib.crc32(data[:-4]) != int.from_bytes(data[-4:], "big"):
        return None
    try:
        fields = data[:-4].decode("gb18030").split(_SEPARATOR)
        magic, sheet, number, count, paper, cell, grid, help_, times, strokes, master, text, pupil = fields
        known = magic == _MAGIC and paper in PAPERS and grid in GRIDS and help_ in HELPS
        if not known:
            return None
        return SheetPage(
            text=text,
            master=master,
            paper=paper,  # type: ignore[arg-type]  # checked above, as the next two
            cell=float(cell),
            grid=grid,  # type: ignore[arg-type]
            help=help_,  # type: ignore[arg-type]
            times=int(times),
            strokes=strokes == "1",
            sheet=sheet,
            number=int(number),
            count=int(count),
            pupil=pupil,
        )
    except (ValueError, RumuError):
        return None


def _to_letters(data: bytes) -> str:
    """Base 45 (RFC 9285): two bytes as three letters of a QR code."""
    letters = []
    for k in range(0, len(data), 2):
        pair = data[k : k + 2]
        value = int.from_bytes(pair, "big")
        for _ in range(3 if len(pair) == 2 else 2):
            letters.append(_ALPHABET[value % 45])
            value //= 45
    return "".join(letters)


def _from_letters(letters: str) -> bytes | None:
    """The bytes of a text in base 45; None where it is none."""
    if any(letter not in _ALPHABET for letter in letters) or len(letters) % 3 == 1:
        return None
    data = b""
    for k in range(0, len(letters), 3):
        digits = [_ALPHABET.index(letter) for letter in letters[k : k + 3]]
        value, size = sum(digit * 45**place for place, digit in enumerate(digits)), len(digits) - 1
        if value >= 256**size:
            return None
        data += value.to_bytes(size, "big")
    return data
