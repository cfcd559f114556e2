"""The marks of sheets as PDFs: of each pupil, with the worst remark by each character, and of the teacher."""

from __future__ import annotations

import io
from collections import Counter, defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path, PurePosixPath
from statistics import fmean
from typing import Any, Literal

from rumu.containment import safe_name
from rumu.outputs import whole_file
from rumu.pdf_text import draw_text, text_width, wrap_text
from rumu.report.wording import LEVELS, MEANS, kind_name
from rumu.studio.sheet_marks import CELLS, Facts

Language = Literal["zh", "en"]

TEACHER, PUPILS = "teacher.pdf", "pupils"
"""The PDF of the teacher, and the folder of those of the pupils."""

_WIDTH, _HEIGHT, _MARGIN = 595.3, 841.9, 46.0
_INK, _GREY, _SEAL, _PALE = (0.15, 0.14, 0.13), (0.45, 0.43, 0.40), (0.69, 0.13, 0.10), (0.90, 0.87, 0.82)
_CELL, _ROW, _GUTTER = 66.0, 88.0, 16.0  # of a picture, of a line of two characters, between the two
_LINES = 5  # of a remark, at most
_COMMON = 6  # faults that the teacher is told of
_SIGN = 3.2  # width of the lines that show what a remark speaks of

_WORDS: dict[str, tuple[str, str]] = {
    "title": ("臨書評分", "Marks of a sheet"),
    "teacher": ("班級評分", "Marks of the class"),
    "written": ("寫了 {} 個字", "{} characters written"),
    "mean": ("平均 {:.0f}", "mean {:.0f}"),
    "best": ("最高 {:.0f}", "best {:.0f}"),
    "refused": ("未評分", "not marked"),
    "good": ("沒有要改的地方。", "Nothing to change."),
    "pupil": ("學生", "Pupil"),
    "count": ("字數", "Characters"),
    "average": ("平均", "Mean"),
    "lowest": ("最低的字", "Lowest"),
    "character": ("字", "Character"),
    "by_character": ("各字平均", "By character"),
    "common": ("最常見的毛病", "Commonest faults"),
    "photos": ("沒有讀出的照片", "Photographs that were not read"),
    "nobody": ("沒有一個字得分。", "No character was marked."),
    "times": ("{} 次", "{} times"),
}


@dataclass(frozen=True, slots=True)
class PupilSheets:
    """What one pupil handed in. name: of the pupil, else of the photograph. photos: facts of each."""

    name: str
    photos: tuple[Facts, ...]

    @property
    def cells(self) -> list[Facts]:
        """The cells of all photographs."""
        return [cell for facts in self.photos for cell in facts["cells"]]

    @property
    def scores(self) -> list[float]:
        """Their marks, without those of cells that were refused."""
        return [cell["score"] for cell in self.cells if cell["score"] is not None]


def by_pupil(found: Iterable[Facts]) -> list[PupilSheets]:
    """What each pupil handed in; a sheet that names nobody stands under the name of its photograph."""
    photos: dict[str, list[Facts]] = defaultdict(list)
    for facts in found:
        if facts["cells"]:
            photos[facts.get("pupil") or PurePosixPath(facts["photo"]).with_suffix("").as_posix()].append(
                facts
            )
    return [PupilSheets(name, tuple(sorted(one, key=_place))) for name, one in photos.items()]


def write_reports(found: Sequence[Facts], out: Path, *, language: Language = "zh") -> list[Path]:
    """Write the PDFs of the pupils and of the teacher beside the tables; their paths, the teacher's last."""
    pupils, written, taken = by_pupil(found), [], set()
    (out / PUPILS).mkdir(parents=True, exist_ok=True)
    for pupil in pupils:
        stem = safe_name(pupil.name.replace("/", " ")) or "_"
        name = next(
            n for k in range(len(pupils) + 1) if (n := stem + (f" {k + 1}" if k else "")) not in taken
        )
        taken.add(name)
        written.append(out / PUPILS / f"{name}.pdf")
        _save(pupil_pdf(pupil, out, language=language), written[-1])
    written.append(out / TEACHER)
    _save(teacher_pdf(pupils, found, out, language=language), written[-1])
    return written


def pupil_pdf(pupil: PupilSheets, out: Path, *, language: Language = "zh") -> bytes:
    """Return the pages of one pupil: each character with its mark and worst remark. out: of the pictures."""
    paper = _Paper(f"rumu: {pupil.name}", language)
    name = None if pupil.photos[0].get("pupil") else _name_picture(pupil.photos[0], out)
    paper.draw_heading(paper.word("title"), "" if name else pupil.name, picture=name)
    scores = pupil.scores
    summary = [paper.word("written").format(len(pupil.cells))]
    if scores:
        summary += [paper.word("mean").format(fmean(scores)), paper.word("best").format(max(scores))]
    paper.draw_line("  ·  ".join(summary), 10, _GREY, below=20)
    width = (_WIDTH - 2 * _MARGIN - _GUTTER) / 2
    for k, cell in enumerate(pupil.cells):
        if k % 2 == 0:
            paper.make_room(_ROW)
        _draw_cell(paper, cell, _MARGIN + k % 2 * (width + _GUTTER), width, out)
        if k % 2 == 1 or k == len(pupil.cells) - 1:
            paper.y -= _ROW
    return paper.finish()


