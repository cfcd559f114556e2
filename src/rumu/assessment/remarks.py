"""Registration -> what a teacher would say: where, what, how much, what to do, in Chinese and English.

Every remark comes from a measurement and carries its size; nothing is said below the size at which a
person would see it.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from rumu.assessment.features import Features
from rumu.assessment.regions import Region
from rumu.values import FloatArray, Registration, Remark


@dataclass(frozen=True, slots=True)
class Noticeable:
    """The smallest fault that is worth a remark.

    lean: degrees. offset: fraction of the cell. size, weight: relative difference.
    at_most: remarks in all.
    """

    lean: float = 3.0
    offset: float = 0.06
    size: float = 0.12
    weight: float = 0.15
    at_most: int = 5


def remarks(
    registration: Registration, *, features: Features, noticeable: Noticeable | None = None
) -> tuple[Remark, ...]:
    """At most five remarks, the worst first."""
    limits = noticeable or Noticeable()
    found = [*_of_the_whole(features, registration, limits), *_of_regions(features, registration)]
    return tuple(sorted(found, key=lambda r: -r.severity)[: limits.at_most])


def _of_the_whole(features: Features, registration: Registration, limits: Noticeable) -> Iterator[Remark]:
    lean, size, weight = features.lean, np.expm1(features.size), np.expm1(features.weight)
    if abs(lean) >= limits.lean:
        zh, en = ("右", "clockwise") if lean > 0 else ("左", "anticlockwise")
        yield Remark(
            "lean", lean, "degrees", abs(lean), None,
            f"整字向{zh}倾斜 {abs(lean):.0f}°。先看范本的中轴，落笔时把重心扶正。",
            f"The whole character leans {abs(lean):.0f}° {en}. Find the master's axis and set yours upright.",
        )  # fmt: skip
    if abs(size) >= limits.size:
        zh, en, do_zh, do_en = (
            ("大", "larger", "收紧间架。", "Draw the frame in.")
            if size > 0
            else ("小", "smaller", "把间架撑开。", "Open the frame out.")
        )
        yield Remark(
            "size", float(size), "of the master", 40 * abs(features.size), None,
            f"整字比范本{zh} {abs(size):.0%}。{do_zh}",
            f"The whole character is {abs(size):.0%} {en} than the master. {do_en}",
        )  # fmt: skip
    if features.offset >= limits.offset:
        zh, en = _towards(registration.shift)
        yield Remark(
            "offset", features.offset, "of the cell", 60 * features.offset, None,
            f"整字在格中偏{zh}，离范本位置 {features.offset:.0%} 格。下笔前先定中心。",
            f"The whole stands {features.offset:.0%} of the cell too far to the {en}. Find the centre first.",
        )  # fmt: skip
    if abs(weight) >= limits.weight:
        zh, en, do_zh, do_en = (
            ("粗", "heavier", "行笔稍提，蘸墨少些。", "Lift the brush a little and take less ink.")
            if weight > 0
            else ("细", "thinner", "行笔按得实些。", "Press the brush more firmly.")
        )
        yield Remark(
            "heavy" if weight > 0 else "thin", float(weight), "of the master", 12 * abs(weight), None,
            f"笔画比范本{zh}约 {abs(weight):.0%}。{do_zh}",
            f"Strokes are about {abs(weight):.0%} {en} than the master's. {do_en}",
        )  # fmt: skip


def _of_regions(features: Features, registration: Registration) -> Iterator[Remark]:
    say = {"missing": _absent, "extra": _surplus, "displaced": _displaced}
    for region in features.regions:
        yield say[region.kind](region, registration)


def _absent(found: Region, registration: Registration) -> Remark:
    region, share = _region(found.points, registration), found.share
    zh, en = _place(region)
    return Remark(
        "missing", share, "of the ink", 150 * share, region,
        f"{zh}少写了一处，约占全字墨迹的 {share:.0%}。对照范本，把这一笔写足。",
        f"Something is missing at the {en}, about {share:.0%} of the ink. Write this stroke out in full.",
    )  # fmt: skip


def _surplus(found: Region, registration: Registration) -> Remark:
    region, share = _region(found.points, registration), found.share
    zh, en = _place(region)
    return Remark(
        "extra", share, "of the ink", 100 * share, region,
        f"{zh}多出一处，约占全字墨迹的 {share:.0%}。范本此处留白，收笔要早。",
        f"There is ink at the {en} where the master is blank, about {share:.0%}. End the stroke earlier.",
    )  # fmt: skip


def _displaced(found: Region, registration: Registration) -> Remark:
    cell = float(np.hypot(*found.moved)) * registration.reference.radius
    region = _region(found.points, registration)
    (zh, en), (to_zh, to_en) = _place(region), _towards(np.array(found.moved))
    return Remark(
        "displaced", cell, "of the cell", 120 * found.share, region,
        f"{zh}的笔画偏{to_zh}约 {cell:.0%} 格。看清它与邻笔的距离再落笔。",
        f"The stroke at the {en} stands about {cell:.0%} of the cell too far to the {to_en}. "
        "Measure its distance to its neighbour.",
    )  # fmt: skip


def _region(points: FloatArray, registration: Registration) -> tuple[float, float, float, float]:
    """Box of points given in the reference's frame, in fractions of the copy's cell, origin top left."""
    T, probe = registration.T_reference_probe, registration.probe
    local = (points - T[:2, 3]) @ T[:2, :2] * probe.radius + probe.centre
    x, y = 0.5 + local[:, 0] / probe.cell[0], 0.5 - local[:, 1] / probe.cell[1]
    box = np.clip((x.min(), y.min(), x.max(), y.max()), 0.0, 1.0)
    return float(box[0]), float(box[1]), float(box[2]), float(box[3])


_ROWS = (("上", "top"), ("中", "middle"), ("下", "bottom"))
_COLUMNS = (("左", "left"), ("", ""), ("右", "right"))
_COMPASS = (
    ("右", "right"), ("右上", "upper right"), ("上", "top"), ("左上", "upper left"),
    ("左", "left"), ("左下", "lower left"), ("下", "bottom"), ("右下", "lower right"),
)  # fmt: skip


def _place(region: tuple[float, float, float, float]) -> tuple[str, str]:
    """The ninth of the cell in which a box has its centre, in Chinese and English."""
    row = min(int(3 * (region[1] + region[3]) / 2), 2)
    column = min(int(3 * (region[0] + region[2]) / 2), 2)
    (row_zh, row_en), (column_zh, column_en) = _ROWS[row], _COLUMNS[column]
    if row == 1:
        return (column_zh + "侧", column_en) if column_zh else ("中部", "centre")
    return column_zh + row_zh + "部", f"{row_en} {column_en}".strip()


def _towards(vector: FloatArray) -> tuple[str, str]:
    """The nearest of eight directions, y up, in Chinese and English."""
    return _COMPASS[round(float(np.arctan2(vector[1], vector[0])) / (np.pi / 4)) % 8]
