"""Features -> a mark on the scale of a human panel, with an interval and a level, on a teacher's terms.

The panel's scale is the mean of its raters times ten. The weights, fitted once on human marks, stand in
panel.json beside this file with where they come from; `rumu experiments run e3c` says how well they hold
on characters held out.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import lru_cache
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np

from rumu.assessment.features import FEATURE_NAMES, RESIDUALS, Features
from rumu.errors import CalibrationError
from rumu.inputs import read_json
from rumu.values import SCRIPTS, Bilingual, FloatArray, Level, Script

Cuts = Mapping[Level, float]
Weights = Mapping[str, float]

PART_NAMES = ("brushwork", "structure", "ink")
"""The parts that a mark is given for, and that a teacher may weigh."""

MAX_Z = 3.0
"""Standard deviations at which features other than residuals are clipped."""
WIDENING = 1.5
"""The interval of a script that no human marks cover, over that of regular script: a declared convention,
since there is nothing to measure it on."""

CUT_OFFS: Mapping[str, Cuts] = {
    # where levels agree best with those of people's marks on characters left out: of learners' copies about
    # an eighth are excellent, 30 % good, 35 % medium and a quarter bad, see `rumu experiments run nested`
    "panel": {"excellent": 61.0, "good": 54.0, "medium": 45.0},
    # midpoints between the bands of a published copying-exam rubric (18-20, 15-17, 11-14, up to 10 of 20)
    "rubric": {"excellent": 87.5, "good": 72.5, "medium": 52.5},
}
"""Named cut-offs: the lowest score of each level; below the last is 'bad'."""


@dataclass(frozen=True, slots=True)
class Charges:
    """Points deducted for lean, offset, size, and missing or surplus strokes: conventions, not fitted.

    Registration removes lean, offset and size, so points are deducted for each unit beyond a free part, up to
    `cap` each. Copies that people marked lie within it but for a few, which they did not mark down; they mark
    large writing up and small writing down. A missing or surplus stroke hardly
    changes the quartiles of an otherwise perfect copy: `ceilings` give the highest score by the number of
    usual strokes that are missing, (strokes, score), linear between, and `surplus_ceilings` by how many are
    too many. These fall gently: how much ink is too much is less sure than that a stroke is missing, and a
    fifth of a stroke more or less must not decide the mark of a common copy. `stroke_rate` points are
    deducted besides for the first stroke, so that a bad copy loses points too; there surplus ink counts by
    `surplus`.
    """

    lean_free: float = 10.0  # degrees
    lean_rate: float = 2.0  # points per degree
    offset_free: float = 0.15  # fraction of the cell
    offset_rate: float = 100.0  # points per cell
    small_free: float = 0.3  # natural logarithm, below the master's size
    large_free: float = 0.5  # the same, above it
    size_rate: float = 40.0  # points per unit of natural logarithm
    cap: float = 40.0
    ceilings: tuple[tuple[float, float], ...] = (
        (0.0, 100.0), (0.1, 75.0), (0.25, 46.0), (0.5, 37.0), (3.0, 8.0),
    )  # fmt: skip
    surplus_ceilings: tuple[tuple[float, float], ...] = (
        (0.0, 100.0), (0.25, 72.0), (1.0, 37.0), (6.0, 8.0),
    )  # fmt: skip
    surplus: float = 0.3  # strokes left out for one too many
    stroke_rate: float = 15.0  # points per stroke

    def pose_points(self, features: Features) -> dict[str, float]:
        """Points deducted for 'lean', 'offset' and 'size'."""
        over = {
            "lean": self.lean_rate * (abs(features.lean) - self.lean_free),
            "offset": self.offset_rate * (features.offset - self.offset_free),
            "size": self.size_rate * max(-features.size - self.small_free, features.size - self.large_free),
        }
        return {name: float(min(max(value, 0.0), self.cap)) for name, value in over.items()}

    def stroke_points(self, features: Features) -> tuple[float, float]:
        """(points deducted, highest score) for missing and surplus strokes."""
        missing, extra = (
            sum(region.strokes for region in features.regions if region.kind == kind)
            for kind in ("missing", "extra")
        )
        lacking = np.interp(missing, *np.array(self.ceilings).T)
        too_many = np.interp(extra, *np.array(self.surplus_ceilings).T)
        return self.stroke_rate * min(missing + self.surplus * extra, 1.0), float(min(lacking, too_many))

    def all_points(self, features: Features) -> float:
        """All points deducted, those for pose and those for strokes."""
        return sum(self.pose_points(features).values()) + self.stroke_points(features)[0]


@dataclass(frozen=True, slots=True)
class Scale:
    """A weighted sum of features that reads as marks: mean + sum weight_i * (x_i - centre_i) / spread_i.

    names: the features that are weighed; centre, spread, weights: one for each name. Weights are zero or
    negative, except for `features.SIGNED_FEATURES`, so no residual can raise a mark. Features other than
    residuals are clipped at MAX_Z. anchors: ((sum, mark), ...), rising: where another character, the human
    range and a perfect copy lie; linear between, so the order of copies does not change.
    """

    names: tuple[str, ...]
    centre: tuple[float, ...]
    spread: tuple[float, ...]
    weights: tuple[float, ...]
    mean: float
    anchors: tuple[tuple[float, float], ...] = ((0.0, 0.0), (100.0, 100.0))

    def weighted_sum(self, vector: FloatArray) -> float:
        """The sum of a feature vector, (len(FEATURE_NAMES),), before it is anchored; without bounds."""
        return float(self.weighted_sums(vector[None])[0])

    def weighted_sums(self, vectors: FloatArray) -> FloatArray:
        """(N,) the sums of N feature vectors."""
        chosen = [_INDEX[name] for name in self.names]
        z = (vectors[:, chosen] - np.array(self.centre)) / np.array(self.spread)
        far = np.where([name in RESIDUALS for name in self.names], np.inf, MAX_Z)
        return np.asarray(self.mean + np.clip(z, -far, far) @ np.array(self.weights))

    def read(self, features: Features) -> float:
        """The mark, 0-100."""
        return float(self.read_all(features.vector()[None])[0])

    def read_all(self, vectors: FloatArray) -> FloatArray:
        """(N,) the marks of N feature vectors."""
        sums, marks = zip(*self.anchors, strict=True)
        return np.asarray(np.interp(self.weighted_sums(vectors), sums, marks))


_INDEX = {name: k for k, name in enumerate(FEATURE_NAMES)}


@dataclass(frozen=True, slots=True)
class Calibration:
    """How features become a mark.

    scale: over all features; parts: the same for 'structure' and 'brushwork' on their own features, fitted to
        the same marks, since nobody marked the parts.
    interval: (low, high) offsets of the 80 % interval, from errors on characters held out.
    provenance: what was fitted on what, in words.
    standing: scores of learners' copies on characters held out, at equal steps from the lowest to the
        highest; empty where it is not known.
    """

    scale: Scale
    parts: Mapping[str, Scale]
    interval: tuple[float, float]
    provenance: str
    standing: tuple[float, ...] = ()

    def score(self, features: Features, *, weights: Weights | None = None) -> float:
        """0-100; 100 for a perfect copy in its place.

        weights: a teacher's own, of the parts; None for the fitted ones. Charges and ceilings are the same.
        """
        charges = Charges()
        if weights is None:
            whole = self.scale.read(features)
        else:
            parts = self.part_scores(features)
            whole = sum(parts[name] * weight for name, weight in weights.items()) / sum(weights.values())
        points, highest = charges.stroke_points(features)
        whole = min(whole - points, highest)
        return float(np.clip(whole - sum(charges.pose_points(features).values()), 0.0, 100.0))

    def part_scores(self, features: Features) -> dict[str, float]:
        """'brushwork', 'structure' and 'ink', each 0-100.

        ink is a declared convention: 100 for the master's weight of ink, halved for each
        quarter more or less.
        """
        read = {name: scale.read(features) for name, scale in self.parts.items()}
        return read | {"ink": float(100.0 * 0.5 ** (abs(features.weight) / np.log(1.25)))}

    def interval_of(self, score: float, *, widened: float = 1.0) -> tuple[float, float]:
        """The 80 % interval of the panel's mark around a score, within 0-100; `widened`: a factor."""
        offsets = np.array(self.interval) * widened
        low, high = np.clip(score + offsets, 0.0, 100.0)
        return float(low), float(high)

    def percentile_of(self, score: float) -> float | None:
        """The share of learners' copies that get less, in per cent; None where it is not known."""
        if not self.standing:
            return None
        return float(np.interp(score, self.standing, np.linspace(0.0, 100.0, len(self.standing))))


