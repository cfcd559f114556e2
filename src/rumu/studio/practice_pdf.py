"""A person's practice of one work on A4: master, copies, curve of marks, remarks on the last copy."""

from __future__ import annotations

import io
import itertools
from collections.abc import Sequence
from dataclasses import dataclass

from rumu.database.tables import Attempt
from rumu.pages.paper_canvas import GREY, MM, SEAL
from rumu.pdf_text import text_width
from rumu.report.pdf_pages import WIDTH, FilledPages
from rumu.report.wording import LEVELS, MEANS, Language, ReportWords
from rumu.studio.practice import Curve
from rumu.studio.progress import progress_facts

_PALE = (0.90, 0.87, 0.82)
_CELL, _GAP, _CURVE = 32.0, 3.5, 46.0  # millimetres: side of a picture, between two, height of the curve
_COLUMNS = {"date": 0.0, "score": 42.0, "interval": 67.0, "level": 102.0, "kind": 134.0}  # millimetres
_MAX_PRINTED, _MAX_ROWS, _MAX_CHANGES = 4, 10, 4

_WORDS: dict[str, tuple[str, str]] = {
    "title": ("臨帖練習", "Practice"),
    "master": ("範字", "Master"),
    "curve": ("進步曲線（豎線為八成區間）", "Marks so far (bars: 80% intervals)"),
    "none": ("還沒有得分的臨作", "No copy has been marked yet"),
    "date": ("日期", "Date"),
    "score": ("分數", "Mark"),
    "interval": ("八成區間", "80% interval"),
    "level": ("等級", "Level"),
    "kind": ("方式", "Written with"),
    "pen": ("筆", "pen"),
    "photo": ("照片", "photo"),
    "simulated": ("模擬", "simulated"),
    "remarks": ("最近一次的評語", "What the last copy was told"),
    "progress": ("和上一張比", "Against the one before"),
    "no_remarks": ("沒有要改的地方。", "Nothing to change."),
    "refused": ("未評分", "not marked"),
    "earlier": ("另有較早的 {} 次。", "And {} earlier ones."),
    "best": ("最高", "best"),
    "copies": ("次", "copies"),
}


@dataclass(frozen=True, slots=True)
class PracticeSheet:
    """What is printed; pictures are encoded files, those of attempts by their ids."""

    name: str
    curve: Curve
    master: bytes
    pictures: dict[str, bytes]
    language: Language = "zh"


def printed_attempts(curve: Curve) -> tuple[Attempt, ...]:
    """Return the attempts whose pictures are printed: the first and the latest."""
    attempts = curve.attempts
    return attempts if len(attempts) <= _MAX_PRINTED else (attempts[0], *attempts[-(_MAX_PRINTED - 1) :])


def practice_pdf(sheet: PracticeSheet) -> bytes:
    """Return the sheet as a PDF, of one page unless much is to be said."""
    words, work = ReportWords(_WORDS, sheet.language), sheet.curve.work
    title = words.chosen((work.title_zh, work.title_en))
    hand = words.chosen((work.hand_zh, work.hand_en))
    progress, remarks = progress_sentences(sheet), _remark_sentences(sheet, words)
    levels = map(words.chosen, LEVELS.values())
    letters = "".join((words.letters(), title, hand, sheet.name, *levels, *progress, *remarks, "•"))
    pages = FilledPages(f"rumu: {title}, {sheet.name}", letters, foot=" ".join(map(words.chosen, MEANS[:2])))
    scores = sheet.curve.scores
    best = f"{words['best']} {max(scores):.0f}" if scores else ""
    facts = (sheet.name, hand.strip(), f"{len(sheet.curve.attempts)} {words['copies']}", best)
    pages.write(f"{words['title']} · {title}", 19)
    pages.y += 1.5
    pages.write("  ·  ".join(filter(None, facts)), 10, GREY)
    pages.y += 4.5
    _draw_cells(pages, sheet, words)
    _draw_curve(pages, sheet, words)
    _draw_table(pages, sheet, words)
    _draw_sentences(pages, words["progress"], progress)
    _draw_sentences(pages, words["remarks"], remarks)
    return pages.finish()


def _draw_cells(pages: FilledPages, sheet: PracticeSheet, words: ReportWords) -> None:
    """Draw the master, then the first and the latest copies, each with its mark below."""
    _draw_cell(pages, 0.0, sheet.master, words["master"], red=True)
    for k, attempt in enumerate(printed_attempts(sheet.curve), start=1):
        label = f"{attempt.created:%m-%d}  {_score(attempt, words)}"
        _draw_cell(pages, k * (_CELL + _GAP), sheet.pictures.get(attempt.id), label)
    pages.y += _CELL + 9.0


