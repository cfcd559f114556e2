"""A teacher's own marks -> a calibration that follows them, or the default if there are too few marks.

Three candidates are compared on held-out marks: the default as it is; the default with its scale moved,
mark = a + b score; and newly fitted weights. The simplest that no other clearly beats is chosen.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal, NamedTuple

import numpy as np

from rumu.assessment.calibration import Calibration, Charges, Scale
from rumu.assessment.features import Features, Residuals
from rumu.assessment.fitting import PARTS, WHOLE, Evidence, anchor_scale, fit_evidence
from rumu.errors import CalibrationError
from rumu.values import BoolArray, FloatArray, IntArray

FitKind = Literal["default", "scale", "weights"]
HeldOut = Literal["masters", "copies", "none"]


@dataclass(frozen=True, slots=True)
class TeacherSettings:
    """How many marks each kind of fit needs. Conventions.

    fewest: marks below which the default is kept. spread: standard deviation of marks, in points, below which
    they say nothing. weigh_from, weigh_masters: marks and masters from which weights are fitted at all.
    prior_copies: weight of the default in the moved scale, in copies.
    masters: from so many on, whole masters are held out; below, `folds` shares of the copies.
    confidence: one-sided, of a clear margin and of marks that follow the copies at all.
    gap: points by which the marks of anchors rise at least. reach: percentiles of the marks between which
    fitted weights are trusted.
    """

    fewest: int = 20
    spread: float = 1.0
    weigh_from: int = 200
    weigh_masters: int = 8
    prior_copies: float = 20.0
    masters: int = 3
    folds: int = 5
    confidence: float = 0.95
    gap: float = 1.0
    reach: tuple[float, float] = (5.0, 95.0)


class Agreement(NamedTuple):
    """error: mean absolute, in points; spearman: rank correlation, 0 where there is none to take."""

    error: float
    spearman: float


@dataclass(frozen=True, slots=True)
class TeacherFit:
    """What came of a teacher's marks.

    calibration: None when the default is kept. chosen: which was kept. why, why_zh: in words.
    copies, masters: how many were marked. held_out: what was left out to judge: whole masters, copies, or
    nothing, when there was too little to fit. default, scale, weights: how each agrees with marks held out;
    None where it was not or could not be fitted. inside: share of the marks that lie in the default's 80 %
    interval: one person's marks scatter more than the mean of many.
    """

    calibration: Calibration | None
    chosen: FitKind
    why: str
    why_zh: str
    copies: int
    masters: int
    held_out: HeldOut
    default: Agreement | None
    scale: Agreement | None = None
    weights: Agreement | None = None
    inside: float | None = None


def fit_teacher(
    features: Sequence[Features],
    marks: Sequence[float],
    masters: Sequence[str],
    *,
    base: Calibration,
    name: str = "marks",
    settings: TeacherSettings | None = None,
) -> TeacherFit:
    """A calibration that follows a teacher's marks, judged on marks held out.

    features: of N copies; marks: N, 0-100; masters: N, the master of each. base: the default. name: of the
    marks, for the provenance. Raises CalibrationError when the three are not alike in length, or a mark is
    outside 0-100.
    """
    marked = MarkedCopies(tuple(features), np.asarray(marks, float), tuple(masters))
    settings = settings or TeacherSettings()
    short = _find_shortage(marked, settings)
    if short is not None:
        default = agreement(_score_copies(base, marked), marked.marks) if len(marked.marks) else None
        counts = (len(marked.marks), len(set(marked.masters)))
        return TeacherFit(
            None, "default", *short, *counts, "none", default, inside=_share_inside(base, marked)
        )
    return _choose_fit(marked, base, name, settings)


def agreement(scores: FloatArray, marks: FloatArray) -> Agreement:
    """Of scores with marks, (N,) each."""
    from scipy.stats import spearmanr

    some = len(marks) > 2 and np.ptp(scores) > 0 and np.ptp(marks) > 0
    return Agreement(
        float(np.mean(np.abs(scores - marks))), float(spearmanr(scores, marks)[0]) if some else 0.0
    )


@dataclass(frozen=True, slots=True, eq=False)
class MarkedCopies:
    """Copies that a teacher marked: features, (N,) marks, the master of each."""

    features: tuple[Features, ...]
    marks: FloatArray
    masters: tuple[str, ...]

    def __post_init__(self) -> None:
        lengths = {len(self.features), len(self.marks), len(self.masters)}
        if len(lengths) > 1:
            raise CalibrationError(f"expected as many copies as marks and masters, got {sorted(lengths)}")
        if not ((self.marks >= 0) & (self.marks <= 100)).all():
            raise CalibrationError(
                f"expected marks from 0 to 100, got {self.marks.min()} to {self.marks.max()}"
            )

    def only(self, chosen: BoolArray) -> MarkedCopies:
        """Those of the copies that are chosen, (N,)."""
        features = tuple(f for f, keep in zip(self.features, chosen, strict=True) if keep)
        masters = tuple(m for m, keep in zip(self.masters, chosen, strict=True) if keep)
        return MarkedCopies(features, self.marks[chosen], masters)


Maker = Callable[[MarkedCopies], Calibration]


def _find_shortage(marked: MarkedCopies, settings: TeacherSettings) -> tuple[str, str] | None:
    n = len(marked.marks)
    if n < settings.fewest:
        return (
            f"{n} marks are too few: {settings.fewest} are needed to move the scale.",
            f"只有 {n} 個評分，至少要 {settings.fewest} 個才能調整分數的尺度。",
        )
    if float(np.std(marked.marks)) < settings.spread:
        return (
            "The marks are all but the same, so they do not tell a good copy from a bad one.",
            "評分幾乎全部相同，看不出好壞之分。",
        )
    return None


def _choose_fit(marked: MarkedCopies, base: Calibration, name: str, settings: TeacherSettings) -> TeacherFit:
    """All that can be fitted, judged on marks held out; the simplest that none beats clearly."""
    makers: dict[FitKind, Maker] = {
        "default": lambda _: base,
        "scale": lambda known: move_scale(
            base, *fit_line(known.features, known.marks, base=base, settings=settings), gap=settings.gap
        ),
        "weights": lambda known: _fit_weights(known, settings),
    }
    folds = _assign_folds(marked.masters, settings)
    by_master = len(set(marked.masters)) >= settings.masters
    many = len(marked.marks) >= settings.weigh_from and len(set(marked.masters)) >= settings.weigh_masters
    scores: dict[FitKind, FloatArray] = {}
    for kind, maker in makers.items():
        if kind != "weights" or many:
            held = _score_held_out(marked, maker, folds)
            if held is not None:
                scores[kind] = held
    agreements = {kind: agreement(held, marked.marks) for kind, held in scores.items()}
    chosen = _choose_simplest(scores, marked, folds, settings)
    own = None
    if chosen != "default":
        interval = held_out_interval(marked.marks - scores[chosen])
        provenance = _describe_provenance(marked, chosen, agreements, base, name, by_master=by_master)
        own = replace(makers[chosen](marked), interval=interval, provenance=provenance)
    return TeacherFit(
        own,
        chosen,
        *_explain(chosen, agreements, len(marked.marks)),
        len(marked.marks),
        len(set(marked.masters)),
        "masters" if by_master else "copies",
        agreements["default"],
        agreements.get("scale"),
        agreements.get("weights"),
        _share_inside(base, marked),
    )


def fit_line(
    features: Sequence[Features],
    marks: FloatArray,
    *,
    base: Calibration,
    settings: TeacherSettings | None = None,
) -> tuple[float, float]:
    """(a, b) of mark = a + b score, drawn to (0, 1) by `prior_copies` copies marked as the default does.

    It is the reading of the scale that is moved, before charges; copies under a ceiling say nothing of it.
    Raises CalibrationError when the marks do not rise with the score.
    """
    prior, charges = (settings or TeacherSettings()).prior_copies, Charges()
    read = np.array([base.scale.read(f) for f in features])
    wanted = np.asarray(marks, float) + [charges.all_points(f) for f in features]
    highest = np.array([charges.stroke_points(f)[1] for f in features])
    bound = (highest < 100.0) & (highest < np.maximum(read, wanted))
    x, y = read[~bound], wanted[~bound]
    if len(x) < 2 or np.var(x) < 1e-9:
        raise CalibrationError("expected copies that differ in their score, got none")
    slope = float(np.cov(x, y, bias=True)[0, 1] / np.var(x))
    if slope <= 0:
        raise CalibrationError("expected marks that rise with the score, got marks that fall")
    n = len(x)
    b = (n * slope + prior) / (n + prior)
    return float((n * y.mean() + prior * x.mean()) / (n + prior) - b * x.mean()), b


def move_scale(base: Calibration, a: float, b: float, *, gap: float = TeacherSettings().gap) -> Calibration:
    """The calibration whose anchors read a + b times their marks; nothing and perfection stay 0 and 100."""
    parts = {name: _move_anchors(scale, a, b, gap) for name, scale in base.parts.items()}
    return replace(base, scale=_move_anchors(base.scale, a, b, gap), parts=parts, standing=())


def held_out_interval(errors: FloatArray) -> tuple[float, float]:
    """Offsets of the 80 % interval, from errors (mark less score) of copies held out.

    Order statistics at which a further copy falls below or above with a chance of a tenth at most, so that
    few errors make it wider, not narrower. It holds the score itself.
    """
    n = len(errors)
    ordered = np.sort(errors)
    outside = (n + 1) // 10
    low, high = ordered[max(outside - 1, 0)], ordered[min(n - outside, n - 1)]
    return min(float(low), 0.0), max(float(high), 0.0)


def _move_anchors(scale: Scale, a: float, b: float, gap: float) -> Scale:
    marks = np.array([mark for _, mark in scale.anchors])
    last = len(marks) - 1
    wanted = a + b * marks
    wanted[0], wanted[last] = 0.0, 100.0
    for k in range(1, last):
        # Room is left for what lies above, so that anchors rise to 100 whatever the line asks.
        wanted[k] = np.clip(wanted[k], wanted[k - 1] + gap, 100.0 - gap * (last - k))
    anchors = tuple((total, float(mark)) for (total, _), mark in zip(scale.anchors, wanted, strict=True))
    return replace(scale, anchors=anchors)


_PERFECT = Features(Residuals(), lean=0.0, offset=0.0, size=0.0, weight=0.0)


def _fit_weights(known: MarkedCopies, settings: TeacherSettings) -> Calibration:
    """Weights from this teacher's marks alone; interval and provenance are for the caller to fill in."""
    vectors = np.array([f.vector() for f in known.features])
    charged = known.marks + [Charges().all_points(f) for f in known.features]
    low, high = np.clip(np.percentile(known.marks, settings.reach), settings.gap, 100.0 - settings.gap)

    def fitted(evidence: Evidence) -> Scale:
        scale = fit_evidence(vectors, charged, known.masters, evidence=evidence)
        reach = (float(low), min(float(high), scale.weighted_sum(_PERFECT.vector()) - settings.gap))
        return anchor_scale(scale, reach=reach)

    parts = {part: fitted(evidence) for part, evidence in PARTS.items()}
    return Calibration(fitted(WHOLE), parts, (0.0, 0.0), "")


