"""The marks of sheets as PDFs: of each pupil, with the worst remark by each character, and of the teacher."""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path, PurePosixPath
from statistics import fmean
from typing import Any

from rumu.containment import safe_name
from rumu.outputs import whole_file
from rumu.pages.paper_canvas import GREY, INK, MM, SEAL
from rumu.pdf_text import text_width, wrap_text
from rumu.report.pdf_pages import WIDTH, FilledPages
from rumu.report.wording import LEVELS, MEANS, Language, ReportWords, kind_name
from rumu.studio.sheet_marks import CELLS, Facts

TEACHER, PUPILS = "teacher.pdf", "pupils"
"""The PDF of the teacher, and the folder of those of the pupils."""

_PALE = (0.90, 0.87, 0.82)
# all in millimetres
_CELL, _ROW, _GUTTER = 23.3, 31.0, 5.6  # of a picture, of a line of two characters, between the two
_NAME = 6.7  # height of a name as it was written
_COLUMNS = {"pupil": 0.0, "count": 81.0, "average": 106.0, "lowest": 130.0}  # of the teacher's table
_LINES = 5  # of a remark, at most
_COMMON = 6  # faults that the teacher is told of
_SIGN = 1.13  # width of the lines that show what a remark speaks of

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
    words = ReportWords(_WORDS, language)
    pages = _pages(f"rumu: {pupil.name}", [pupil], words)
    name = None if pupil.photos[0].get("pupil") else _name_picture(pupil.photos[0], out)
    pages.write(words["title"] + ("" if name else f" · {pupil.name}"), 18)
    if name is not None:  # as it was written on the sheet
        _draw_name(pages, name, left=62.0, width=64.0, height=11.0)
    scores = pupil.scores
    summary = [words["written"].format(len(pupil.cells))]
    if scores:
        summary += [words["mean"].format(fmean(scores)), words["best"].format(max(scores))]
    pages.y += 2.0
    pages.write("  ·  ".join(summary), 10, GREY)
    pages.y += 4.0
    width = (WIDTH - _GUTTER) / 2
    for k, cell in enumerate(pupil.cells):
        if k % 2 == 0:
            pages.make_room(_ROW)
        _draw_cell(pages, cell, words, out, left=k % 2 * (width + _GUTTER), width=width)
        if k % 2 == 1 or k == len(pupil.cells) - 1:
            pages.y += _ROW
    return pages.finish()


def teacher_pdf(
    pupils: Sequence[PupilSheets], found: Sequence[Facts], out: Path, *, language: Language = "zh"
) -> bytes:
    """Return the pages of the teacher: pupils, characters, the commonest faults, what was not read."""
    words = ReportWords(_WORDS, language)
    refused = [
        f"{facts['photo']}  {words.chosen((facts['refused_zh'], facts['refused']))}"
        for facts in found
        if facts["refused"]
    ]
    pages = _pages(f"rumu: {words['teacher']}", pupils, words, "".join(refused))
    scores = [score for pupil in pupils for score in pupil.scores]
    pages.write(words["teacher"], 18)
    summary = [words["written"].format(sum(len(pupil.cells) for pupil in pupils))]
    summary += [words["mean"].format(fmean(scores))] if scores else [words["nobody"]]
    pages.y += 2.0
    pages.write("  ·  ".join(summary), 10, GREY)
    pages.y += 4.0
    head = [(x, words[name]) for name, x in _COLUMNS.items()]
    pages.row(head, 9, GREY)
    for pupil in pupils:
        _draw_pupil(pages, pupil, words, head, out)
    _draw_characters(pages, pupils, words)
    _draw_faults(pages, pupils, words)
    if refused:
        pages.heading(words["photos"])
        for line in refused:
            pages.write(line, 9)
    return pages.finish()


def _pages(title: str, pupils: Sequence[PupilSheets], words: ReportWords, more: str = "") -> FilledPages:
    """Empty pages; at their foot what a mark means, since they are read without the site that explains it."""
    told = [
        *pupils,
        *map(words.chosen, LEVELS.values()),
        *(words.chosen(kind_name(k)) for k in _kinds(pupils)),
    ]
    letters = words.letters() + more + "".join(map(str, told))
    return FilledPages(title, letters, foot=" ".join(map(words.chosen, MEANS[:2])))


