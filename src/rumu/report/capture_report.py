"""A capture report to sign: lamps, maps, sections, figures, photographs and how it was made, as a PDF."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from rumu.capture.exif import PhotographFacts
from rumu.pages.paper_canvas import GREY, INK, SEAL
from rumu.report.capture_plots import draw_lamps, draw_maps, draw_sections, shorten
from rumu.report.capture_words import CAPTURE_WORDS
from rumu.report.pdf_pages import FilledPages
from rumu.report.wording import Language, ReportWords, quality_meaning
from rumu.surface.folder import Processing
from rumu.surface.photograph_table import PhotographRow
from rumu.values import Bilingual, FloatArray, Surface


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
    return _Report(report, ReportWords(CAPTURE_WORDS, language)).pdf()


class _Report:
    """The pages of one report."""

    def __init__(self, report: CaptureReport, words: ReportWords) -> None:
        self._told, self._words = report, words
        letters = words.letters() + words.chosen(report.lamps_from)
        letters += "".join(map(words.chosen, report.notes))
        letters += (report.processing.made_by or "") + "".join(
            str(value) for one in report.facts for value in (one.author, one.rights, one.caption)
        )
        letters += "".join(words.chosen(quality_meaning(name)) for name in report.surface.quality)
        self._pages = FilledPages(f"{words['title']}  {report.title}", letters)

    def pdf(self) -> bytes:
        pages, told, words = self._pages, self._told, self._words
        pages.write(words["title"], 20)
        pages.write(told.title, 12, GREY)
        draw_lamps(pages, told.lights, [row.name for row in told.rows], told.lamps_from, words)
        draw_maps(pages, told.surface, told.residual, words)
        draw_sections(pages, told.surface, words)
        self._figures()
        self._photographs()
        if told.notes:
            pages.heading(words["notes"])
            for note in told.notes:
                pages.write(words.chosen(note), 8.5)
                pages.y += 0.8
        self._record()
        self._sign()
        return pages.finish()

    def _figures(self) -> None:
        pages, surface = self._pages, self._told.surface
        rows, columns = surface.height.shape
        low, high = float(surface.height.min()), float(surface.height.max())
        pages.heading(self._words["figures"])
        lines = [
            (self._words["size"], f"{columns} × {rows} {self._words['pixels']}"),
            (
                self._words["pixel"],
                f"{surface.spacing:.4g} mm" if surface.unit == "mm" else self._words["no_scale"],
            ),
            (self._words["range"], f"{low:.3g} … {high:.3g} {surface.unit}"),
            *(
                (self._words.chosen(quality_meaning(name)), f"{value:.4g}")
                for name, value in surface.quality.items()
            ),
        ]
        for name, value in lines:
            pages.row([(0, name), (125, value)], 8.5)

    def _photographs(self) -> None:
        """A line for each, and what all of them say alike."""
        pages, told = self._pages, self._told
        pages.heading(self._words["photographs"])
        common = _common(told.facts)
        if not any(asdict(one) != asdict(PhotographFacts()) for one in told.facts):
            pages.write(self._words["nothing"], 8.5, GREY)
        for name in ("camera", "lens", "software", "author", "rights", "caption"):
            if common.get(name):
                pages.row([(0, self._words[name]), (30, shorten(str(common[name]), 90))], 8.5)
        heads = ("name", "strength", "off", "shadow", "white", "sharp", "moved", "settings", "taken")
        places = (0.0, 44.0, 58.0, 73.0, 87.0, 101.0, 112.0, 127.0, 150.0)
        pages.y += 1
        head = [(x, self._words[name]) for x, name in zip(places, heads, strict=True)]
        pages.row(head, 6.5, GREY)
        for number, (row, facts) in enumerate(zip(told.rows, told.facts, strict=True), start=1):
            cells = (
                f"{number}  {shorten(row.name, 26)}",
                f"{row.strength:.2f}",
                f"{100 * row.residual:.1f}",
                f"{100 * row.shadow:.1f}",
                f"{100 * row.saturated:.1f}",
                f"{row.sharpness:.2f}",
                f"{row.moved:.1f}",
                _exposure(facts),
                facts.taken or "",
            )
            colour = SEAL if row.faults else INK
            pages.row(list(zip(places, cells, strict=True)), 7, colour, head=head)

    def _record(self) -> None:
        pages, record = self._pages, self._told.processing
        pages.heading(self._words["record"])
        made = f"{self._words['made']} {record.made}  ·  rumu {record.version}"
        who = f"  ·  {self._words['by']} {record.made_by}" if record.made_by else ""
        pages.write(made + who, 8.5)
        pages.write(",  ".join(_settings(record.settings)), 7.5, GREY)
        for title, digests in (("read", record.inputs), ("result", record.result)):
            pages.make_room(16.0)  # the title and some lines of it together
            pages.y += 1.5
            pages.write(self._words[title], 8.5)
            for path, digest in digests.items():
                pages.row([(0, shorten(Path(path).name, 40)), (62, digest)], 6.5, GREY)

    def _sign(self) -> None:
        """A place for name, date and signature, together on one page."""
        pages = self._pages
        pages.make_room(62.0)
        pages.heading(self._words["sign"])
        pages.write(self._words["checked"], 9)
        pages.y += 12
        for name, left, width in (
            ("signed_name", 0.0, 80.0),
            ("signed_date", 88.0, 28.0),
            ("signature", 124.0, 50.0),
        ):
            x = pages.left + left
            pages.paper.line((x, pages.y), (x + width, pages.y), INK, 0.2)
            pages.paper.write(x, pages.y + 4, self._words[name], 7, GREY)
        pages.y += 8


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
            yield f"{name} {shorten(str(value), 60)}"
        elif value not in (None, False, "", (), []):
            shown = ", ".join(map(str, value)) if isinstance(value, list | tuple) else value
            yield name if value is True else f"{name} {shown}"