def _assign_folds(masters: Sequence[str], settings: TeacherSettings) -> IntArray:
    """(N,) the fold of each copy: its master where there are enough, else shares drawn once and for all."""
    names = sorted(set(masters))
    if len(names) >= settings.masters:
        return np.array([names.index(master) for master in masters])
    return np.random.default_rng(0).permutation(len(masters)) % settings.folds


def _score_held_out(marked: MarkedCopies, maker: Maker, folds: IntArray) -> FloatArray | None:
    """(N,) the score of each copy by a calibration made without its fold; None where one cannot be made."""
    scores = np.empty(len(marked.marks))
    for fold in np.unique(folds):
        own = folds == fold
        try:
            scores[own] = _score_copies(maker(marked.only(~own)), marked.only(own))
        except CalibrationError:
            return None
    return scores


def _share_inside(calibration: Calibration, marked: MarkedCopies) -> float | None:
    """Share of the marks in the interval around their scores."""
    if not len(marked.marks):
        return None
    low, high = np.array([calibration.interval_of(score) for score in _score_copies(calibration, marked)]).T
    return float(np.mean((low <= marked.marks) & (marked.marks <= high)))


def _score_copies(calibration: Calibration, marked: MarkedCopies) -> FloatArray:
    return np.array([calibration.score(f) for f in marked.features])


