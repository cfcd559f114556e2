"""Pictures of characters drawn from a font, which refuse the characters that the font lacks.

A font's character map may list a glyph that is empty or is the substitute for missing characters. Such a
glyph never becomes a work.
"""

from __future__ import annotations

import functools
import io
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rumu.errors import GalleryError
from rumu.inputs import read_file

if TYPE_CHECKING:
    from PIL.Image import Image as Picture

SIDE = 512  # pixels of a picture
SHARE = 0.76  # of the side that the longer side of the ink's box fills
AREA = 0.42  # of the picture that the box may cover, or a full-sized 日 would look too large beside others
OVERSAMPLING = 4

# Characters that small fonts lack, and one of the private use area: what a font draws for them is its
# substitute glyph, even if its character map lists them.
SURELY_MISSING = "龘䶮𠀀𰻞\ue0ff\U0010fffd"

_NAMES = {"family": 1, "version": 5, "copyright": 0, "designer": 9, "licence": 13}  # of OpenType's name table


class Face:
    """An opened font that refuses to draw the characters that it lacks.

    path: TTF, OTF, TTC (its first font), WOFF or WOFF2. hint: added to the error when there is no such file.
    Raises GalleryError when there is none, or it is no font.
    """

    def __init__(self, path: Path, *, hint: str = "") -> None:
        if not path.is_file():
            raise GalleryError(f"{path}: expected a font there{hint}")
        self.path = path
        self._font = _open_font(path)
        self._glyphs = self._font.getGlyphSet()
        self._names = self._font.getBestCmap() or {}

    def outline(self, character: str) -> list[Any]:
        """The drawing commands of the glyph for a character, which may be the substitute glyph."""
        from fontTools.pens.recordingPen import DecomposingRecordingPen  # type: ignore[import-untyped]

        pen = DecomposingRecordingPen(self._glyphs)
        self._glyphs[self._names.get(ord(character), ".notdef")].draw(pen)
        commands: list[Any] = pen.value
        return commands

    def check(self, character: str) -> None:
        """Raise GalleryError unless the font has a glyph of its own for this character."""
        refusal = f"{self.path.name}: has no {character}"
        if ord(character) not in self._names:
            raise GalleryError(f"{refusal}: it is not in its table of characters")
        outline = self.outline(character)
        if not outline:
            raise GalleryError(f"{refusal}: the glyph is empty")
        for other in SURELY_MISSING:
            if other != character and outline == self.outline(other):
                raise GalleryError(f"{refusal}: it draws its substitute for missing characters")

    def picture(self, character: str) -> Picture:
        """(SIDE, SIDE) gray: black ink on white, its box centred and sized by SHARE and AREA.

        Raises GalleryError when the font lacks the character.
        """
        from PIL import Image

        self.check(character)
        big = SIDE * OVERSAMPLING
        draft = self._draw(character, size=big, side=2 * big).getbbox()
        if draft is None:
            raise GalleryError(f"{self.path.name}: draws nothing for {character}")
        width, height = draft[2] - draft[0], draft[3] - draft[1]
        size = round(
            big * min(SHARE * big / max(width, height), (AREA * big * big / (width * height)) ** 0.5)
        )
        drawn = self._draw(character, size=size, side=3 * big)
        left, top, right, bottom = drawn.getbbox() or (0, 0, big, big)
        x, y = (left + right - big) // 2, (top + bottom - big) // 2
        ink = drawn.crop((x, y, x + big, y + big)).resize((SIDE, SIDE), Image.Resampling.BOX)
        return Image.eval(ink, lambda value: 255 - value)

    def name(self, what: str) -> str:
        """An entry of the font's name table; '' where it has none.

        what: 'family', 'version', 'copyright', 'designer' or 'licence'.
        """
        record = self._font["name"].getDebugName(_NAMES[what]) if "name" in self._font else None
        return " ".join(str(record or "").split())

    @functools.cached_property
    def _plain(self) -> bytes:
        """The file as the rasteriser reads it; a WOFF2 font is uncompressed in memory."""
        if self._font.flavor is None:
            return self.path.read_bytes()
        self._font.flavor = None
        plain = io.BytesIO()
        self._font.save(plain)
        return plain.getvalue()

    def _draw(self, character: str, *, size: int, side: int) -> Picture:
        from PIL import Image, ImageDraw, ImageFont

        image = Image.new("L", (side, side), 0)
        font = ImageFont.truetype(io.BytesIO(self._plain), size, layout_engine=ImageFont.Layout.BASIC)
        ImageDraw.Draw(image).text((side // 2, side // 2), character, font=font, fill=255, anchor="mm")
        return image


def _open_font(path: Path) -> Any:
    import logging

    try:
        from fontTools.ttLib import TTFont  # type: ignore[import-untyped]
    except ModuleNotFoundError as error:
        raise GalleryError(f"a work from a font needs: pip install fonttools brotli ({error})") from error
    logging.getLogger("fontTools").setLevel(logging.ERROR)  # it warns about odd dates of old fonts
    data = io.BytesIO(read_file(path, error_type=GalleryError, expected="a font"))
    try:
        return TTFont(data, recalcBBoxes=False, fontNumber=0)
    except Exception as error:  # a damaged font fails in many ways
        raise GalleryError(
            f"{path}: expected a font (TTF, OTF, TTC, WOFF), cannot read it ({error})"
        ) from error
