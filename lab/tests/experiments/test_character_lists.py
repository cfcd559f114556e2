"""The locked list opens with its seed alone, and every opening stays in sight."""

from __future__ import annotations

import hashlib
import json
from dataclasses import replace

import pytest

from rumu.errors import CalibrationError
from rumu_lab.experiments import character_lists
from rumu_lab.experiments.findings import Findings
from rumu_lab.experiments.protocol import ExperimentProtocol, declared

SEED = "a seed for tests"


@pytest.fixture
def protocol() -> ExperimentProtocol:
    """The declared one, locked with a seed that the tests know."""
    plain = json.loads(json.dumps(declared(quick=True).plain))
    plain["characters"]["locked"]["seed_sha256"] = hashlib.sha256(SEED.encode()).hexdigest()
    return replace(declared(quick=True), plain=plain)


@pytest.fixture
def masters(tmp_path):
    """A list of masters in regular script: every declared character, and 300 others."""
    lists = declared().plain["characters"]
    names = lists["development"] + lists["validation"] + "".join(chr(0x9000 + k) for k in range(300))
    folder = tmp_path / "data" / "masters" / "regular"
    folder.mkdir(parents=True)
    rows = [f"{k}.png,{c}" for k, c in enumerate(names)] + [f"again.png,{names[0]}"]
    (folder / "labels.csv").write_text("file,character\n" + "\n".join(rows) + "\n", encoding="utf-8")
    return tmp_path / "data"


def test_the_declared_lock_is_a_hash_and_not_a_seed():
    with pytest.raises(CalibrationError, match="SHA-256"):
        character_lists.locked_characters(SEED, {}, declared())


def test_the_seed_draws_what_no_other_list_holds(protocol, masters):
    pictures = character_lists.pictures_of(masters)
    drawn = character_lists.locked_characters(SEED, pictures, protocol)
    lists = protocol.plain["characters"]
    assert len(drawn) == len(set(drawn)) == lists["locked"]["count"]
    assert not set(drawn) & set(lists["development"] + lists["validation"])
    assert drawn == character_lists.locked_characters(SEED, pictures, protocol)
    assert pictures[lists["development"][0]].name == "0.png"  # the first row of a character


def test_every_opening_is_logged_before_it_is_measured(protocol, masters, quick, monkeypatch, tmp_path):
    log = tmp_path / "log" / "locked.jsonl"
    monkeypatch.setattr(type(quick), "protocol", property(lambda self: protocol))
    seen = []

    def findings_on(subjects, settings, *, name, where):
        seen.append((len(subjects), {s.fold for s in subjects}, len(character_lists.read_log(log))))
        return Findings(name, {"verdict": {"rank": 1}, "worst_fold": {}})

    monkeypatch.setattr(character_lists, "findings_on", findings_on)
    first = character_lists.run(quick, name="locked", seed=SEED, log=log)
    second = character_lists.run(quick, name="locked", seed=SEED, log=log)
    assert seen == [
        (100, {f"group {k}" for k in range(1, 6)}, 1),
        (100, {f"group {k}" for k in range(1, 6)}, 3),
    ]
    assert [line["event"] for line in character_lists.read_log(log)] == ["opened", "result"] * 2
    assert len(first.facts["openings"]) == 1 and len(second.facts["openings"]) == 2
    assert "Only the first counts" in second.sentences[-1].en
    assert "Only the first counts" not in first.sentences[-1].en


def test_a_wrong_seed_opens_nothing(protocol, masters, quick, tmp_path):
    with pytest.raises(CalibrationError, match="another"):
        character_lists.run(quick, name="locked", seed="guess", log=tmp_path / "log.jsonl")
    assert not (tmp_path / "log.jsonl").exists()


@pytest.mark.parametrize("harm", ["drop", "change"])
def test_a_log_that_was_touched_is_seen(tmp_path, harm):
    log = tmp_path / "log.jsonl"
    for k in range(3):
        character_lists.write_line(log, {"event": "opened", "k": k})
    lines = log.read_text().splitlines()
    lines = [lines[0], lines[2]] if harm == "drop" else [lines[0].replace('"k": 0', '"k": 9'), *lines[1:]]
    log.write_text("\n".join(lines) + "\n")
    with pytest.raises(CalibrationError, match="line 2"):
        character_lists.write_line(log, {"event": "opened"})


def test_other_lists_need_no_seed(masters, quick, monkeypatch):
    monkeypatch.setattr(
        character_lists,
        "findings_on",
        lambda subjects, settings, *, name, where: Findings(name, {"n": len(subjects)}),
    )
    assert character_lists.run(quick, name="validation").facts == {"n": 100}
    assert character_lists.run(quick, name="development").facts == {"n": 200}
