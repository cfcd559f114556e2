"""The works that come with the package: all there, each whole, each told apart, each credited."""

from __future__ import annotations

import dataclasses
import functools
import hashlib
from collections import Counter
from itertools import combinations, pairwise
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from rumu.errors import GalleryError
from rumu.gallery import starter
from rumu.gallery.starter import (
    SCRIPTS,
    Sample,
    StarterWork,
    brush_works,
    find_work,
    starter_samples,
    starter_works,
)
from rumu.values import Bilingual

CHARACTERS = "天人水書日月"


@functools.cache
def ink(item: StarterWork | Sample) -> np.ndarray:
    return np.asarray(Image.open(item.path)) < 128


def likeness(a: np.ndarray, b: np.ndarray) -> float:
    return float((a & b).sum() / (a | b).sum())


def test_thirty_works_six_in_each_of_five_scripts() -> None:
    all_works = starter_works()
    assert len(all_works) == 30
    assert Counter(w.script for w in all_works) == dict.fromkeys(SCRIPTS, 6)
    assert {(w.script, w.character) for w in all_works} == {(s, c) for s in SCRIPTS for c in CHARACTERS}
    assert len({w.id for w in all_works}) == 30
    assert all(w.id.isascii() and w.id == w.id.lower() for w in all_works)


@pytest.mark.parametrize(
    "item", [*starter_works(), *brush_works(), *starter_samples()], ids=lambda item: item.id
)
def test_every_entry_is_whole_and_its_picture_is_the_one_it_names(item: StarterWork | Sample) -> None:
    for field in dataclasses.fields(item):
        value = getattr(item, field.name)
        assert value not in ("", None, ()), field.name
        if isinstance(value, Bilingual):
            assert value.zh
            assert value.en
            assert any("一" <= ch <= "鿿" for ch in value.zh)
    assert hashlib.sha256(item.path.read_bytes()).hexdigest() == item.sha256
    with Image.open(item.path) as image:
        assert (image.size, image.mode) == ((512, 512), "L")
    mask = ink(item)
    assert 0.02 < mask.mean() < 0.35
    assert not (mask[0].any() or mask[-1].any() or mask[:, 0].any() or mask[:, -1].any())


@pytest.mark.parametrize("work", [*starter_works(), *brush_works()], ids=lambda work: work.id)
def test_the_ink_s_box_is_centred_and_of_the_agreed_size(work: StarterWork) -> None:
    rows, columns = (np.flatnonzero(ink(work).any(axis=axis)) for axis in (1, 0))
    low = np.array([rows[0], columns[0]])
    high = np.array([rows[-1], columns[-1]]) + 1
    np.testing.assert_allclose((low + high) / 2, 256.0, atol=1.5)
    share, area = (high - low).max() / 512, np.prod((high - low) / 512)
    assert share == pytest.approx(0.76, abs=0.01) or area == pytest.approx(0.42, abs=0.01)


def test_two_characters_by_four_brush_hands() -> None:
    assert Counter(w.character for w in brush_works()) == {"永": 4, "之": 4}
    assert {w.script for w in brush_works()} == {"regular", "running", "cursive"}
    assert all("OFL-1.1" in w.licence and "Project Authors" in w.attribution for w in brush_works())
    assert max(likeness(ink(a), ink(b)) for a, b in combinations(brush_works(), 2)) < 0.75
    assert find_work("ma-shan-zheng-yong").character == "永"


def test_edges_are_soft_not_cut_out() -> None:
    for work in starter_works():
        gray = np.asarray(Image.open(work.path))
        assert ((gray > 20) & (gray < 235)).sum() > 500, work.id


@pytest.mark.parametrize("character", CHARACTERS)
def test_the_five_scripts_of_a_character_are_five_pictures(character: str) -> None:
    pictures = [ink(w) for w in starter_works(character=character)]
    assert len(pictures) == 5
    assert max(likeness(a, b) for a, b in combinations(pictures, 2)) < 0.75


def test_no_two_works_share_a_picture() -> None:
    """A substitute for a missing glyph, such as a stamp, would come out the same for two characters."""
    assert max(likeness(ink(a), ink(b)) for a, b in combinations(starter_works(), 2)) < 0.8


def test_hands_are_credited_as_their_licences_ask() -> None:
    for work in starter_works(script="clerical"):
        assert work.licence == "CC-BY-ND-3.0-TW"
        assert "中華民國教育部" in work.attribution
    for work in starter_works(script="seal"):
        assert "OFL-1.1" in work.licence
        assert "LXGW" in work.attribution
    for script in ("regular", "running", "cursive"):
        assert {"public domain" in w.licence for w in starter_works(script=script)} == {True}
    assert all(w.period.en.startswith("contemporary") for w in starter_works()), "none is a historic work"


def test_filters_and_looking_up() -> None:
    assert [w.id for w in starter_works(script="seal", character="水")] == ["seal-shui"]
    assert starter_works(character="永") == ()
    assert find_work("running-yue").character == "月"
    with pytest.raises(GalleryError, match="seal, clerical, regular, running, cursive"):
        starter_works(script="kai")
    with pytest.raises(GalleryError, match=r"did you mean regular-sh.*regular-shui"):
        find_work("regular-shiu")
    with pytest.raises(GalleryError, match="seal-shui, clerical-shui"):
        find_work("水")
    with pytest.raises(GalleryError, match="no work 'zzz'"):
        find_work("zzz")


def test_each_sampled_work_has_a_copy_at_each_degree_best_first() -> None:
    sampled = dict.fromkeys(sample.work for sample in starter_samples())
    assert len(sampled) == 2
    for work in sampled:
        copies = starter_samples(work=work)
        assert [c.degree for c in copies] == ["excellent", "good", "medium", "bad"]
        alike = [likeness(ink(c), ink(find_work(work))) for c in copies]
        assert alike == sorted(alike, reverse=True)
        assert min(a - b for a, b in pairwise(alike)) > 0.05
        worst = [max(f.severity for f in c.faults) for c in copies]
        assert worst == sorted(worst)


def test_samples_say_that_nobody_wrote_them() -> None:
    for sample in starter_samples():
        assert sample.simulated is True
        assert "模擬" in sample.note.zh
        assert "imulated" in sample.note.en
        assert "ND" not in find_work(sample.work).licence, "a hand that may not be changed is not changed"
        for fault in sample.faults:
            x0, y0, x1, y1 = fault.region
            assert 0 <= x0 < x1 <= 1
            assert 0 <= y0 < y1 <= 1
            assert fault.description.zh != fault.description.en


def test_samples_of_an_unknown_work_are_refused() -> None:
    with pytest.raises(GalleryError, match="no work"):
        starter_samples(work="nothing")


def test_a_package_that_is_not_whole_is_named(tmp_path: Path) -> None:
    with pytest.raises(GalleryError, match=r"works\.json.*expected the starter gallery"):
        starter._entries(tmp_path / "works.json")
    with pytest.raises(GalleryError, match="picture of x is missing"):
        starter._file(tmp_path, {"id": "x", "file": "works/x.png"})


def test_the_package_stays_small() -> None:
    files = [p for p in starter_works()[0].path.parents[1].rglob("*") if p.is_file()]
    assert sum(p.stat().st_size for p in files) < 1_500_000
