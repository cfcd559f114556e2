"""A person's practice of one work as an A4 page: master, copies, curve of marks, remarks on the last copy."""

from __future__ import annotations

import io
import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal

from rumu.database.tables import Attempt
from rumu.pdf_text import draw_text, text_width, wrap_text
from rumu.report.wording import LEVELS, MEANS
from rumu.studio.practice import Curve
from rumu.studio.progress import progress_facts

Language = Literal["zh", "en"]

_WIDTH, _HEIGHT, _MARGIN = 595.3, 841.9, 48.0
_INK, _GREY, _SEAL, _PALE = (0.15, 0.14, 0.13), (0.45, 0.43, 0.40), (0.69, 0.13, 0.10), (0.90, 0.87, 0.82)
_CELL, _GAP, _MAX_PRINTED, _MAX_ROWS, _MAX_CHANGES = 92.0, 9.75, 4, 10, 4

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
    """Return the sheet as a PDF of one page."""
    from reportlab.pdfgen.canvas import Canvas

    stream = io.BytesIO()
    canvas = Canvas(stream, pagesize=(_WIDTH, _HEIGHT), pageCompression=1)
    canvas.setAuthor("rumu")
    y = _draw_heading(canvas, sheet)
    y = _draw_cells(canvas, sheet, y)
    y = _draw_curve(canvas, sheet, y)
    y = _draw_table(canvas, sheet, y)
    y = _draw_sentences(canvas, _word("progress", sheet), progress_sentences(sheet), y)
    _draw_sentences(canvas, _word("remarks", sheet), _remark_sentences(sheet), y)
    _draw_footer(canvas, sheet)
    canvas.save()
    return stream.getvalue()


def _word(name: str, sheet: PracticeSheet) -> str:
    return _WORDS[name][sheet.language == "en"]


def _draw_heading(canvas: Any, sheet: PracticeSheet) -> float:
    y = _HEIGHT - _MARGIN - 20
    work = sheet.curve.work
    english = sheet.language == "en"
    title, hand = (work.title_en, work.hand_en) if english else (work.title_zh, work.hand_zh)
    canvas.setTitle(f"rumu: {title}, {sheet.name}")
    canvas.setFillColorRGB(*_INK)
    draw_text(canvas, _MARGIN, y, f"{_word('title', sheet)} · {title}", 19, bold=True)
    scores = sheet.curve.scores
    best = f"{_word('best', sheet)} {max(scores):.0f}" if scores else ""
    canvas.setFillColorRGB(*_GREY)
    facts = (sheet.name, hand.strip(), f"{len(sheet.curve.attempts)} {_word('copies', sheet)}", best)
    draw_text(canvas, _MARGIN, y - 20, "  ·  ".join(filter(None, facts)), 10)
    return y - 36


def _draw_cells(canvas: Any, sheet: PracticeSheet, y: float) -> float:
    """Draw the master, then the first and the latest copies, each with its mark below."""
    _draw_cell(canvas, _MARGIN, y, sheet.master, _word("master", sheet), red=True)
    for k, attempt in enumerate(printed_attempts(sheet.curve), start=1):
        x = _MARGIN + k * (_CELL + _GAP)
        label = f"{attempt.created:%m-%d}  {_score(attempt, sheet)}"
        _draw_cell(canvas, x, y, sheet.pictures.get(attempt.id), label)
    return y - _CELL - 34


def _draw_cell(
    canvas: Any, x: float, y: float, picture: bytes | None, label: str, *, red: bool = False
) -> None:
    from reportlab.lib.utils import ImageReader

    if picture is not None:
        canvas.drawImage(
            ImageReader(io.BytesIO(picture)), x, y - _CELL, _CELL, _CELL, preserveAspectRatio=True
        )
    canvas.setStrokeColorRGB(*(_SEAL if red else _PALE))
    canvas.setLineWidth(0.8)
    canvas.rect(x, y - _CELL, _CELL, _CELL)
    canvas.setFillColorRGB(*_GREY)
    draw_text(canvas, x + (_CELL - text_width(label, 8.5)) / 2, y - _CELL - 12, label, 8.5)