def teacher_pdf(
    pupils: Sequence[PupilSheets], found: Sequence[Facts], out: Path, *, language: Language = "zh"
) -> bytes:
    """Return the pages of the teacher: pupils, characters, the commonest faults, what was not read."""
    paper = _Paper("rumu", language)
    scores = [score for pupil in pupils for score in pupil.scores]
    paper.draw_heading(paper.word("teacher"), "", picture=None)
    summary = [paper.word("written").format(sum(len(pupil.cells) for pupil in pupils))]
    summary += [paper.word("mean").format(fmean(scores))] if scores else [paper.word("nobody")]
    paper.draw_line("  ·  ".join(summary), 10, _GREY, below=24)
    columns = ((paper.word("pupil"), 0.0), (paper.word("count"), 230.0), (paper.word("average"), 300.0))
    paper.draw_row([*columns, (paper.word("lowest"), 370.0)], 9, _GREY)
    for pupil in pupils:
        _draw_pupil(paper, pupil, out)
    _draw_characters(paper, pupils)
    _draw_faults(paper, pupils, language)
    refused = [facts for facts in found if facts["refused"]]
    if refused:
        paper.draw_caption(paper.word("photos"))
        for facts in refused:
            reason = facts["refused_zh"] if language == "zh" and facts["refused_zh"] else facts["refused"]
            for line in wrap_text(f"{facts['photo']}  {reason}", 9, width=_WIDTH - 2 * _MARGIN):
                paper.draw_line(line, 9, _INK, below=13)
    return paper.finish()


class _Paper:
    """Pages that are filled from the top; y is where the next thing stands."""

    def __init__(self, title: str, language: Language) -> None:
        from reportlab.pdfgen.canvas import Canvas

        self.language, self._stream = language, io.BytesIO()
        self.canvas = Canvas(self._stream, pagesize=(_WIDTH, _HEIGHT), pageCompression=1)
        self.canvas.setTitle(title)
        self.canvas.setAuthor("rumu")
        self.y = _HEIGHT - _MARGIN

    def word(self, name: str) -> str:
        return _WORDS[name][self.language == "en"]

    def make_room(self, height: float) -> None:
        """Begin a new page where less than this is left."""
        if self.y - height < _MARGIN + 20:
            self._end_page()
            self.y = _HEIGHT - _MARGIN

    def draw_heading(self, title: str, name: str, *, picture: Path | None) -> None:
        self.y -= 16
        self.canvas.setFillColorRGB(*_INK)
        end = draw_text(self.canvas, _MARGIN, self.y, title + (f" · {name}" if name else ""), 18, bold=True)
        if picture is not None:  # the name as it was written on the sheet
            self.canvas.drawImage(
                str(picture),
                end + 14,
                self.y - 10,
                width=180,
                height=32,
                preserveAspectRatio=True,
                anchor="w",
            )
        self.y -= 22

    def draw_line(self, text: str, size: float, colour: Any, *, below: float) -> None:
        self.make_room(below)
        self.canvas.setFillColorRGB(*colour)
        draw_text(self.canvas, _MARGIN, self.y, text, size)
        self.y -= below

    def draw_row(self, cells: Iterable[tuple[str, float]], size: float, colour: Any) -> None:
        self.make_room(16)
        for text, x in cells:
            self.canvas.setFillColorRGB(*colour)
            draw_text(self.canvas, _MARGIN + x, self.y, text, size)
        self.y -= 16

    def draw_caption(self, text: str) -> None:
        self.make_room(60)
        self.y -= 14
        self.draw_line(text, 10.5, _SEAL, below=17)

    def finish(self) -> bytes:
        self._end_page()
        self.canvas.save()
        return self._stream.getvalue()

    def _end_page(self) -> None:
        """Print what a mark means at the foot: the page is read without the pages that explain it."""
        meaning = " ".join(text[self.language == "en"] for text in MEANS[:2])
        self.canvas.setFillColorRGB(*_GREY)
        for k, line in enumerate(reversed(wrap_text(meaning, 7, width=_WIDTH - 2 * _MARGIN))):
            draw_text(self.canvas, _MARGIN, _MARGIN - 16 + 9 * k, line, 7)
        self.canvas.showPage()


