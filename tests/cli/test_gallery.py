"""gallery list | show."""

from __future__ import annotations

import pytest
from PIL import Image


def test_the_list_names_every_work(rumu):
    ended = rumu("gallery", "list", "--json")
    works = ended.facts["works"]
    assert (ended.code, len(works), len({work["id"] for work in works})) == (0, 30, 30)
    assert all(work["licence"] and work["hand"]["en"] for work in works)


def test_the_list_for_people(rumu):
    lines = rumu("gallery", "list").out.splitlines()
    assert len(lines) == 30
    assert any("regular-shui" in line and "水" in line for line in lines)


def test_the_list_can_be_narrowed(rumu):
    works = rumu("gallery", "list", "--script", "regular", "--character", "水", "--json").facts["works"]
    assert [work["id"] for work in works] == ["regular-shui"]
    assert rumu("gallery", "list", "--character", "龍").out == "no work matches\n"


def test_an_unknown_script_is_refused(rumu):
    rumu("gallery", "list", "--script", "roman").failed_with("roman", "expected a script")


def test_a_work_is_shown_with_its_licence(rumu):
    ended = rumu("gallery", "show", "regular-shui")
    assert ended.code == 0 and "licence:" in ended.out and "hand:" in ended.out


def test_a_picture_can_be_had(rumu, tmp_path):
    ended = rumu("gallery", "show", "regular-shui", "-o", tmp_path / "shui.png", "--json")
    assert ended.facts["id"] == "regular-shui"
    assert Image.open(tmp_path / "shui.png").size == (512, 512)


def test_an_unknown_work_is_refused_with_a_hint(rumu):
    rumu("gallery", "show", "regular-shiu").failed_with("regular-shiu", "regular-shui")
    ended = rumu("gallery", "show", "nothing-like-it", "--json")
    assert (ended.code, list(ended.facts)) == (1, ["error"])


@pytest.mark.parametrize("place", ["/proc/shui.png", "{desk}/file.txt/shui.png"])
def test_a_place_that_cannot_be_written(rumu, desk, place):
    place = place.format(desk=desk)
    rumu("gallery", "show", "regular-shui", "-o", place).failed_with(place, "cannot be written")


def test_only_png_can_be_had(rumu, tmp_path):
    assert rumu("gallery", "show", "regular-shui", "-o", tmp_path / "shui.jpg").code == 2