def _choose_simplest(
    scores: Mapping[FitKind, FloatArray], marked: MarkedCopies, folds: IntArray, settings: TeacherSettings
) -> FitKind:
    """The first kind that no other beats clearly; only what follows the marks at all may beat another."""
    marks = marked.marks
    sensible = [kind for kind in scores if _follows_marks(scores[kind], marks, settings)]
    whole_masters = len(set(marked.masters)) >= settings.masters
    clusters = folds if whole_masters else np.arange(len(marks))
    for kind in scores:
        if kind != "default" and kind not in sensible:
            continue
        error = np.abs(scores[kind] - marks)
        gains = (error - np.abs(scores[other] - marks) for other in sensible if other != kind)
        if not any(_is_clear_gain(gain, clusters, settings) for gain in gains):
            return kind
    return "default"


def _follows_marks(scores: FloatArray, marks: FloatArray, settings: TeacherSettings) -> bool:
    """Whether the order of the scores is that of the marks beyond chance."""
    from scipy.stats import norm

    chance = float(norm.ppf(settings.confidence)) / float(np.sqrt(len(marks) - 1))
    return agreement(scores, marks).spearman > chance


def _is_clear_gain(gain: FloatArray, clusters: IntArray, settings: TeacherSettings) -> bool:
    """Whether a gain, (N,) points less error, is above nought beyond chance; a cluster stands together."""
    from scipy.stats import t

    names = np.unique(clusters)
    mean = float(gain.mean())
    sums = np.array([(gain[clusters == name] - mean).sum() for name in names])
    error = float(np.sqrt(np.sum(sums**2) * len(names) / (len(names) - 1))) / len(gain)
    return bool(mean > max(float(t.ppf(settings.confidence, len(names) - 1)) * error, 0.0))


