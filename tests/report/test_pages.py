"""Pages: everything in one file, nothing left out, nothing let through unescaped."""

from __future__ import annotations

import re
from dataclasses import replace
from html.parser import HTMLParser

import numpy as np
import pytest

from rumu.gallery.starter import starter_works
from rumu.report.pages import IndexSample, assessment_page, demo_index, level_zones, surface_page
from rumu.report.remark_drawing import number_position
from rumu.report.wording import PARTS, SIMULATED, deduction_note
from rumu.values import Bilingual, Remark

CUTS = {"excellent": 69.0, "good": 55.0, "medium": 40.0}


class Outline(HTMLParser):
    """What a page holds: its tags balanced, its addresses, its pictures, its visible text."""

    VOID = frozenset({"meta", "link", "img", "input", "br"})

    def __init__(self, html: str) -> None:
        super().__init__()
        self.open: list[str] = []
        self.addresses: list[str] = []
        self.pictures: list[dict[str, str | None]] = []
        self.words: list[str] = []
        self.feed(html)
        assert not self.open, f"unclosed: {self.open}"

    def handle_starttag(self, tag, attrs):
        held = dict(attrs)
        self.addresses += [held[name] for name in ("src", "href") if held.get(name)]
        if tag == "img":
            self.pictures.append(held)
        if tag not in self.VOID:
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag, tag

    def handle_data(self, data):
        if "style" not in self.open:
            self.words.append(data)

    @property
    def text(self) -> str:
        return " ".join(" ".join(self.words).split())


def page(assessment, copy, master, **options) -> str:
    options = {"title": "十", "copy_name": "copy.png", "master_name": "master.png", "levels": CUTS} | options
    return assessment_page(assessment, copy=copy, master=master, **options)


@pytest.fixture(scope="module")
def html(assessment, copy_surface, master_surface):
    return page(assessment, copy_surface, master_surface)


def needs_no_network(html: str) -> bool:
    outline = Outline(html)
    return all(a.startswith("data:") or not re.match(r"(\w+:|//)", a) for a in outline.addresses) and not (
        re.search(r"url\(|@import|<script", html)
    )


def test_the_page_is_whole_and_alone(html):
    assert needs_no_network(html)
    assert html.startswith("<!doctype html>") and html.rstrip().endswith("</html>")


def test_every_picture_is_there_and_described(html):
    pictures = Outline(html).pictures
    assert len(pictures) == 9  # overlay, and twice: with remarks, as written, shaded, mesh
    assert all(p["alt"] and p["src"].startswith("data:image/") for p in pictures)


def test_the_mark_and_what_it_rests_on(html):
    text = Outline(html).text
    for words in (
        "57 / 100",
        "44–69",  # 44.5 rounds to even
        "良 good",
        "not measured relief",
        "99.987%",
        "is not the mark",
        "0.913",
        "anticlockwise",
        "2%",
        "What it does not mean",
    ):
        assert words in text, words


def test_parts_come_with_their_meaning(html):
    text = Outline(html).text
    for name, meaning in PARTS.values():
        assert name.en in text and name.zh in text and meaning.en in text and meaning.zh in text


def test_a_mark_on_a_teacher_s_terms_says_so(assessment, copy_surface, master_surface, html):
    own = replace(
        assessment,
        weights={"brushwork": 50.0, "structure": 25.5, "ink": 0.0},
        calibration="30 marks <by> a teacher",
        interval_note="Widened 1.5 times.",
        interval_note_zh="放寬為 1.5 倍。",
    )
    text = Outline(page(own, copy_surface, master_surface)).text
    for words in ("Brushwork 50, Structure 25.5, Ink 0", "30 marks <by> a teacher", "Widened 1.5 times."):
        assert words in text and words not in Outline(html).text
    assert "放寬為 1.5 倍。" in text and "自定權重" in text


def test_what_was_taken_off_for_the_whole_is_told_from_a_point_on(assessment, copy_surface, master_surface):
    charged = replace(assessment, deductions={"size": 36.2, "offset": 12.0, "lean": 0.4})
    text = Outline(page(charged, copy_surface, master_surface)).text
    assert "36 points for its size, 12 points for its place" in text and "leaning" not in text
    assert "大小 36 分、偏位 12 分" in text and "裁到格子" in text
    for less in ({}, {"size": 0.9}):
        assert deduction_note(replace(assessment, deductions=less)) is None


def test_remarks_worst_first_and_drawn_where_they_are(html):
    text = Outline(html).text
    assert text.index("The lying stroke is missing.") < text.index("Leans 3° to the left.")
    assert "left:10.00%;top:40.00%;width:80.00%;height:20.00%" in html
    assert html.count('class="box drawn d1"') == 1  # the lean has no place of its own