def _draw_cell(
    pages: FilledPages, cell: Facts, words: ReportWords, out: Path, *, left: float, width: float
) -> None:
    """A character as it was written, with its mark and the worst remark beside it."""
    canvas, paper, top, x = pages.canvas, pages.paper, pages.y, pages.left + left
    picture = out / str(cell.get("picture", ""))
    box = (x * MM, paper.up(top + _CELL), _CELL * MM, _CELL * MM)
    if picture.is_file():
        canvas.drawImage(str(picture), *box)
    canvas.setStrokeColorRGB(*SEAL)
    canvas.setLineWidth(_SIGN * MM)
    canvas.setLineCap(1)
    canvas.setStrokeAlpha(0.45)
    for line in cell["remarks"][0]["outline"] if cell["remarks"] else ():
        path = canvas.beginPath()
        for k, (across, down) in enumerate(line):
            move = path.lineTo if k else path.moveTo
            move((x + across * _CELL) * MM, paper.up(top + down * _CELL))
        canvas.drawPath(path, stroke=1, fill=0)
    canvas.setStrokeAlpha(1)
    canvas.setStrokeColorRGB(*_PALE)
    canvas.setLineWidth(0.28 * MM)
    canvas.rect(*box)
    beside = x + _CELL + 2.8
    end = paper.write(beside, top + 4.2, cell["character"], 12, INK)
    if cell["score"] is None:
        end = paper.write(end + 2.8, top + 4.2, words["refused"], 9, GREY)
    else:
        end = paper.write(end + 2.8, top + 4.2, f"{cell['score']:.0f}", 13, SEAL)
    if cell["level"]:
        paper.write(end + 2.1, top + 4.2, words.chosen(LEVELS[cell["level"]]), 9, GREY)
    lines = wrap_text(_sentence(cell, words), 8, width=(width - _CELL - 2.8) * MM)
    for k, line in enumerate(lines[:_LINES]):
        paper.write(beside, top + 9.2 + 3.7 * k, line, 8, INK)


def _sentence(cell: Facts, words: ReportWords) -> str:
    """The worst remark of a cell, or why it has no mark, or what is good of it."""
    if cell["refused"]:
        return words.chosen((cell["refused_zh"], cell["refused"].partition(": ")[2]))
    told = cell["remarks"][0] if cell["remarks"] else cell["praise"]
    return words.chosen((told["zh"], told["en"])) if told else words["good"]


def _draw_pupil(
    pages: FilledPages, pupil: PupilSheets, words: ReportWords, head: Sequence[tuple[float, str]], out: Path
) -> None:
    """A pupil's line in the teacher's table, with the name as it was written where the code names nobody."""
    scores = pupil.scores
    lowest = min((cell for cell in pupil.cells if cell["score"] is not None), key=_score, default=None)
    name = None if pupil.photos[0].get("pupil") else _name_picture(pupil.photos[0], out)
    texts = (
        _shortened(pupil.name, 10, width=35 if name else 78),
        str(len(pupil.cells)),
        f"{fmean(scores):.0f}" if scores else words["refused"],
        f"{lowest['character']} {lowest['score']:.0f}" if lowest else "",
    )
    if name is not None and pages.make_room(_NAME + 1.0):
        pages.row(head, 9, GREY)
    pages.row(list(zip(_COLUMNS.values(), texts, strict=True)), 10, head=head)
    if name is not None:
        _draw_name(pages, name, left=38.0, width=38.0, height=_NAME)
        pages.y += 2.0


def _draw_name(pages: FilledPages, picture: Path, *, left: float, width: float, height: float) -> None:
    """The name that was written on a sheet, in the line that was written last."""
    below = pages.paper.up(pages.y + 0.25 * height)
    canvas, x = pages.canvas, (pages.left + left) * MM
    canvas.drawImage(str(picture), x, below, width * MM, height * MM, preserveAspectRatio=True, anchor="w")


def _draw_characters(pages: FilledPages, pupils: Sequence[PupilSheets], words: ReportWords) -> None:
    """The mean mark of each character, the lowest first."""
    scores: dict[str, list[float]] = defaultdict(list)
    for pupil in pupils:
        for cell in pupil.cells:
            if cell["score"] is not None:
                scores[cell["character"]].append(cell["score"])
    if not scores:
        return
    pages.heading(words["by_character"])
    means = sorted((fmean(marks), len(marks), character) for character, marks in scores.items())
    for k in range(0, len(means), 6):
        row = means[k : k + 6]
        pages.row([(29.0 * n, f"{c} {mean:.0f} ({count})") for n, (mean, count, c) in enumerate(row)], 10.5)


def _draw_faults(pages: FilledPages, pupils: Sequence[PupilSheets], words: ReportWords) -> None:
    """What was told most often."""
    kinds = Counter(_kinds(pupils))
    if not kinds:
        return
    pages.heading(words["common"])
    for kind, times in kinds.most_common(_COMMON):
        pages.row([(0.0, words.chosen(kind_name(kind))), (42.0, words["times"].format(times))], 10)


def _kinds(pupils: Sequence[PupilSheets]) -> list[str]:
    return [one["kind"] for pupil in pupils for cell in pupil.cells for one in cell["remarks"]]


def _name_picture(facts: Mapping[str, Any], out: Path) -> Path | None:
    path = out / CELLS / str(facts["digest"]) / "name.jpg"
    return path if path.is_file() else None


def _shortened(text: str, size: float, *, width: float) -> str:
    """The text, or the end of it after an ellipsis, within `width` millimetres."""
    if text_width(text, size) <= width * MM:
        return text
    while text and text_width(f"…{text}", size) > width * MM:
        text = text[1:]
    return f"…{text}"


def _score(cell: Facts) -> float:
    return float(cell["score"])


def _place(facts: Facts) -> tuple[str, int]:
    return str(facts.get("sheet", "")), int(facts.get("number", 0))


def _save(data: bytes, path: Path) -> None:
    with whole_file(path) as part:
        part.write_bytes(data)
