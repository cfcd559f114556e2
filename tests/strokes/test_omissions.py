"""What a copy lacks and has too much, on real masters: a stroke taken out, one put in, one displaced."""

import cv2
import numpy as np
import pytest

from rumu import pipeline
from rumu.gallery.starter import find_work
from rumu.pipeline import measure
from rumu.strokes.omissions import find_regions
from rumu_lab.simulation.copies import copy_at
from rumu_lab.simulation.faults import apply
from rumu_lab.simulation.glyph import Glyph

WORKS = ("regular-shui", "regular-shu", "clerical-ri", "seal-tian", "running-tian", "cursive-ren")


def picture(ink):
    return np.asarray(np.round(255.0 * (1.0 - np.asarray(ink, np.float32))), np.uint8)


@pytest.fixture(scope="module", params=WORKS)
def glyph(request):
    mask = pipeline.surface_of(find_work(request.param).path).mask.astype(np.float32)
    return Glyph(np.pad(cv2.resize(mask, (224, 224), interpolation=cv2.INTER_AREA) > 0.5, 16))


def marked(ink, glyph):
    return pipeline.assess(picture(ink), picture(glyph.mask), remarks=False)


def regions(ink, glyph):
    """{kind: region} of ink as a copy of a glyph."""
    master = pipeline.prepare_master(picture(glyph.mask))
    registration = measure(pipeline.surface_of(picture(ink)), master).registration
    return {region.kind: region for region in find_regions(registration, master.ink)}


def hidden(glyph, k):
    """Share of the ink that goes when stroke k is left out."""
    return 1.0 - glyph.without(k).sum() / glyph.mask.sum()


def test_a_stroke_left_out_never_raises_the_mark_and_a_whole_one_is_not_good(glyph):
    whole = marked(glyph.mask, glyph)
    assert whole.score > 95
    for k in range(len(glyph.strokes)):
        without = marked(glyph.without(k), glyph)
        if without.refused:
            continue
        assert without.score <= whole.score
        if hidden(glyph, k) > 0.12:
            assert without.level in ("medium", "bad") and without.score < 50


@pytest.mark.parametrize(("fault", "severity"), [("squeeze", 1.5), ("uneven", 2.0), ("thick", 2.0)])
def test_of_an_imperfect_copy_too(glyph, fault, severity):
    copy = apply(glyph.mask, fault, severity=severity, seed=4)
    whole, strokes = marked(copy.ink, glyph), Glyph(copy.mask)
    assert whole.score > 50
    longest = marked(strokes.without(0), glyph)
    assert longest.refused or longest.score < min(whole.score - 5, 56)


def test_strokes_too_many_lower_the_mark(glyph):
    more = apply(glyph.mask, "extra", severity=2.0, seed=1)
    assert marked(more.ink, glyph).score < 80
    assert regions(more.ink, glyph)["extra"].share > 0.02


@pytest.mark.parametrize(
    ("fault", "severity"), [("shift", 3.0), ("angle", 3.0), ("thin", 2.0), ("lean", 2.0)]
)
def test_what_is_displaced_or_thin_is_not_missing(glyph, fault, severity):
    found = regions(apply(glyph.mask, fault, severity=severity, seed=2).ink, glyph)
    assert "missing" not in found or found["missing"].strokes < 0.1


def test_a_copy_that_plainly_lacks_nothing_is_not_asked_further(glyph):
    assert regions(glyph.mask, glyph) == {}


def test_a_blur_does_not_decide_whether_a_stroke_is_missing():
    """Two horizontals of this copy nearly meet, so that a blur joins them or not."""
    master = find_work("seal-shu").path
    light = 1.0 - copy_at(pipeline.surface_of(master).mask, "good", seed=11).ink
    copies = [light] + [cv2.GaussianBlur(light, (0, 0), sigma) for sigma in (1.0, 2.0)]
    scores = [pipeline.assess(copy, master, remarks=False).score for copy in copies]
    assert max(scores) - min(scores) < 2.0


def test_where_a_missing_stroke_should_stand_is_told(glyph):
    k = int(np.argmax([hidden(glyph, k) for k in range(len(glyph.strokes))]))
    found = regions(glyph.without(k), glyph)["missing"]
    assert found.share > 0.3 * hidden(glyph, k)
    rows, columns = np.nonzero(glyph.strokes[k].ink)
    # the frame's unit is the rms radius of the master's ink about its centroid, y up
    y, x = (v.astype(float) for v in np.nonzero(glyph.mask))
    radius = np.sqrt(np.var(x) + np.var(y))
    at = found.points * [radius, -radius] + [x.mean(), y.mean()]
    apart = np.hypot(at[:, :1] - columns, at[:, 1:] - rows).min(axis=1)
    assert (apart < 0.15 * radius).mean() > 0.6


def test_the_mark_falls_as_a_stroke_is_shortened():
    glyph = Glyph(np.pad(pipeline.surface_of(find_work("regular-shui").path).mask, 16))
    marks = [
        marked(apply(glyph.mask, "short", severity=s, seed=3).ink, glyph).score for s in (0.0, 1.5, 3.0, 5.0)
    ]
    assert marks == sorted(marks, reverse=True) and marks[-1] < marks[0] - 10