def _draw_cell(
    pages: FilledPages, left: float, picture: bytes | None, label: str, *, red: bool = False
) -> None:
    from reportlab.lib.utils import ImageReader

    canvas, x = pages.canvas, pages.left + left
    box = (x * MM, pages.paper.up(pages.y + _CELL), _CELL * MM, _CELL * MM)
    if picture is not None:
        canvas.drawImage(ImageReader(io.BytesIO(picture)), *box, preserveAspectRatio=True)
    canvas.setStrokeColorRGB(*(SEAL if red else _PALE))
    canvas.setLineWidth(0.28 * MM)
    canvas.rect(*box)
    aside = (_CELL - text_width(label, 8.5) / MM) / 2
    pages.paper.write(x + aside, pages.y + _CELL + 4.2, label, 8.5, GREY)


def _draw_curve(pages: FilledPages, sheet: PracticeSheet, words: ReportWords) -> None:
    """Draw the marks of attempts with their intervals, 0 to 100."""
    pages.write(words["curve"], 9, GREY)
    paper, top, left, right = pages.paper, pages.y + 3.0, pages.left + 8.0, pages.left + WIDTH

    def down(mark: float) -> float:
        return top + _CURVE * (1 - mark / 100)

    for mark in (0, 25, 50, 75, 100):
        paper.line((left, down(mark)), (right, down(mark)), _PALE, 0.14)
        paper.write(left - 2.0 - text_width(str(mark), 7.5) / MM, down(mark) + 0.9, str(mark), 7.5, GREY)
    marked = [point for point in sheet.curve.points if point.score is not None]
    step = (right - left) / max(len(marked), 2)
    positions = [(left + step * (k + 0.5), down(point.score or 0.0)) for k, point in enumerate(marked)]
    for (x, _), point in zip(positions, marked, strict=True):
        if point.interval is not None:
            low, high = point.interval
            paper.line((x, down(low)), (x, down(high)), _PALE, 1.06)
    for start, end in itertools.pairwise(positions):
        paper.line(start, end, SEAL, 0.39)
    pages.canvas.setFillColorRGB(*SEAL)
    for x, y in positions:
        pages.canvas.circle(x * MM, paper.up(y), 0.78 * MM, stroke=0, fill=1)
    if not marked:
        paper.write(left + 3.0, down(50), words["none"], 10, GREY)
    pages.y = top + _CURVE + 4.0


def _draw_table(pages: FilledPages, sheet: PracticeSheet, words: ReportWords) -> None:
    head = [(x, words[name]) for name, x in _COLUMNS.items()]
    pages.row(head, 9, GREY)
    attempts = sheet.curve.attempts
    for attempt in reversed(attempts[-_MAX_ROWS:]):
        pages.row(list(zip(_COLUMNS.values(), _row(attempt, words), strict=True)), 9, head=head)
    if len(attempts) > _MAX_ROWS:
        pages.write(words["earlier"].format(len(attempts) - _MAX_ROWS), 9, GREY)
    pages.y += 4.0


def _row(attempt: Attempt, words: ReportWords) -> Sequence[str]:
    interval = attempt.mark.get("interval")
    between = "" if interval is None else f"{interval[0]:.0f} – {interval[1]:.0f}"
    names = {str(level): text for level, text in LEVELS.items()}
    level = "" if attempt.level is None else words.chosen(names[attempt.level])
    when = f"{attempt.created:%Y-%m-%d %H:%M} UTC"
    return when, _score(attempt, words), between, level, words[attempt.kind]


def progress_sentences(sheet: PracticeSheet) -> list[str]:
    """Return what the last attempt changed against the one before; nothing where one of them has no mark."""
    *_, before, last = (None, None, *sheet.curve.attempts)
    if before is None or last is None:
        return []
    changed = progress_facts(before, last, character=sheet.curve.work.character or "")
    if changed is None:
        return []
    return [one[sheet.language] for one in (changed["mark"], *changed["faults"][:_MAX_CHANGES])]


def _remark_sentences(sheet: PracticeSheet, words: ReportWords) -> list[str]:
    mark = sheet.curve.attempts[-1].mark
    refused = mark.get("refused")
    praise = mark.get("praise")
    told = [*([praise] if praise else []), *mark.get("remarks", ())]
    sentences = [refused[sheet.language]] if refused else [said[sheet.language] for said in told]
    return sentences or [words["no_remarks"]]


def _draw_sentences(pages: FilledPages, caption: str, sentences: Sequence[str]) -> None:
    """Draw a caption and what stands below it; without sentences nothing."""
    if not sentences:
        return
    pages.make_room(16.0)  # the caption and some lines of it together
    pages.write(caption, 9, GREY)
    for text in sentences:
        pages.write(text, 9.5, left=4.0, width=WIDTH - 4.0, bullet="•")
        pages.y += 0.8
    pages.y += 3.0


def _score(attempt: Attempt, words: ReportWords) -> str:
    return words["refused"] if attempt.score is None else f"{attempt.score:.0f}"