def _draw_cell(paper: _Paper, cell: Facts, x: float, width: float, out: Path) -> None:
    """A character as it was written, with its mark and the worst remark beside it."""
    canvas, top = paper.canvas, paper.y
    picture = out / str(cell.get("picture", ""))
    if picture.is_file():
        canvas.drawImage(str(picture), x, top - _CELL, _CELL, _CELL)
    worst = cell["remarks"][0] if cell["remarks"] else None
    canvas.setStrokeColorRGB(*_SEAL)
    canvas.setLineWidth(_SIGN)
    canvas.setLineCap(1)
    canvas.setStrokeAlpha(0.45)
    for line in worst["outline"] if worst else ():
        path = canvas.beginPath()
        for k, (across, down) in enumerate(line):
            (path.lineTo if k else path.moveTo)(x + across * _CELL, top - down * _CELL)
        canvas.drawPath(path, stroke=1, fill=0)
    canvas.setStrokeAlpha(1)
    canvas.setStrokeColorRGB(*_PALE)
    canvas.setLineWidth(0.8)
    canvas.rect(x, top - _CELL, _CELL, _CELL)
    left = x + _CELL + 8
    canvas.setFillColorRGB(*_INK)
    end = draw_text(canvas, left, top - 12, cell["character"], 12)
    canvas.setFillColorRGB(*(_SEAL if cell["score"] is not None else _GREY))
    mark = paper.word("refused") if cell["score"] is None else f"{cell['score']:.0f}"
    end = draw_text(canvas, end + 8, top - 12, mark, 13 if cell["score"] is not None else 9, bold=True)
    if cell["level"]:
        canvas.setFillColorRGB(*_GREY)
        draw_text(canvas, end + 6, top - 12, LEVELS[cell["level"]][paper.language == "en"], 9)
    canvas.setFillColorRGB(*_INK)
    for k, line in enumerate(wrap_text(_sentence(paper, cell), 8, width=width - _CELL - 8)[:_LINES]):
        draw_text(canvas, left, top - 26 - 10.5 * k, line, 8)


def _sentence(paper: _Paper, cell: Facts) -> str:
    """The worst remark of a cell, or why it has no mark, or what is good of it."""
    if cell["refused"]:
        zh, en = cell["refused_zh"], cell["refused"].partition(": ")[2]
        return str((zh or en) if paper.language == "zh" else en)
    told = cell["remarks"][0] if cell["remarks"] else cell["praise"]
    return str(told[paper.language]) if told else paper.word("good")


def _draw_pupil(paper: _Paper, pupil: PupilSheets, out: Path) -> None:
    """A pupil's line in the teacher's table, with the name as it was written where the code names nobody."""
    scores = pupil.scores
    lowest = min((cell for cell in pupil.cells if cell["score"] is not None), key=_score, default=None)
    name = None if pupil.photos[0].get("pupil") else _name_picture(pupil.photos[0], out)
    if name is not None:
        paper.make_room(22)
        paper.canvas.drawImage(
            str(name), _MARGIN + 110, paper.y - 5, width=110, height=19, preserveAspectRatio=True, anchor="w"
        )
    cells = [
        (_shortened(pupil.name, 10, width=100 if name else 220), 0.0),
        (str(len(pupil.cells)), 230.0),
        (f"{fmean(scores):.0f}" if scores else paper.word("refused"), 300.0),
        (f"{lowest['character']} {lowest['score']:.0f}" if lowest else "", 370.0),
    ]
    paper.draw_row(cells, 10, _INK)
    paper.y -= 6 if name is not None else 0


def _draw_characters(paper: _Paper, pupils: Sequence[PupilSheets]) -> None:
    """The mean mark of each character, the lowest first."""
    scores: dict[str, list[float]] = defaultdict(list)
    for pupil in pupils:
        for cell in pupil.cells:
            if cell["score"] is not None:
                scores[cell["character"]].append(cell["score"])
    if not scores:
        return
    paper.draw_caption(paper.word("by_character"))
    means = sorted((fmean(marks), len(marks), character) for character, marks in scores.items())
    for k in range(0, len(means), 6):
        row = [(f"{c} {mean:.0f} ({count})", 84.0 * n) for n, (mean, count, c) in enumerate(means[k : k + 6])]
        paper.draw_row(row, 10.5, _INK)


def _draw_faults(paper: _Paper, pupils: Sequence[PupilSheets], language: Language) -> None:
    """What was told most often."""
    kinds = Counter(one["kind"] for pupil in pupils for cell in pupil.cells for one in cell["remarks"])
    if not kinds:
        return
    paper.draw_caption(paper.word("common"))
    for kind, times in kinds.most_common(_COMMON):
        name = kind_name(kind)[language == "en"]
        paper.draw_row([(name, 0.0), (paper.word("times").format(times), 120.0)], 10, _INK)


def _name_picture(facts: Mapping[str, Any], out: Path) -> Path | None:
    path = out / CELLS / str(facts["digest"]) / "name.jpg"
    return path if path.is_file() else None


def _shortened(text: str, size: float, *, width: float) -> str:
    """The text, or the end of it after an ellipsis, within `width` points."""
    if text_width(text, size) <= width:
        return text
    while text and text_width(f"…{text}", size) > width:
        text = text[1:]
    return f"…{text}"


def _score(cell: Facts) -> float:
    return float(cell["score"])


def _place(facts: Facts) -> tuple[str, int]:
    return str(facts.get("sheet", "")), int(facts.get("number", 0))


def _save(data: bytes, path: Path) -> None:
    with whole_file(path) as part:
        part.write_bytes(data)