def test_the_strokes_that_a_remark_speaks_of_are_drawn_in_both(assessment, copy_surface, master_surface):
    turned = Remark(
        "stroke_angle", 6, "degrees", 9, (0.1, 0.4, 0.9, 0.6), "橫", "It leans.",
        (((0.1, 0.5), (0.5, 0.48), (0.9, 0.46)),), (((0.1, 0.5), (0.9, 0.5)),),
    )  # fmt: skip
    missing = replace(turned, kind="missing", severity=8, master_outline=())  # as in marks of older versions
    html = page(replace(assessment, remarks=(turned, missing)), copy_surface, master_surface)
    assert html.count('points="100,500 500,480 900,460"') == 4  # each with a halo, to be seen on ink
    assert html.count('points="100,500 900,500"') == 2
    copy, master = html.split('<div class="sheet">')[1:]
    assert 'class="drawn d2 absent"' in copy and 'class="drawn d1"' in copy
    assert 'class="drawn d1"' in master and "d2" not in master.split("</figure>")[0]
    assert 'class="box' not in html
    assert 'style="left:50.00%;top:48.00%">1<' in copy
    assert 'style="left:50.00%;top:48.00%">2<' not in copy, "two numbers on one place cannot be read"


def test_a_remark_that_is_pointed_at_stands_out_in_both(html):
    assert ".remarks:has(.r1:is(:hover, :focus-within, :target)" in html
    assert html.count('href="#remark-1"') == 2, "its number in the picture leads to it, and back"
    assert 'id="remark-1"' in html


@pytest.mark.parametrize("places", [1, 3, 9])
def test_numbers_are_whole_and_apart(places):
    """On a picture of 150 pixels, where a number is 16 wide."""
    for line in ([[500, 500], [520, 510]], [[0, 3], [2, 0]], [[100, 500], [900, 480]], [[990, 990]]):
        taken = []
        for _ in range(places):
            taken.append(number_position(np.array(line, float), taken))
        for k, (x, y) in enumerate(taken):
            assert min(x, y, 1000 - x, 1000 - y) >= 55
            assert all(np.hypot(x - a, y - b) > 107 for a, b in taken[:k])
    (first,) = {number_position(np.array([[100.0, 500.0], [900.0, 480.0]]), [])}
    assert first == (500, 490)


def test_what_is_good_comes_first(assessment, copy_surface, master_surface, html):
    praised = replace(assessment, praise=Bilingual("橫寫得好。", "The horizontal is well written."))
    shown = page(praised, copy_surface, master_surface)
    assert shown.index("The horizontal is well written.") < shown.index("What to change first")
    assert "What is good" not in html


def test_a_mark_without_remarks(assessment, copy_surface, master_surface):
    assert "What to change first" not in page(replace(assessment, remarks=()), copy_surface, master_surface)


def test_names_are_escaped(assessment, copy_surface, master_surface):
    remark = Remark("lean", 1, "deg", 1, None, "<b>斜</b>", "<script>alert(1)</script>")
    html = page(
        replace(assessment, remarks=(remark,)),
        copy_surface,
        master_surface,
        title="<i>十</i>",
        copy_name='"><img src=x>',
    )
    assert needs_no_network(html) and "<i>十" not in html and "src=x>" not in html.replace("src=x&gt;", "")


def test_a_simulated_copy_says_so(assessment, copy_surface, master_surface):
    text = Outline(page(assessment, copy_surface, master_surface, note=SIMULATED)).text
    assert SIMULATED.zh in text and SIMULATED.en in text


def test_both_languages_stand_apart(html):
    assert html.count('class="zh"') > 30
    assert abs(html.count('class="zh"') - html.count('class="en"')) <= 1


def test_a_refusal_says_why_and_what_to_do(refusal, master_surface):
    outline = Outline(page(refusal, None, master_surface))
    assert "the page is blank: no ink was found" in outline.text
    assert "Light the sheet evenly" in outline.text and "/ 100" not in outline.text
    assert len(outline.pictures) == 1


def test_a_surface_page(master_surface):
    outline = Outline(surface_page(master_surface, title="十", notes=[Bilingual("注", "a note")]))
    assert len(outline.pictures) == 9  # mesh, four lamps, albedo, normals, confidence, height
    for words in ("not measured relief", "96 × 96", "1 px", "ink_share", "a note", "tilt 270°"):
        assert words in outline.text, words


def test_a_surface_in_millimetres_says_so(master_surface):
    metric = replace(master_surface, spacing=0.05, unit="mm", source="photometric", quality={})
    text = Outline(surface_page(metric, title="十")).text
    assert "0.05 mm" in text and "Height measured from photographs" in text
    assert "How far to trust it" not in text


def test_the_demo_s_first_page(assessment, refusal, copy_surface, master_surface):
    samples = [
        IndexSample(
            Bilingual("天", "tian"), "good", (Bilingual("推", "pushed"),), assessment, "a.html", copy_surface
        ),
        IndexSample(Bilingual("人", "ren"), "bad", (), refusal, "b.html", None),
    ]
    works = [(work, master_surface) for work in starter_works()[:3]]
    html = demo_index(samples, works, title="rumu")
    outline = Outline(html)
    assert needs_no_network(html)
    assert {"a.html", "b.html"} <= set(outline.addresses)
    assert len(outline.pictures) == 1 + 2 * 3
    assert "no ink was found" in outline.text and "not written by a person" in outline.text


def test_levels_cut_the_scale():
    zones = level_zones(CUTS)
    assert [(z["level"], z["low"], z["high"]) for z in zones] == [
        ("bad", 0.0, 40.0),
        ("medium", 40.0, 55.0),
        ("good", 55.0, 69.0),
        ("excellent", 69.0, 100.0),
    ]
    assert level_zones({}) == []
