"""Rows of a labels.csv as metadata of works.

Known columns: file, character, script, calligrapher_zh and calligrapher (or hand_zh, hand, hand_en), work (or
title, title_zh, title_en), dynasty, period, medium (or material), polarity_guess, source, licence,
attribution, text (of a page, or the name of its text file). A collection.json beside it may give what holds
for all works, where their rows say nothing:

    {"id": "caoshu", "title": {"zh": "...", "en": "..."}, "source": "...", "licence": "...", "dynasty":
    "Tang", ...}
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from rumu.csv_tables import Table, TableRow
from rumu.errors import GalleryError
from rumu.gallery.masters import LABELS, read_label_table
from rumu.gallery.metadata import EMPTY, NO_LICENCE, CollectionMetadata, WorkMetadata, slug
from rumu.gallery.vocabulary import dynasty_key, period_name, script_key, script_name
from rumu.inputs import read_json
from rumu.values import SCRIPTS, Bilingual

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
class LabelledPicture:
    """A picture of a labels.csv. number: of its row, from 1. file: relative to the folder.

    text: of a page, what is written on it, or the name of a text file; '' where the row does not say.
    """

    number: int
    file: str
    metadata: WorkMetadata
    text: str = ""


@dataclass(frozen=True, slots=True)
class SharedMetadata:
    """Metadata of all works of an import, from a person or collection.json; empty where unknown."""

    texts: Mapping[str, str] = field(default_factory=dict)
    bilingual: Mapping[str, Bilingual] = field(default_factory=dict)

    def __post_init__(self) -> None:
        script = self.text("script")
        if script and script not in SCRIPTS:
            raise GalleryError(f"expected a script among {', '.join(SCRIPTS)}, got {script!r}")

    def with_defaults(self, other: SharedMetadata) -> SharedMetadata:
        """These metadata, and from the other those that are unknown here."""
        return SharedMetadata({**other.texts, **self.texts}, {**other.bilingual, **self.bilingual})

    def text(self, name: str) -> str:
        """A text in one language."""
        return self.texts.get(name, "")

    def both(self, name: str) -> Bilingual:
        """A text in both languages."""
        return self.bilingual.get(name, EMPTY)

    def work_metadata(self, **more: Any) -> WorkMetadata:
        """Metadata of a work: the shared ones, and more of its own."""
        facts: dict[str, Any] = {name: self.text(name) for name in ("script", "source", "attribution")}
        facts |= {name: self.both(name) for name in ("title", "hand", "material")}
        facts |= {
            "licence": self.text("licence") or NO_LICENCE,
            "dynasty": dynasty_key(self.text("dynasty") or self.text("period")),
            "period": period_name(self.text("period") or self.text("dynasty")),
        }
        return WorkMetadata(**facts | more)


def read_description(folder: Path) -> SharedMetadata:
    """The metadata of collection.json, none when there is none. Raises GalleryError if it cannot be read."""
    path = folder / DESCRIPTION
    if not path.is_file():
        return SharedMetadata()
    values = read_json(path, error_type=GalleryError)
    known = (*_TEXTS, *_BILINGUAL)
    if not isinstance(values, dict) or not set(values) <= set(known):
        raise GalleryError(
            f"{path}: expected an object with any of {', '.join(known)}",
            zh=f"{DESCRIPTION} 只能有這些項目：{'、'.join(known)}。",
        )
    texts = {name: str(values[name]) for name in _TEXTS if values.get(name)}
    bilingual = {name: _both(path, name, values[name]) for name in _BILINGUAL if values.get(name)}
    return SharedMetadata(texts, bilingual)


def _both(path: Path, name: str, value: Any) -> Bilingual:
    if isinstance(value, str):
        return Bilingual(value, value)
    if isinstance(value, dict) and set(value) == {"zh", "en"}:
        return Bilingual(str(value["zh"]), str(value["en"]))
    raise GalleryError(f'{path}: expected "{name}" as a text or {{"zh": ..., "en": ...}}, got {value!r}')


def collection_of(folder: Path, shared: SharedMetadata) -> CollectionMetadata:
    """The collection that a folder becomes. Without an id or title, the folder's name serves."""
    name, title = folder.resolve().name, shared.both("title")
    return CollectionMetadata(
        id=slug(shared.text("id") or name, default="collection"),
        title=title if title != EMPTY else Bilingual(name, name),
        note=shared.both("note"),
        source=shared.text("source"),
        licence=shared.text("licence") or NO_LICENCE,
    )


def read_labels(folder: Path, shared: SharedMetadata) -> tuple[LabelledPicture, ...]:
    """The rows of labels.csv in order. Raises GalleryError that names the file, and the row with a fault."""
    table = read_label_table(folder / LABELS)
    rows = enumerate(table.rows(), start=1)
    return tuple(_labelled_picture(table, number, row, shared) for number, row in rows)


def _labelled_picture(table: Table, number: int, row: TableRow, shared: SharedMetadata) -> LabelledPicture:
    column = row.get
    where, where_zh = f"{table.path} row {number}", f"{LABELS} 第 {number} 列"
    if not column("file"):
        raise GalleryError(f"{where}: expected a file, got nothing", zh=f"{where_zh}：沒有檔名。")
    script = script_key(column("script")) or shared.text("script")
    if script and script not in SCRIPTS:
        raise GalleryError(
            f"{where}: expected a script among {', '.join(SCRIPTS)}, got {script!r}",
            zh=f"{where_zh}：書體應是{'、'.join(SCRIPTS.values())}之一，卻是「{script}」。",
        )
    default = shared.work_metadata()
    hand = _hand(column) or default.hand
    dynasty, period = column("dynasty"), column("period") or column("dynasty")
    material = column("medium", "material", "polarity_guess")
    metadata = WorkMetadata(
        title=_title(column, script=script, hand=hand),
        character=column("character")[:16],
        script=script,
        hand=hand,
        dynasty=dynasty_key(dynasty) if dynasty else default.dynasty,
        period=period_name(period) if period else default.period,
        material=_MATERIALS.get(material, Bilingual(material, material)) if material else default.material,
        source=column("source") or default.source,
        licence=column("licence", "license") or default.licence,
        attribution=column("attribution") or default.attribution,
        origin=column("file")[:500],
    )
    return LabelledPicture(number, column("file"), metadata, column("text"))


def _hand(column: Callable[..., str]) -> Bilingual | None:
    chinese, latin = column("calligrapher_zh", "hand_zh"), column("hand_en", "calligrapher", "hand")
    if "_" in latin or latin.islower():  # feng_chengsu, yu_shinan_attr: identifiers
        words = [word for word in latin.split("_") if word]
        attributed = bool(words) and words[-1] == "attr"
        latin = " ".join(word.capitalize() for word in (words[:-1] if attributed else words))
        latin += " (attributed)" if attributed else ""
    return Bilingual(zh=chinese or latin, en=latin or chinese) if chinese or latin else None


def _title(column: Callable[..., str], *, script: str, hand: Bilingual) -> Bilingual:
    """The work's title and the character; without a title, the hand and the script."""
    zh, en = column("title_zh", "work", "title"), column("title_en", "title", "work")
    if not zh:
        zh, en = hand.zh + (script_name(script).zh if script else ""), hand.en
        en = ", ".join(filter(None, (en, f"{script_name(script).en} script" if script else "")))
    character = column("character")
    if not character:
        return Bilingual(zh or column("file"), en or column("file"))
    return Bilingual(zh=f"{zh}「{character}」", en=", ".join(filter(None, (character, en))))
