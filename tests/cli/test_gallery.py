"""gallery list | show | add | import | export | remove."""

from __future__ import annotations

import re

import pytest
from PIL import Image


def test_the_list_names_every_work(rumu):
    ended = rumu("gallery", "list", "--json")
    works = ended.facts["works"]
    assert (ended.code, len(works), len({work["id"] for work in works})) == (0, 39, 39)
    assert all(work["licence"] and work["hand"]["en"] for work in works)


def test_the_list_for_people(rumu):
    lines = rumu("gallery", "list").out.splitlines()
    assert len(lines) == 39
    assert any("regular-shui" in line and "水" in line for line in lines)
    assert (
        len({re.search(r"  (seal|clerical|regular|running|cursive) ", line).start() for line in lines}) == 1
    )
    assert next(line for line in lines if "stele" in line).endswith("「入木三分」碑（模擬）")


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


def test_the_list_knows_every_filter(rumu):
    assert rumu("gallery", "list", "--search", "楷书 水", "--json").facts["total"] == 1
    assert rumu("gallery", "list", "--hand", "青柳衡山", "--limit", 2, "--json").facts["total"] == 18
    assert rumu("gallery", "list", "--limit", 2).out.splitlines()[-1].startswith("2 of 39 works")
    assert rumu("gallery", "list", "--collection", "none").out == "no work matches\n"
    assert len(rumu("gallery", "list", "--offset", 37, "--limit", 0, "--json").facts["works"]) == 2


def test_a_picture_is_added_shown_and_removed(rumu, desk, tmp_path):
    told = (
        "--character",
        "十",
        "--script",
        "regular",
        "--hand",
        "me",
        "--dynasty",
        "唐",
        "--source",
        "a test",
    )
    ended = rumu("gallery", "add", desk / "a copy.png", *told, "--spacing", 0.1, "--json")
    (work,) = ended.facts["works"]
    assert ended.code == 0 and work["new"]
    facts = rumu("gallery", "show", work["id"], "-o", tmp_path / "out.png", "--json").facts
    assert (facts["character"], facts["dynasty"], facts["licence"]) == ("十", "Tang", "none stated")
    assert facts["hand"] == {"zh": "me", "en": "me"} and facts["title"]["zh"] == "十"
    assert (tmp_path / "out.png").read_bytes() == (desk / "a copy.png").read_bytes()
    shown = rumu("gallery", "show", work["id"]).out
    assert "not measured" in shown and "licence: none stated" in shown and "a test" in shown
    assert "was there already" in rumu("gallery", "add", desk / "a copy.png", *told).out
    assert rumu("gallery", "remove", work["id"], "--json").facts == {"removed": 1}
    rumu("gallery", "show", work["id"]).failed_with("no work")


def test_a_capture_is_added_as_measured(rumu, capture, tmp_path):
    ended = rumu(
        "gallery",
        "add",
        capture,
        "--title-zh",
        "丘",
        "--title-en",
        "A mound",
        "--collection",
        "stones",
        "--json",
    )
    (work,) = ended.facts["works"]
    facts = rumu("gallery", "show", work["id"], "-o", tmp_path / "p.png", "--json").facts
    assert (facts["kind"], facts["height_source"], facts["collection"]) == (
        "capture",
        "photometric",
        "stones",
    )
    assert "measured from photographs" in rumu("gallery", "show", work["id"]).out
    assert rumu("gallery", "remove", "--collection", "stones").out == "stones: removed with 1 work\n"


def test_glyphs_are_added_from_a_font_that_has_them(rumu, data):
    font = data / "fonts" / "LXGWSeal-Regular.ttf"
    ended = rumu("gallery", "add", "--font", font, "--characters", "天水", "--script", "seal", "--json")
    assert len(ended.facts["works"]) == 2
    rumu("gallery", "add", "--font", font, "--characters", "永字").failed_with("has no 永")