def _draw_curve(canvas: Any, sheet: PracticeSheet, y: float) -> float:
    """Draw the marks of attempts with their intervals, 0 to 100."""
    _draw_caption(canvas, _word("curve", sheet), y)
    low, high, left, right = y - 148.0, y - 16.0, _MARGIN + 22.0, _WIDTH - _MARGIN
    canvas.setLineWidth(0.4)
    for mark in (0, 25, 50, 75, 100):
        at = low + (high - low) * mark / 100
        canvas.setStrokeColorRGB(*_PALE)
        canvas.line(left, at, right, at)
        canvas.setFillColorRGB(*_GREY)
        draw_text(canvas, left - 6 - text_width(str(mark), 7.5), at - 2.5, str(mark), 7.5)
    marked = [point for point in sheet.curve.points if point.score is not None]
    step = (right - left) / max(len(marked), 2)
    positions = [
        (left + step * (k + 0.5), low + (high - low) * (point.score or 0.0) / 100)
        for k, point in enumerate(marked)
    ]
    for (x, _), point in zip(positions, marked, strict=True):
        if point.interval is not None:
            canvas.setStrokeColorRGB(*_PALE)
            canvas.setLineWidth(3)
            ends = [low + (high - low) * bound / 100 for bound in point.interval]
            canvas.line(x, ends[0], x, ends[1])
    canvas.setStrokeColorRGB(*_SEAL)
    canvas.setFillColorRGB(*_SEAL)
    canvas.setLineWidth(1.1)
    for (x0, y0), (x1, y1) in itertools.pairwise(positions):
        canvas.line(x0, y0, x1, y1)
    for x, at in positions:
        canvas.circle(x, at, 2.2, stroke=0, fill=1)
    if not marked:
        canvas.setFillColorRGB(*_GREY)
        draw_text(canvas, left + 8, (low + high) / 2, _word("none", sheet), 10)
    return low - 26


def _draw_table(canvas: Any, sheet: PracticeSheet, y: float) -> float:
    columns = (("date", 0.0), ("score", 120.0), ("interval", 190.0), ("level", 290.0), ("kind", 380.0))
    for name, x in columns:
        _draw_caption(canvas, _word(name, sheet), y, x=_MARGIN + x)
    attempts = sheet.curve.attempts
    for attempt in reversed(attempts[-_MAX_ROWS:]):
        y -= 14
        canvas.setFillColorRGB(*_INK)
        for (_, x), text in zip(columns, _row(attempt, sheet), strict=True):
            draw_text(canvas, _MARGIN + x, y, text, 9)
    if len(attempts) > _MAX_ROWS:
        y -= 14
        canvas.setFillColorRGB(*_GREY)
        draw_text(canvas, _MARGIN, y, _word("earlier", sheet).format(len(attempts) - _MAX_ROWS), 9)
    return y - 28


def _row(attempt: Attempt, sheet: PracticeSheet) -> Sequence[str]:
    interval = attempt.mark.get("interval")
    between = "" if interval is None else f"{interval[0]:.0f} – {interval[1]:.0f}"
    names = {str(level): text for level, text in LEVELS.items()}
    level = "" if attempt.level is None else names[attempt.level][sheet.language == "en"]
    when = f"{attempt.created:%Y-%m-%d %H:%M} UTC"
    return when, _score(attempt, sheet), between, level, _word(attempt.kind, sheet)


def progress_sentences(sheet: PracticeSheet) -> list[str]:
    """Return what the last attempt changed against the one before; nothing where one of them has no mark."""
    *_, before, last = (None, None, *sheet.curve.attempts)
    if before is None or last is None:
        return []
    changed = progress_facts(before, last, character=sheet.curve.work.character or "")
    if changed is None:
        return []
    return [one[sheet.language] for one in (changed["mark"], *changed["faults"][:_MAX_CHANGES])]


def _remark_sentences(sheet: PracticeSheet) -> list[str]:
    mark = sheet.curve.attempts[-1].mark
    refused = mark.get("refused")
    praise = mark.get("praise")
    told = [*([praise] if praise else []), *mark.get("remarks", ())]
    sentences = [refused[sheet.language]] if refused else [said[sheet.language] for said in told]
    return sentences or [_word("no_remarks", sheet)]


def _draw_sentences(canvas: Any, caption: str, sentences: Sequence[str], y: float) -> float:
    """Draw a caption and what stands below it, as far as the page reaches; without sentences nothing."""
    if not sentences:
        return y
    _draw_caption(canvas, caption, y)
    for text in sentences:
        for k, line in enumerate(wrap_text(text, 9.5, width=_WIDTH - 2 * _MARGIN - 12)):
            y -= 14
            if y < _MARGIN + 52:
                return y
            canvas.setFillColorRGB(*_INK)
            draw_text(canvas, _MARGIN, y, "•" if k == 0 else "", 9.5)
            draw_text(canvas, _MARGIN + 12, y, line, 9.5)
        y -= 3
    return y - 18


def _draw_footer(canvas: Any, sheet: PracticeSheet) -> None:
    """Print what a mark means: the sheet is read without the page that explains it."""
    meaning = " ".join(text[sheet.language == "en"] for text in MEANS[:2])
    folded = wrap_text(meaning, 7.5, width=_WIDTH - 2 * _MARGIN)
    canvas.setFillColorRGB(*_GREY)
    for k, line in enumerate(reversed(folded)):
        draw_text(canvas, _MARGIN, _MARGIN - 14 + 10 * k, line, 7.5)


def _draw_caption(canvas: Any, text: str, y: float, *, x: float = _MARGIN) -> None:
    canvas.setFillColorRGB(*_GREY)
    draw_text(canvas, x, y, text, 9, bold=True)


def _score(attempt: Attempt, sheet: PracticeSheet) -> str:
    return _word("refused", sheet) if attempt.score is None else f"{attempt.score:.0f}"