def level_of(score: float, *, cuts: Cuts | None = None) -> Level:
    """The level of a score, by the panel's cut-offs unless others are given."""
    for level, lowest in (cuts or CUT_OFFS["panel"]).items():
        if score >= lowest:
            return level
    return "bad"


def _numbers_of(table: Mapping[str, Any], names: Sequence[str]) -> list[float]:
    """The numbers of a table that has these names and no others; none of anything else."""
    try:
        given = dict(table)
        return [float(given[name]) for name in names] if len(given) == len(names) else []
    except (KeyError, TypeError, ValueError):
        return []


def check_cuts(cuts: Mapping[str, Any], *, name: str) -> Cuts:
    """A teacher's own cut-offs, checked. Raises CalibrationError naming what was expected."""
    expected = tuple(CUT_OFFS["panel"])
    values = _numbers_of(cuts, expected)
    if not values or not 100 >= values[0] > values[1] > values[2] >= 0:
        raise CalibrationError(f"{name}: expected cut-offs 100 >= {' > '.join(expected)} >= 0, got {cuts!r}")
    return dict(zip(expected, values, strict=True))  # type: ignore[arg-type]


def check_weights(weights: Mapping[str, Any], *, name: str) -> Weights:
    """A teacher's own weights of the parts, checked. Raises CalibrationError naming what was expected."""
    values = _numbers_of(weights, PART_NAMES)
    if not values or not min(values) >= 0 or not 0 < sum(values) < np.inf:
        raise CalibrationError(
            f"{name}: expected weights of {', '.join(PART_NAMES)}, each at least 0 and not all 0, "
            f"got {weights!r}"
        )
    return dict(zip(PART_NAMES, values, strict=True))