@pytest.mark.parametrize("name", ["blank.png", "words.png", "empty.png", "cut.png", "nothing.png"])
def test_what_is_no_work_is_not_added(rumu, desk, name):
    rumu("gallery", "add", desk / name).failed_with(name)
    assert rumu("gallery", "list", "--json").facts["total"] == 39


def test_a_folder_is_imported_and_the_gallery_exported_and_put_in_again(rumu, desk, tmp_path, monkeypatch):
    (desk / "labels.csv").write_text(
        "file,character,script\nmaster.png,十,regular\ncopy.png,十,regular\nblank.png,,\nwords.png,十,regular\n",
        encoding="utf-8",
    )
    told = ("--collection", "tens", "--title-zh", "十字", "--licence", "CC0-1.0")
    facts = rumu("gallery", "import", desk, *told, "--json").facts
    assert (facts["added"], facts["there"], facts["collections"]) == (3, 0, ["tens"])
    assert [one["file"] for one in facts["left_out"]] == ["words.png"]
    again = rumu("gallery", "import", desk, *told)
    assert again.out.startswith("0 works added, 3 were there already: tens\n1 left out, such as words.png: ")
    rows = rumu("gallery", "list", "--limit", 0, "--json").facts
    assert rumu("gallery", "export", "-o", tmp_path / "out", "--json").facts["works"] == 42
    monkeypatch.setenv("RUMU_HOME", str(tmp_path / "other home"))
    assert rumu("gallery", "import", tmp_path / "out", "--json").facts["added"] == 42
    assert rumu("gallery", "list", "--limit", 0, "--json").facts == rows


def test_an_export_never_writes_over_a_strangers_folder(rumu, desk):
    rumu("gallery", "export", "-o", desk).failed_with("holds other things")


def test_one_work_as_a_page(rumu, tmp_path, monkeypatch):
    from importlib import resources

    static = tmp_path / "rumu" / "web" / "static"
    static.mkdir(parents=True)
    monkeypatch.setattr(
        resources,
        "files",
        lambda name, real=resources.files: tmp_path / "rumu" if name == "rumu" else real(name),
    )
    page = tmp_path / "shui.html"
    rumu("gallery", "export", "regular-shui", "--html", "-o", page).failed_with(
        "expected the built front end"
    )
    for name in ("standalone.js", "standalone.css"):
        (static / name).write_text("", encoding="utf-8")
    facts = rumu("gallery", "export", "regular-shui", "--html", "-o", page, "--json").facts
    assert facts["bytes"] == page.stat().st_size and "rumu-work" in page.read_text(encoding="utf-8")


@pytest.mark.parametrize(
    "words",
    [
        ("add",),
        ("add", "x.png", "--font", "y.ttf", "--characters", "天"),
        ("add", "--font", "y.ttf"),
        ("add", "x.png", "--characters", "天"),
        ("add", "x.png", "--spacing", "-1"),
        ("add", "x.png", "--spacing", "nan"),
        ("add", "x.png", "--method", "guess"),
        ("export",),
        ("export", "regular-shui", "-o", "x"),
        ("export", "--html", "-o", "x"),
        ("export", "regular-shui", "--html", "--collection", "starter", "-o", "x"),
        ("remove",),
        ("remove", "seal-ri", "--collection", "starter"),
        ("list", "--limit", "-1"),
    ],
)
def test_wrong_usage(rumu, words):
    assert rumu("gallery", *words).code == 2


def test_a_gallery_that_cannot_be_opened_is_said_in_one_line(rumu, monkeypatch):
    monkeypatch.setenv("RUMU_DATABASE", "mysql://nobody@nowhere/x")
    rumu("gallery", "list").failed_with("expected a database")
    monkeypatch.setenv("RUMU_DATABASE", "/proc/rumu.sqlite")
    rumu("gallery", "list").failed_with("/proc/rumu.sqlite")