def _explain(chosen: FitKind, agreements: Mapping[FitKind, Agreement], n: int) -> tuple[str, str]:
    """Why a fit was kept, in English and in Chinese; n: marks."""
    before, after = agreements["default"].error, agreements[chosen].error
    if chosen == "scale":
        return (
            f"On marks held out the moved scale errs by {after:.1f} points, the default by {before:.1f}.",
            f"在留出的評分上，調整尺度後平均誤差為 {after:.1f} 分，默認為 {before:.1f} 分。",
        )
    if chosen == "weights":
        return (
            f"On marks held out the new weights err by {after:.1f} points, the default by {before:.1f}.",
            f"在留出的評分上，重新擬合權重後平均誤差為 {after:.1f} 分，默認為 {before:.1f} 分。",
        )
    return (
        f"Nothing fitted to these {n} marks is clearly nearer to marks held out than the default "
        f"(error {before:.1f} points).",
        f"用這 {n} 個評分擬合的結果，在留出的評分上都不明顯優於默認（平均誤差 {before:.1f} 分）。",
    )


def _describe_provenance(
    marked: MarkedCopies,
    chosen: FitKind,
    agreements: Mapping[FitKind, Agreement],
    base: Calibration,
    name: str,
    *,
    by_master: bool,
) -> str:
    held = "whole masters held out" if by_master else "copies held out, of the same masters"
    what = (
        f"weights fitted to {len(marked.marks)} marks of copies of"
        if chosen == "weights"
        else f"scale moved to follow {len(marked.marks)} marks of copies of"
    )
    start = "" if chosen == "weights" else f"; weights from {base.provenance}"
    return (
        f"{what} {len(set(marked.masters))} masters ({name}); error {agreements[chosen].error:.1f} points, "
        f"{agreements['default'].error:.1f} before ({held}){start}"
    )