@lru_cache(maxsize=1)
def panel() -> Calibration:
    """The calibration that ships with rumu."""
    return read_calibration(json.loads((files("rumu.assessment") / "panel.json").read_text("utf-8")))


def load_calibration(path: str | Path) -> Calibration:
    """The Calibration that a file holds. Raises CalibrationError with the file and what is wrong with it."""
    if not Path(path).exists():
        raise CalibrationError(f"{path}: there is no such file")
    plain = read_json(path, error_type=CalibrationError, expected="a calibration in JSON")
    try:
        return read_calibration(plain)
    except (OSError, ValueError) as error:
        raise CalibrationError(f"{path}: expected a calibration in JSON, cannot read it ({error})") from error
    except CalibrationError as error:
        raise CalibrationError(f"{path}: {error}") from error


def read_calibration(plain: Mapping[str, Any]) -> Calibration:
    """A Calibration from its plain form (what json.loads gives)."""
    try:
        low, high = map(float, plain["interval"])
        calibration = Calibration(
            scale=_read_scale(plain["scale"]),
            parts={name: _read_scale(plain["parts"][name]) for name in ("structure", "brushwork")},
            interval=(low, high),
            provenance=str(plain["provenance"]),
            standing=tuple(map(float, plain.get("standing", ()))),
        )
        if not (np.diff(calibration.standing) >= 0).all():
            raise ValueError("standing: expected scores that do not fall")
        if not -np.inf < low <= 0 <= high < np.inf:
            raise ValueError(f"interval: expected low <= 0 <= high, got {low}, {high}")
    except (AttributeError, IndexError, KeyError, TypeError, ValueError) as error:
        raise CalibrationError(
            f"expected a calibration with scale, parts and interval ({type(error).__name__}: {error})"
        ) from error
    return calibration


def write_calibration(calibration: Calibration, path: str | Path) -> None:
    """Write the plain form as JSON, whole or not at all."""
    from rumu.outputs import whole_file

    with whole_file(path) as part:
        part.write_text(json.dumps(asdict(calibration), ensure_ascii=False, indent=2) + "\n", "utf-8")


