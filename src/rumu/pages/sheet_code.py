"""The code of a sheet's page: a QR code that says all that the page's layout depends on.

It is read at its known place on the flattened page, module by module, which works at a quarter of the
resolution at which a code is found in a picture; its error correction is the standard's.
"""

from __future__ import annotations

import struct
import zlib

import numpy as np
import numpy.typing as npt

from rumu.errors import RumuError
from rumu.pages.sheet_layout import GRIDS, HELPS, PAPERS, SheetPage
from rumu.values import BoolArray, FloatArray

_MAGIC = b"R1"
_NUMBERS = ">2sIBBBHH"  # magic, sheet, page, pages, choices, tenths of a millimetre, times
_ALPHABET = "0123456789ABCDEFGHIJKLMNOPQRSTUVWXYZ $%*+-./:"  # what a QR code packs in 5.5 bits each
_QUIET = 4  # modules of white around a code, as the standard wants them
_VERSIONS = range(3, 15)
_MOST_LETTERS = 528  # that the last of them holds
_SEPARATOR = "\t"
_BLURS = (0.0, 0.4, 0.55, 0.7)  # standard deviations, in modules, that are tried
_NOISE = 0.02  # power of what the blur leaves below which nothing is amplified
_FINDER = np.ones((7, 7), bool)  # the pattern in three corners of every QR code
_FINDER[1:6, 1:6] = False
_FINDER[2:5, 2:5] = True


def code_modules(page: SheetPage) -> BoolArray:
    """(n, n): the code of a page, True where it is dark, without the white around it.

    Raises RumuError when the page says more than a code can hold.
    """
    from reportlab.graphics.barcode import qrencoder

    letters = _pack(page)
    if len(letters) > _MOST_LETTERS:
        raise RumuError(
            f"expected a page that {_MOST_LETTERS} letters of a code can say, got {len(letters)}; "
            "print fewer characters on a page",
            zh="這一頁的方塊碼放不下這麼多字；請把格子放大，或少印幾個字。",
        )
    levels = qrencoder.QRErrorCorrectLevel
    codes = []
    for level in (levels.M, levels.Q, levels.H):  # the strongest correction that makes it no finer
        code = qrencoder.QRCode(None, level)
        code.addData(qrencoder.QRAlphaNum(letters))
        codes.append((code.calculate_version(), code))
    code = [one for version, one in codes if version == codes[0][0]][-1]
    code.make()
    side = range(code.getModuleCount())
    return np.array([[bool(code.isDark(row, column)) for column in side] for row in side])


def module_counts() -> tuple[int, ...]:
    """Modules along the side of each code that may be printed, from few to many."""
    return tuple(17 + 4 * version for version in _VERSIONS)


def find_code(light: npt.NDArray[np.uint8], corners: FloatArray, *, reach: float) -> SheetPage | None:
    """The page that the code in a picture says; None where it is none of ours, or not legible.

    light: (h, w), of which only the code and its surroundings are looked at. corners: (4, 2) where the code
    should be, x and y in pixels, the upper left first. reach: pixels by which it may lie beside them.
    """
    tables = _sharp_tables()
    for count in module_counts():
        for found in (corners, _find_finders(light, corners, count, reach=reach)):
            values = _sample(light, found, count)
            for blur in _BLURS:
                sharp = _sharpen(values, tables[blur]) if blur else values
                if looks_like_code(sharp):
                    page = decode_modules(sharp)
                    if page is not None:
                        return page
    return None


def _sharp_tables() -> dict[float, FloatArray]:
    """For each blur the weights of a module and its neighbours that undo it, as far as noise allows."""
    reach = 3
    tables: dict[float, FloatArray] = {}
    for blur in _BLURS:
        if blur:
            frequency = np.fft.fftfreq(32)
            passed = np.exp(-2 * (np.pi * blur * frequency) ** 2)
            kept = np.outer(passed, passed)
            inverse = np.fft.fftshift(np.fft.ifft2(kept / (kept**2 + _NOISE)).real)
            tables[blur] = inverse[16 - reach : 17 + reach, 16 - reach : 17 + reach]
    return tables


def _sharpen(values: FloatArray, table: FloatArray) -> FloatArray:
    """Modules without the blur of the photograph."""
    import cv2

    return np.asarray(cv2.filter2D(values, cv2.CV_64F, table, borderType=cv2.BORDER_CONSTANT))


