"""A capture report to sign: lamps, maps, sections, figures, photographs and how it was made, as a PDF."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np

from rumu.capture.exif import PhotographFacts
from rumu.capture.lights import tilt_slant
from rumu.pages.paper_canvas import GREY, INK, MM
from rumu.report import wording
from rumu.report.pdf_pages import WIDTH, FilledPages
from rumu.report.pictures import (
    PAPER,
    RESIDUAL_STOPS,
    Picture,
    albedo_picture,
    colour_scale,
    height_picture,
    normals_picture,
    share_picture,
)
from rumu.surface.folder import Processing
from rumu.surface.photograph_table import PhotographRow
from rumu.surface.reduction import reduce_surface
from rumu.values import Bilingual, BoolArray, FloatArray, Surface

Language = Literal["zh", "en"]

_SEAL, _PALE = (0.69, 0.13, 0.10), (0.85, 0.82, 0.77)
_LEAST_FULL, _MOST_FULL = 0.02, 0.2  # shares of the brightness that the residual map's darkest red may mean
_DOME = 52.0  # millimetres of the dome plot
_PICTURE = 62.0  # most height of a map
_SECTION = 26.0  # height of a section's plot

_WORDS: dict[str, tuple[str, str]] = {
    "title": ("拍攝報告", "Capture report"),
    "lamps": ("燈", "Lamps"),
    "from": ("方向取自", "directions from"),
    "tilt": ("方位", "tilt"),
    "slant": ("傾角", "slant"),
    "maps": ("各圖", "Maps"),
    "albedo": ("反照率", "Albedo"),
    "height": ("高度", "Height"),
    "normals": ("法線", "Normals"),
    "residual": ("殘差：淺為合，深紅為 {} % 以上", "Residual: pale agrees, dark red {} % or more"),
    "confidence": ("可信度：白為可信", "Confidence: white is sure"),
    "sections": ("剖面", "Sections"),
    "across": ("橫過中央，左到右", "Across the middle, left to right"),
    "down": ("縱過中央，上到下", "Down the middle, top to bottom"),
    "figures": ("數字", "Figures"),
    "size": ("大小", "Size"),
    "pixels": ("像素", "pixels"),
    "pixel": ("每像素", "one pixel"),
    "range": ("高度範圍", "Range of the height"),
    "photographs": ("照片", "Photographs"),
    "name": ("檔名", "File"),
    "strength": ("強度", "strength"),
    "off": ("殘差 %", "residual %"),
    "shadow": ("陰影 %", "shadow %"),
    "white": ("過曝 %", "white %"),
    "sharp": ("清晰", "sharp"),
    "moved": ("錯開 px", "moved px"),
    "taken": ("拍攝時間", "taken"),
    "settings": ("曝光", "exposure"),
    "camera": ("相機", "Camera"),
    "lens": ("鏡頭", "Lens"),
    "software": ("軟體", "Software"),
    "author": ("作者", "Author"),
    "rights": ("權利", "Rights"),
    "caption": ("說明", "Caption"),
    "notes": ("附記", "Notes"),
    "record": ("製作紀錄", "How it was made"),
    "made": ("製作", "made"),
    "by": ("製作者", "by"),
    "version": ("版本", "version"),
    "read": ("讀入的檔案（SHA-256）", "Files that were read (SHA-256)"),
    "result": ("結果（SHA-256）", "Results (SHA-256)"),
    "sign": ("簽核", "Signature"),
    "checked": (
        "本人已核對以上紀錄與照片相符。",
        "I have checked that this report agrees with the photographs.",
    ),
    "signed_name": ("姓名、單位", "Name, institution"),
    "signed_date": ("日期", "Date"),
    "signature": ("簽名", "Signature"),
    "nothing": ("照片裡沒有記載。", "The photographs say nothing."),
}


@dataclass(frozen=True, slots=True, eq=False)
class CaptureReport:
    """What a report tells.

    surface: that was made. lights: (N, 3) toward the lamps. lamps_from: where these directions come from.
    rows and facts: of the photographs, in the order of the lamps. residual: (h, w), see
    `rumu.surface.residual_map`. notes: what a person should know. processing: the record in surface.json.
    """

    title: str
    surface: Surface
    lights: FloatArray
    lamps_from: Bilingual
    rows: Sequence[PhotographRow]
    facts: Sequence[PhotographFacts]
    residual: FloatArray
    notes: Sequence[Bilingual]
    processing: Processing


def capture_pdf(report: CaptureReport, *, language: Language = "zh") -> bytes:
    """The report as a PDF of A4 pages, the last with a place to sign."""
    return _Report(report, language).pdf()


class _Report:
    """The pages of one report."""

    def __init__(self, report: CaptureReport, language: Language) -> None:
        self._told, self._index = report, 0 if language == "zh" else 1
        letters = "".join(word for pair in _WORDS.values() for word in pair)
        letters += "".join(note[self._index] for note in report.notes) + report.lamps_from[self._index]
        letters += (report.processing.made_by or "") + "".join(
            str(value) for one in report.facts for value in (one.author, one.rights, one.caption)
        )
        letters += "".join(wording.quality_meaning(name)[self._index] for name in report.surface.quality)
        self._pages = FilledPages(f"{_WORDS['title'][self._index]}  {report.title}", letters)

    def pdf(self) -> bytes:
        pages, told = self._pages, self._told
        pages.write(self._word("title"), 20)
        pages.write(told.title, 12, GREY)
        self._lamps()
        self._maps()
        self._sections()
        self._figures()
        self._photographs()
        if told.notes:
            pages.heading(self._word("notes"))
            for note in told.notes:
                pages.write(note[self._index], 8.5)
                pages.y += 0.8
        self._record()
        self._sign()
        return pages.finish()

    def _word(self, name: str) -> str:
        return _WORDS[name][self._index]

    # --- lamps -------------------------------------------------------------------------------------

    def _lamps(self) -> None:
        """The lamps as seen from above, straight up in the middle, and their angles beside."""
        pages, told = self._pages, self._told
        pages.heading(f"{self._word('lamps')}  ·  {self._word('from')} {told.lamps_from[self._index]}")
        pages.make_room(_DOME + 6)
        top, radius = pages.y + 2, _DOME / 2
        x, y = pages.left + radius, top + radius
        canvas, paper = pages.canvas, pages.paper
        canvas.setStrokeColorRGB(*_PALE)
        canvas.setLineWidth(0.15 * MM)
        for slant in (30, 60, 90):
            canvas.circle(x * MM, paper.up(y), radius * np.sin(np.radians(slant)) * MM)
            paper.write(x + 0.6, y - radius * np.sin(np.radians(slant)) + 2.4, f"{slant}°", 5.5, GREY)
        canvas.line((x - radius) * MM, paper.up(y), (x + radius) * MM, paper.up(y))
        canvas.line(x * MM, paper.up(y - radius), x * MM, paper.up(y + radius))
        for number, light in enumerate(told.lights, start=1):
            canvas.setFillColorRGB(*_SEAL)
            at = x + radius * light[0], y - radius * light[1]
            canvas.circle(at[0] * MM, paper.up(at[1]), 0.9 * MM, stroke=0, fill=1)
            paper.write(at[0] + 1.2, at[1] + 0.8, str(number), 6, INK)
        self._angles(left=_DOME + 8, top=top, height=_DOME)
        pages.y = top + _DOME + 2

    def _angles(self, *, left: float, top: float, height: float) -> None:
        """Number, name, tilt and slant of each lamp, in as many columns as needed."""
        paper, count = self._pages.paper, len(self._told.lights)
        columns = min(6, -(-count // 14))
        each, wide = -(-count // columns), (WIDTH - left) / columns
        aside, beside = (0.56, 0.22) if columns <= 2 else (0.25, 0.36)
        step = min(3.7, (height - 4) / max(each, 1))
        for column in range(columns):
            x = self._pages.left + left + column * wide
            paper.write(x + aside * wide, top + 2, f"{self._word('tilt')}", 6.5, GREY)
            paper.write(x + (aside + beside) * wide, top + 2, f"{self._word('slant')}", 6.5, GREY)
        for k, (light, row) in enumerate(zip(self._told.lights, self._told.rows, strict=True)):
            x = self._pages.left + left + k // each * wide
            y, (tilt, slant) = top + 5.5 + k % each * step, tilt_slant(light)
            size = min(7.5 if columns <= 2 else 6.0, 2.0 * step)
            name = f"  {_short(row.name, 30 // columns)}" if columns <= 2 else ""  # the table has them all
            paper.write(x, y, f"{k + 1}{name}", size, INK)
            paper.write(x + aside * wide, y, f"{tilt:.1f}°", size, INK)
            paper.write(x + (aside + beside) * wide, y, f"{slant:.1f}°", size, INK)

    # --- maps and sections --------------------------------------------------------------------------

    def _maps(self) -> None:
        pages, surface = self._pages, reduce_surface(self._told.surface)
        heights, (low, high) = height_picture(surface)
        full = _full_residual(self._told.residual)
        pictures = (
            (albedo_picture(surface), self._word("albedo")),
            (heights, f"{self._word('height')}  {low:.3g} … {high:.3g} {surface.unit}"),
            (normals_picture(surface), self._word("normals")),
            (
                _residual_picture(self._told.residual, full),
                self._word("residual").format(f"{100 * full:.1f}"),
            ),
            (share_picture(surface.confidence), self._word("confidence")),
        )
        pages.heading(self._word("maps"))
        gap = 4.0
        for part in (pictures[:2], pictures[2:]):
            width = (WIDTH - gap * (len(part) - 1)) / len(part)
            rows, columns = surface.height.shape
            height = min(width * rows / columns, _PICTURE)
            pages.make_room(height + 8)
            for k, (picture, caption) in enumerate(part):
                left = k * (width + gap)
                pages.picture(picture, left=left, top=pages.y + 1, width=width, height=height)
                pages.paper.write(pages.left + left, pages.y + height + 4.2, caption, 6.5, GREY)
            pages.y += height + 7

    def _sections(self) -> None:
        """The height across and down the middle, each with its own scale."""
        pages, surface = self._pages, self._told.surface
        rows, columns = surface.height.shape
        pages.heading(self._word("sections"))
        for name, line, measured in (
            ("across", surface.height[rows // 2], surface.mask[rows // 2]),
            ("down", surface.height[:, columns // 2], surface.mask[:, columns // 2]),
        ):
            pages.make_room(_SECTION + 10)
            self._section(line, measured)
            length = len(line) * surface.spacing
            text = f"{self._word(name)}: {length:.4g} {surface.unit}"
            pages.paper.write(pages.left + 14, pages.y + _SECTION + 4, text, 6.5, GREY)
            pages.y += _SECTION + 7

    def _section(self, line: FloatArray, measured: BoolArray) -> None:
        pages, unit = self._pages, self._told.surface.unit
        canvas, paper = pages.canvas, pages.paper
        inside = line[measured] if measured.any() else line
        low, high = float(inside.min()), float(inside.max())
        left, width, top = pages.left + 14, WIDTH - 14, pages.y + 1
        for value, y in ((high, top), (low, top + _SECTION)):
            paper.line((left, y), (left + width, y), _PALE, 0.12)
            paper.write(pages.left, y + 0.8, f"{value:.3g} {unit}", 6, GREY)
        at = np.unique(np.linspace(0, len(line) - 1, 1200).astype(int))
        canvas.setStrokeColorRGB(*INK)
        canvas.setLineWidth(0.18 * MM)
        path, drawing = canvas.beginPath(), False
        for k in at:
            if not measured[k]:
                drawing = False
                continue
            x = (left + width * k / max(len(line) - 1, 1)) * MM
            y = paper.up(top + _SECTION * (1 - (line[k] - low) / max(high - low, 1e-12)))
            if drawing:
                path.lineTo(x, y)
            else:
                path.moveTo(x, y)
            drawing = True
        canvas.drawPath(path, stroke=1, fill=0)

    # --- figures, photographs, record ---------------------------------------------------------------

    def _figures(self) -> None:
        pages, surface = self._pages, self._told.surface
        rows, columns = surface.height.shape
        low, high = float(surface.height.min()), float(surface.height.max())
        pages.heading(self._word("figures"))
        lines = [
            (self._word("size"), f"{columns} × {rows} {self._word('pixels')}"),
            (self._word("pixel"), f"{surface.spacing:.4g} {surface.unit}"),
            (self._word("range"), f"{low:.3g} … {high:.3g} {surface.unit}"),
            *(
                (wording.quality_meaning(name)[self._index], f"{value:.4g}")
                for name, value in surface.quality.items()
            ),
        ]
        for name, value in lines:
            pages.row([(0, name), (125, value)], 8.5)

    def _photographs(self) -> None:
        """A line for each, and what all of them say alike."""
        pages, told = self._pages, self._told
        pages.heading(self._word("photographs"))
        common = _common(told.facts)
        if not any(asdict(one) != asdict(PhotographFacts()) for one in told.facts):
            pages.write(self._word("nothing"), 8.5, GREY)
        for name in ("camera", "lens", "software", "author", "rights", "caption"):
            if common.get(name):
                pages.row([(0, self._word(name)), (30, _short(str(common[name]), 90))], 8.5)
        heads = ("name", "strength", "off", "shadow", "white", "sharp", "moved", "settings", "taken")
        places = (0.0, 44.0, 58.0, 73.0, 87.0, 101.0, 112.0, 127.0, 150.0)
        pages.y += 1
        pages.row([(x, self._word(name)) for x, name in zip(places, heads, strict=True)], 6.5, GREY)
        for number, (row, facts) in enumerate(zip(told.rows, told.facts, strict=True), start=1):
            cells = (
                f"{number}  {_short(row.name, 26)}",
                f"{row.strength:.2f}",
                f"{100 * row.residual:.1f}",
                f"{100 * row.shadow:.1f}",
                f"{100 * row.saturated:.1f}",
                f"{row.sharpness:.2f}",
                f"{row.moved:.1f}",
                _exposure(facts),
                facts.taken or "",
            )
            colour = _SEAL if row.faults else INK
            pages.row(list(zip(places, cells, strict=True)), 7, colour)

    def _record(self) -> None:
        pages, record = self._pages, self._told.processing
        pages.heading(self._word("record"))
        made = f"{self._word('made')} {record.made}  ·  rumu {record.version}"
        who = f"  ·  {self._word('by')} {record.made_by}" if record.made_by else ""
        pages.write(made + who, 8.5)
        pages.write(",  ".join(_settings(record.settings)), 7.5, GREY)
        for title, digests in (("read", record.inputs), ("result", record.result)):
            pages.y += 1.5
            pages.write(self._word(title), 8.5)
            for path, digest in digests.items():
                pages.row([(0, _short(Path(path).name, 40)), (62, digest)], 6.5, GREY)

    def _sign(self) -> None:
        """A place for name, date and signature, together on one page."""
        pages = self._pages
        pages.make_room(62.0)
        pages.heading(self._word("sign"))
        pages.write(self._word("checked"), 9)
        pages.y += 12
        for name, left, width in (
            ("signed_name", 0.0, 80.0),
            ("signed_date", 88.0, 28.0),
            ("signature", 124.0, 50.0),
        ):
            x = pages.left + left
            pages.paper.line((x, pages.y), (x + width, pages.y), INK, 0.2)
            pages.paper.write(x, pages.y + 4, self._word(name), 7, GREY)
        pages.y += 8


def _full_residual(residual: FloatArray) -> float:
    """The share that is drawn as the most: what all but a hundredth of the places stay below."""
    known = residual[np.isfinite(residual)]
    return float(np.clip(np.quantile(known, 0.99), _LEAST_FULL, _MOST_FULL)) if known.size else _MOST_FULL


def _residual_picture(residual: FloatArray, full: float) -> Picture:
    """(h, w) shares as colours; what was not measured is paper."""
    picture = colour_scale(np.nan_to_num(residual) / full, stops=RESIDUAL_STOPS)
    picture[~np.isfinite(residual)] = PAPER
    return picture


def _short(text: str, most: int) -> str:
    return text if len(text) <= most else f"{text[: most // 2 - 1]}…{text[-(most // 2) :]}"


def _common(facts: Sequence[PhotographFacts]) -> Mapping[str, Any]:
    """What all photographs say alike."""
    told = [asdict(one) for one in facts]
    return {name: told[0][name] for name in told[0] if all(one[name] == told[0][name] for one in told)}


def _exposure(facts: PhotographFacts) -> str:
    """Exposure, aperture and sensitivity, as far as they are told: '1/60 f/8 ISO 100'."""
    parts = []
    if facts.exposure:
        seconds = facts.exposure
        parts.append(f"1/{1 / seconds:.0f}" if seconds < 0.4 else f"{seconds:.1f} s")
    if facts.f_number:
        parts.append(f"f/{facts.f_number:.1f}".removesuffix(".0"))
    if facts.iso:
        parts.append(f"ISO {facts.iso}")
    return " ".join(parts)


def _settings(settings: Mapping[str, Any]) -> Iterator[str]:
    """The settings that are not empty, such as 'solver robust'."""
    for name, value in settings.items():
        if name == "capture":
            yield f"{name} {_short(str(value), 60)}"
        elif value not in (None, False, "", (), []):
            shown = ", ".join(map(str, value)) if isinstance(value, list | tuple) else value
            yield name if value is True else f"{name} {shown}"