def _read_scale(plain: Mapping[str, Any]) -> Scale:
    """A Scale from its plain form; raises what `read_calibration` turns into words."""
    scale = Scale(
        names=tuple(plain["names"]),
        centre=tuple(map(float, plain["centre"])),
        spread=tuple(map(float, plain["spread"])),
        weights=tuple(map(float, plain["weights"])),
        mean=float(plain["mean"]),
        anchors=tuple((float(total), float(mark)) for total, mark in plain["anchors"]),
    )
    unknown = set(scale.names) - set(FEATURE_NAMES)
    if unknown:
        raise ValueError(f"features that rumu knows, got {', '.join(sorted(map(str, unknown)))}")
    numbers = np.array([scale.centre, scale.spread, scale.weights])  # raises when they are not alike
    if numbers.shape != (3, len(scale.names)) or not np.isfinite([*numbers.ravel(), scale.mean]).all():
        raise ValueError("one finite centre, spread and weight for each name")
    rising = np.diff(np.array(scale.anchors), axis=0)
    if not (numbers[1] > 0).all() or len(scale.anchors) < 2 or not (rising > 0).all():
        raise ValueError(f"spreads above 0 and anchors that rise, got {scale.anchors}")
    return scale


def check_script(script: str | None, *, name: str = "script") -> Script | None:
    """The script, or None where it is not known. Raises CalibrationError that names the five."""
    for known in SCRIPTS:
        if script == known:
            return known
    if script is None:
        return None
    raise CalibrationError(f"{name}: expected one of {', '.join(SCRIPTS)}, got {script!r}")


@dataclass(frozen=True, slots=True)
class MarkingTerms:
    """How a copy is to be marked.

    calibration: None for the one that ships with rumu. weights: of the parts; None for the fitted ones.
    cuts: of the levels; None for the panel's. script: None when it is not known.
    """

    calibration: Calibration | None = None
    weights: Weights | None = None
    cuts: Cuts | None = None
    script: Script | None = None


def check_terms(
    *,
    calibration: Calibration | str | Path | None = None,
    weights: Mapping[str, float] | None = None,
    levels: Mapping[str, float] | None = None,
    script: str | None = None,
) -> MarkingTerms:
    """The terms as a person gives them. Raises CalibrationError that says what was expected."""
    return MarkingTerms(
        calibration=load_calibration(calibration) if isinstance(calibration, str | Path) else calibration,
        weights=None if weights is None else check_weights(weights, name="weights"),
        cuts=None if levels is None else check_cuts(levels, name="levels"),
        script=check_script(script),
    )


def mark_fields(features: Features, *, terms: MarkingTerms, highest: float = 100.0) -> dict[str, Any]:
    """Those fields of an Assessment that follow from features and terms: the mark and what it rests on.

    highest: the mark that the copy may reach, 0-100; see `refusal.check_copy`.
    """
    calibration = terms.calibration or panel()
    score = min(calibration.score(features, weights=terms.weights), highest)
    widened = 1.0 if terms.calibration or terms.script in (None, "regular") else WIDENING
    note = _OWN_CALIBRATION if terms.calibration else interval_note(terms.script)
    notes = [note for note in (note, _OWN_WEIGHTS if terms.weights else None) if note]
    return {
        "score": score,
        "level": level_of(score, cuts=terms.cuts),
        "percentile": None if terms.weights else calibration.percentile_of(score),
        "interval": calibration.interval_of(score, widened=widened),
        "parts": calibration.part_scores(features),
        "deductions": {name: points for name, points in Charges().pose_points(features).items() if points},
        "script": terms.script,
        "weights": terms.weights,
        "calibration": terms.calibration and terms.calibration.provenance,
        "interval_note": " ".join(note.en for note in notes) or None,
        "interval_note_zh": "".join(note.zh for note in notes) or None,
    }


_OWN_CALIBRATION = Bilingual(
    "區間只適用於與校準所用相近的臨作。",
    "The interval holds for copies like those whose marks the calibration was fitted to.",
)
_OWN_WEIGHTS = Bilingual(
    "區間按擬合的權重測得；換成自定的權重後僅供參考。",
    "The interval was measured for the fitted weights; with your own it is only a guide.",
)


def interval_note(script: Script | None) -> Bilingual | None:
    """What must be said of the panel's interval for a script; None where it was measured on that script."""
    if script == "regular":
        return None
    if script is None:
        return Bilingual(
            "區間由楷書臨作測得；其他書體的區間應更寬。",
            "The interval was measured on regular script; for other scripts it is too narrow.",
        )
    return Bilingual(
        f"{SCRIPTS[script]}沒有真人評分：區間取自楷書，並按約定放寬為 {WIDENING:g} 倍。",
        f"No human marks cover {script} script: the interval is that of regular script, widened {WIDENING:g} "
        "times by convention.",
    )
