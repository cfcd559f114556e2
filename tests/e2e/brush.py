"""A hand that follows the centre lines of a master, so that a test can write in the page."""

from __future__ import annotations

from functools import cache

from playwright.sync_api import Page

from rumu.gallery.starter import find_work
from rumu.pipeline import surface_of
from rumu.surface.skeleton import skeletonise, strokes

Line = tuple[tuple[float, float], ...]

STEP = 8  # points of a centre line from one move of the mouse to the next, each of which waits for a frame


@cache
def lines_of(work_id: str) -> tuple[Line, ...]:
    """The strokes of a starter work as points in fractions of its cell."""
    mask = surface_of(find_work(work_id).path).mask
    rows, columns = mask.shape
    return tuple(
        tuple((float(x) / columns, float(y) / rows) for x, y in (*stroke.points[:-1:STEP], stroke.points[-1]))
        for stroke in strokes(skeletonise(mask))
    )


def write(page: Page, work_id: str, *, leave_out: int = 0) -> None:
    """Write the work into the cell with the mouse; the last `leave_out` strokes are not written."""
    cell = page.locator(".cell").bounding_box()
    assert cell is not None
    lines = lines_of(work_id)
    for line in lines[: len(lines) - leave_out]:
        for k, (x, y) in enumerate(line):
            page.mouse.move(cell["x"] + x * cell["width"], cell["y"] + y * cell["height"])
            if k == 0:
                page.mouse.down()
        page.mouse.up()
