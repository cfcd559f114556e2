"""The drawings of a capture report: lamps as seen from above, maps of the surface, sections of its height."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from rumu.capture.lights import tilt_slant
from rumu.pages.paper_canvas import GREY, INK, MM, SEAL
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
from rumu.report.wording import ReportWords
from rumu.surface.reduction import reduce_surface
from rumu.values import Bilingual, BoolArray, FloatArray, Surface

_PALE = (0.85, 0.82, 0.77)
_LEAST_FULL, _MOST_FULL = 0.02, 0.2  # shares of the brightness that the residual map's darkest red may mean
_DOME = 52.0  # millimetres of the dome plot
_PICTURE = 62.0  # most height of a map
_BESIDE = 84  # most lamps that are told beside the dome plot
_ACROSS = 6  # lamps in a line of the table of many
_SECTION = 26.0  # height of a section's plot


def draw_lamps(
    pages: FilledPages, lights: FloatArray, names: Sequence[str], lamps_from: Bilingual, words: ReportWords
) -> None:
    """The lamps as seen from above, straight up in the middle, and their angles beside.

    lights: (N, 3) toward the lamps, which lit the photographs of these names. lamps_from: what told it.
    """
    pages.heading(f"{words['lamps']}  ·  {words['from']} {words.chosen(lamps_from)}")
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
    few = len(lights) <= _BESIDE
    for number, light in enumerate(lights, start=1):
        canvas.setFillColorRGB(*SEAL)
        at = x + radius * light[0], y - radius * light[1]
        canvas.circle(at[0] * MM, paper.up(at[1]), (0.9 if few else 0.5) * MM, stroke=0, fill=1)
        if few:
            paper.write(at[0] + 1.2, at[1] + 0.8, str(number), 6, INK)
    if few:
        _angles(pages, lights, names, words, left=_DOME + 8, top=top, height=_DOME)
    pages.y = top + _DOME + 2
    if not few:
        _many_angles(pages, lights, words)


def _angles(
    pages: FilledPages,
    lights: FloatArray,
    names: Sequence[str],
    words: ReportWords,
    *,
    left: float,
    top: float,
    height: float,
) -> None:
    """Number, name, tilt and slant of each lamp, in as many columns as needed."""
    paper, count = pages.paper, len(lights)
    columns = min(6, -(-count // 14))
    each, wide = -(-count // columns), (WIDTH - left) / columns
    aside, beside = (0.56, 0.22) if columns <= 2 else (0.25, 0.36)
    step = min(3.7, (height - 4) / max(each, 1))
    for column in range(columns):
        x = pages.left + left + column * wide
        paper.write(x + aside * wide, top + 2, words["tilt"], 6.5, GREY)
        paper.write(x + (aside + beside) * wide, top + 2, words["slant"], 6.5, GREY)
    for k, (light, name) in enumerate(zip(lights, names, strict=True)):
        x = pages.left + left + k // each * wide
        y, (tilt, slant) = top + 5.5 + k % each * step, tilt_slant(light)
        size = min(7.5 if columns <= 2 else 6.0, 2.0 * step)
        shown = f"  {shorten(name, 30 // columns)}" if columns <= 2 else ""  # the table has them all
        paper.write(x, y, f"{k + 1}{shown}", size, INK)
        paper.write(x + aside * wide, y, f"{tilt:.1f}°", size, INK)
        paper.write(x + (aside + beside) * wide, y, f"{slant:.1f}°", size, INK)


def _many_angles(pages: FilledPages, lights: FloatArray, words: ReportWords) -> None:
    """Number, tilt and slant of many lamps, from left to right over the whole width."""
    wide = WIDTH / _ACROSS
    heads = [(k * wide + x, words[name]) for k in range(_ACROSS) for x, name in ((8, "tilt"), (17, "slant"))]
    pages.row(heads, 6, GREY)
    for start in range(0, len(lights), _ACROSS):
        cells = []
        for k, light in enumerate(lights[start : start + _ACROSS]):
            tilt, slant = tilt_slant(light)
            texts = (f"{start + k + 1}", f"{tilt:.1f}°", f"{slant:.1f}°")
            cells += [(k * wide + x, text) for x, text in zip((0, 8, 17), texts, strict=True)]
        pages.row(cells, 6, head=heads)


def draw_maps(pages: FilledPages, whole: Surface, residual: FloatArray, words: ReportWords) -> None:
    """Albedo, height, normals, residual and confidence. residual: (h, w), NaN where nothing was measured."""
    surface = reduce_surface(whole)
    heights, (low, high) = height_picture(surface)
    full = _full_residual(residual)
    pictures = (
        (albedo_picture(surface), words["albedo"]),
        (heights, f"{words['height']}  {low:.3g} … {high:.3g} {surface.unit}"),
        (normals_picture(surface), words["normals"]),
        (
            _residual_picture(residual, full),
            words["residual"].format(f"{100 * full:.1f}"),
        ),
        (share_picture(surface.confidence), words["confidence"]),
    )
    gap = 4.0
    rows, columns = surface.height.shape
    parts = (pictures[:2], pictures[2:])
    widths = [(WIDTH - gap * (len(part) - 1)) / len(part) for part in parts]
    heights_shown = [min(width * rows / columns, _PICTURE) for width in widths]
    pages.heading(words["maps"], below=heights_shown[0] + 8)
    for part, width, height in zip(parts, widths, heights_shown, strict=True):
        pages.make_room(height + 8)
        for k, (picture, caption) in enumerate(part):
            left = k * (width + gap)
            pages.picture(picture, left=left, top=pages.y + 1, width=width, height=height)
            pages.paper.write(pages.left + left, pages.y + height + 4.2, caption, 6.5, GREY)
        pages.y += height + 7


def draw_sections(pages: FilledPages, surface: Surface, words: ReportWords) -> None:
    """The height across and down the middle, each with its own scale."""
    rows, columns = surface.height.shape
    pages.heading(words["sections"], below=_SECTION + 10)
    for name, line, measured in (
        ("across", surface.height[rows // 2], surface.mask[rows // 2]),
        ("down", surface.height[:, columns // 2], surface.mask[:, columns // 2]),
    ):
        pages.make_room(_SECTION + 10)
        _section(pages, line, measured, surface.unit)
        length = len(line) * surface.spacing
        text = f"{words[name]}: {length:.4g} {surface.unit}"
        pages.paper.write(pages.left + 14, pages.y + _SECTION + 4, text, 6.5, GREY)
        pages.y += _SECTION + 7


def _section(pages: FilledPages, line: FloatArray, measured: BoolArray, unit: str) -> None:
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


def _full_residual(residual: FloatArray) -> float:
    """The share that is drawn as the most: what all but a hundredth of the places stay below."""
    known = residual[np.isfinite(residual)]
    return float(np.clip(np.quantile(known, 0.99), _LEAST_FULL, _MOST_FULL)) if known.size else _MOST_FULL


def _residual_picture(residual: FloatArray, full: float) -> Picture:
    """(h, w) shares as colours; what was not measured is paper."""
    picture = colour_scale(np.nan_to_num(residual) / full, stops=RESIDUAL_STOPS)
    picture[~np.isfinite(residual)] = PAPER
    return picture


def shorten(text: str, most: int) -> str:
    """A text of at most so many letters, its middle left out where it has more."""
    return text if len(text) <= most else f"{text[: most // 2 - 1]}…{text[-(most // 2) :]}"
