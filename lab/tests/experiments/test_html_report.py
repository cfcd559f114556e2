"""The page: made of what is there, whole in itself, and open about what is missing."""

from __future__ import annotations

import re

import pytest
from PIL import Image

from rumu.errors import OutputError
from rumu_lab.experiments import html_report, human_marks, nuisance, severities
from rumu_lab.experiments.findings import Findings
from rumu_lab.experiments.results import origin_of, write_result
from rumu_lab.experiments.runner import EXPERIMENTS


@pytest.fixture
def results(quick, e3c_data, graded, monkeypatch):
    """Human marks, severities, nuisances and runtime, of copies that nobody measured."""

    def measure(work, tasks, settings):
        return [graded(t, 0.9 - 0.1 * int(t.key[-1]) if t.key[-1].isdigit() else 0.5) for t in tasks]

    for module in (human_marks, severities, nuisance):
        monkeypatch.setattr(module, "measure_each", measure)
        write_result(module.run(quick), origin_of(quick, seconds=1), quick)
    rows = [
        {"method": name, "median": t, "least": t, "most": t, "ratio": 1.0} for name, t in (("rumu", 9.0),)
    ]
    write_result(
        Findings("runtime", {"methods": rows, "repeats": 2, "side": 512}), origin_of(quick, seconds=1), quick
    )
    write_result(
        Findings("gaming", {"above": []}, words="none <above> 40"), origin_of(quick, seconds=1), quick
    )
    return quick


def test_the_report(results):
    """It needs nothing, hides nothing, sets the paper's numbers apart, and has something on its figures."""
    made = html_report.write_report(results.out)
    text = made.page.read_text("utf-8")
    assert not re.findall(r"""(?:src|href)=["'](?!data:|#)""", text)
    assert "<script" not in text and "@import" not in text
    assert text.count(results.protocol.sha256) > len(made.figures) / 2  # on the page and under every table
    assert set(made.missing) == {"e3c", "nested", "levels", "ablation", "remarks", "identity", "pictures"}
    assert all(f"<code>{name}</code>" in text for name in made.missing)
    assert "no result" in text and "小樣快跑" in text
    assert "none &lt;above&gt; 40" in text
    for sentence in human_marks.run(results).sentences:
        assert sentence.zh in text

    tables = "".join(re.findall(r"<table.*?</table>", text, flags=re.DOTALL))
    assert "1.78" in text and "1.78" not in tables
    assert "Not comparable" in text and "不可比" in text

    assert {"figures/figure-7-human.png", "figures/figure-7-human.svg"} < set(made.figures)
    for name in made.figures:
        file = results.out / name
        if file.suffix == ".png":
            with Image.open(file) as picture:
                assert min(picture.size) > 100 and len(picture.convert("RGB").getcolors(1 << 24)) > 10
        else:
            assert file.read_text("utf-8").rstrip().endswith("</svg>")


def test_nothing_yet(tmp_path):
    with pytest.raises(OutputError, match="experiments run all"):
        html_report.write_report(tmp_path)


def test_results_of_several_versions_are_flagged():
    from rumu_lab.experiments.protocol import declared

    whole = {"quick": False, "protocol_sha256": declared().sha256, "code_sha256": "a"}
    assert html_report.warnings_of({"a": whole, "b": whole}) == ()
    (mixed,) = html_report.warnings_of({"a": whole, "b": {**whole, "code_sha256": "b"}})
    assert "same version" in mixed.en
    (other,) = html_report.warnings_of({"a": {**whole, "protocol_sha256": "x"}})
    assert "protocol" in other.en


def test_every_experiment_has_its_place_and_both_languages():
    assert len({e.name for e in EXPERIMENTS}) == len(EXPERIMENTS)
    for experiment in EXPERIMENTS:
        assert re.search(r"[\u4e00-\u9fff]", experiment.title.zh) and experiment.title.en.isascii()