def _sample(light: npt.NDArray[np.uint8], corners: FloatArray, count: int) -> FloatArray:
    """(count, count): the picture at the middles of the modules of a code with these corners."""
    import cv2

    origin, along, down = corners[0], corners[1] - corners[0], corners[3] - corners[0]
    middles = (np.arange(count) + 0.5) / count
    x, y = np.meshgrid(middles, middles)
    places = (origin + x[..., None] * along + y[..., None] * down).astype(np.float32)
    seen = cv2.remap(light, places[..., 0], places[..., 1], cv2.INTER_CUBIC)
    return np.asarray((seen / 255.0) ** 2.2)  # linear light, in which blur mixes dark and bright


def _find_finders(
    light: npt.NDArray[np.uint8], corners: FloatArray, count: int, *, reach: float
) -> FloatArray:
    """Corners of a code, from where the patterns in three of its corners look most like what they are."""
    import cv2

    module = float(np.hypot(*(corners[1] - corners[0]))) / count
    pattern = np.pad(np.where(_FINDER, 0, 255), 1, constant_values=255).astype(np.uint8)
    side = max(9, round(9 * module))
    template = cv2.resize(pattern, (side, side), interpolation=cv2.INTER_AREA)
    template = cv2.GaussianBlur(template, (0, 0), 0.3 * module)
    places = []
    for corner, right, below in ((0, 1, 1), (1, -1, 1), (3, 1, -1)):
        middle = corners[corner] + 3.5 * module * np.array([right, below])
        low = np.floor(middle - side / 2 - reach).astype(int)
        part = light[
            max(low[1], 0) : low[1] + side + 2 * int(reach) + 2,
            max(low[0], 0) : low[0] + side + 2 * int(reach) + 2,
        ]
        if min(part.shape) < side:
            return corners
        alike = cv2.matchTemplate(part, template, cv2.TM_CCOEFF_NORMED)
        row, column = np.unravel_index(int(np.argmax(alike)), alike.shape)
        found = np.maximum(low, 0) + [column, row] + (side - 1) / 2
        places.append(found - 3.5 * module * np.array([right, below]))
    origin, right_end, bottom = places
    return np.array([origin, right_end, right_end + bottom - origin, bottom])


def looks_like_code(light: FloatArray) -> bool:
    """Whether modules show the patterns in the corners that each code has. light: (n, n), bright is large."""
    dark = light < _threshold(light)
    corners = dark[:7, :7], dark[:7, -7:], dark[-7:, :7]
    return all(np.count_nonzero(corner != _FINDER) <= 6 for corner in corners)


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
    """The page as letters of a QR code: numbers in few bytes, then texts, then a checksum."""
    choices = (
        tuple(PAPERS).index(page.paper) << 7
        | GRIDS.index(page.grid) << 4
        | HELPS.index(page.help) << 1
        | int(page.strokes)
    )
    sheet, cell = int(page.sheet or "0", 16), round(page.cell * 10)
    numbers = struct.pack(_NUMBERS, _MAGIC, sheet, page.number, page.count, choices, cell, page.times)
    texts = _SEPARATOR.join((page.master, page.text, page.pupil))
    data = numbers + texts.encode("gb18030")  # two bytes for nearly every character
    return _to_letters(data + zlib.crc32(data).to_bytes(4, "big"))


def _unpack(letters: str) -> SheetPage | None:
    data = _from_letters(letters)
    start = struct.calcsize(_NUMBERS)
    if data is None or len(data) < start + 4:
        return None
    data, checksum = data[:-4], int.from_bytes(data[-4:], "big")
    if zlib.crc32(data) != checksum or not data.startswith(_MAGIC):
        return None
    try:
        _, sheet, number, count, choices, cell, times = struct.unpack(_NUMBERS, data[:start])
        master, text, pupil = data[start:].decode("gb18030").split(_SEPARATOR)
        return SheetPage(
            text=text,
            master=master,
            paper=tuple(PAPERS)[choices >> 7],
            cell=cell / 10,
            grid=GRIDS[choices >> 4 & 7],
            help=HELPS[choices >> 1 & 7],
            times=times,
            strokes=bool(choices & 1),
            sheet=f"{sheet:08x}",
            number=number,
            count=count,
            pupil=pupil,
        )
    except (ValueError, IndexError, RumuError):  # of a later version
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
