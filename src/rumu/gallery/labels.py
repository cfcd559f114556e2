"""The rows of a labels.csv as works: what each picture is, in whatever columns there are.

Known columns: file, character, script, calligrapher_zh and calligrapher (or hand_zh, hand, hand_en), work (or
title, title_zh, title_en), dynasty, period, medium (or material), polarity_guess, source, licence,
attribution. Beside it collection.json may say of all works what no row says:

    {"id": "caoshu", "title": {"zh": "...", "en": "..."}, "source": "...", "licence": "...", "dynasty":
    "Tang", ...}
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from rumu.assessment.scripts import SCRIPTS
from rumu.errors import GalleryError
from rumu.gallery.entries import NO_LICENCE, NOTHING, Entry, Room, slug
from rumu.gallery.masters import LABELS, label_rows
from rumu.gallery.terms import dynasty_key, period_in_words, script_name
from rumu.values import Bilingual

DESCRIPTION = "collection.json"
_TEXTS = ("id", "source", "licence", "attribution", "dynasty", "period", "script")
_BILINGUAL = ("title", "note", "hand", "material")

_MATERIALS = {
    "ink": Bilingual(zh="墨跡", en="ink"),
    "rubbing": Bilingual(zh="拓本", en="rubbing"),
    "rubbing(white on black)": Bilingual(zh="拓本（黑底白字）", en="rubbing (white on black)"),
    "light_on_dark": Bilingual(zh="黑底白字（依圖推測）", en="white on black (guessed from the picture)"),
    "dark_on_light": Bilingual(zh="白底黑字（依圖推測）", en="black on white (guessed from the picture)"),
}


@dataclass(frozen=True, slots=True)
class Row:
    """One picture of a table. number: of its row, from 1. file: as it stands there, relative to the
    folder."""

    number: int
    file: str
    entry: Entry


@dataclass(frozen=True, slots=True)
class Told:
    """What a person or collection.json says of a whole collection; empty where nothing."""

    texts: Mapping[str, str] = field(default_factory=dict)
    bilingual: Mapping[str, Bilingual] = field(default_factory=dict)

    def __post_init__(self) -> None:
        script = self.texts.get("script", "")
        if script and script not in SCRIPTS:
            raise GalleryError(f"expected a script among {', '.join(SCRIPTS)}, got {script!r}")

    def over(self, other: Told) -> Told:
        """This, and what only the other says."""
        return Told({**other.texts, **self.texts}, {**other.bilingual, **self.bilingual})

    def text(self, name: str) -> str:
        return self.texts.get(name, "")

    def both(self, name: str) -> Bilingual:
        return self.bilingual.get(name, NOTHING)

    def entry(self, **more: Any) -> Entry:
        """The facts that hold for every work, and more of one."""
        plain = {name: self.text(name) for name in ("script", "source", "attribution")}
        period = self.text("period") or self.text("dynasty")
        facts: dict[str, Any] = {
            **plain,
            "title": self.both("title"),
            "licence": self.text("licence") or NO_LICENCE,
            "dynasty": dynasty_key(self.text("dynasty") or self.text("period")),
            "period": period_in_words(period),
            "hand": self.both("hand"),
            "material": self.both("material"),
        }
        return Entry(**facts | more)


def read_description(folder: Path) -> Told:
    """What collection.json says; nothing when there is none. Raises GalleryError when it cannot be read."""
    path = folder / DESCRIPTION
    if not path.is_file():
        return Told()
    try:
        held = json.loads(path.read_text(encoding="utf-8-sig"))
    except (OSError, ValueError) as error:
        raise GalleryError(f"{path}: expected JSON, cannot read it ({error})") from error
    known = (*_TEXTS, *_BILINGUAL)
    if not isinstance(held, dict) or not set(held) <= set(known):
        raise GalleryError(f"{path}: expected an object with any of {', '.join(known)}")
    texts = {name: str(held[name]) for name in _TEXTS if held.get(name)}
    return Told(texts, {name: _both(path, name, held[name]) for name in _BILINGUAL if held.get(name)})


def collection_of(folder: Path, told: Told) -> Room:
    """The collection that a folder becomes: named by what was told, else by the folder."""
    name = folder.resolve().name
    return Room(
        id=slug(told.text("id") or name, otherwise="collection"),
        title=told.both("title") if told.both("title") != NOTHING else Bilingual(name, name),
        note=told.both("note"),
        source=told.text("source"),
        licence=told.text("licence") or NO_LICENCE,
    )


def read_rows(folder: Path, told: Told) -> tuple[Row, ...]:
    """The rows of labels.csv, in order. Raises GalleryError naming the file, and the row where one is
    wrong."""
    table = folder / LABELS
    return tuple(_row(table, number, row, told) for number, row in enumerate(label_rows(table), start=1))


def _row(table: Path, number: int, row: Mapping[str, str | None], told: Told) -> Row:
    def said(*names: str) -> str:
        return next((str(row[name]).strip() for name in names if row.get(name)), "")

    if not said("file"):
        raise GalleryError(f"{table} row {number}: expected a file, got nothing")
    script = said("script") or told.text("script")
    if script and script not in SCRIPTS:
        raise GalleryError(
            f"{table} row {number}: expected a script among {', '.join(SCRIPTS)}, got {script!r}"
        )
    general = told.entry()
    hand = _hand(said) or general.hand
    dynasty, period = said("dynasty"), said("period") or said("dynasty")
    material = said("medium", "material", "polarity_guess")
    entry = Entry(
        title=_title(said, character=said("character"), script=script, hand=hand),
        character=said("character")[:16],
        script=script,
        hand=hand,
        dynasty=dynasty_key(dynasty) if dynasty else general.dynasty,
        period=period_in_words(period) if period else general.period,
        material=_MATERIALS.get(material, Bilingual(material, material)) if material else general.material,
        source=said("source") or general.source,
        licence=said("licence", "license") or general.licence,
        attribution=said("attribution") or general.attribution,
        origin=said("file")[:500],
    )
    return Row(number, said("file"), entry)


def _hand(said: Any) -> Bilingual | None:
    chinese, latin = said("calligrapher_zh", "hand_zh"), said("hand_en", "calligrapher", "hand")
    if "_" in latin or latin.islower():  # feng_chengsu, yu_shinan_attr: names of a program
        words = [word for word in latin.split("_") if word]
        doubt = bool(words) and words[-1] == "attr"
        latin = " ".join(word.capitalize() for word in (words[:-1] if doubt else words))
        latin += " (attributed)" if doubt else ""
    return Bilingual(zh=chinese or latin, en=latin or chinese) if chinese or latin else None


def _title(said: Any, *, character: str, script: str, hand: Bilingual) -> Bilingual:
    """The work and the character; the hand and the script where no work is named."""
    zh, en = said("title_zh", "work", "title"), said("title_en", "title", "work")
    if not zh:
        zh, en = hand.zh + (script_name(script).zh if script else ""), hand.en
        en = ", ".join(filter(None, (en, f"{script_name(script).en} script" if script else "")))
    if not character:
        return Bilingual(zh or said("file"), en or said("file"))
    return Bilingual(zh=f"{zh}「{character}」", en=", ".join(filter(None, (character, en))))


def _both(path: Path, name: str, value: Any) -> Bilingual:
    if isinstance(value, str):
        return Bilingual(value, value)
    if isinstance(value, dict) and set(value) == {"zh", "en"}:
        return Bilingual(str(value["zh"]), str(value["en"]))
    raise GalleryError(f'{path}: expected "{name}" as a text or {{"zh": ..., "en": ...}}, got {value!r}')
