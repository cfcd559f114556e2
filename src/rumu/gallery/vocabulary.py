"""The vocabulary of the catalogue in both languages, and text as searches compare it.

variants.txt holds pairs of characters, the traditional one before the simplified one. It was made from
TSCharacters.txt of OpenCC (Apache-2.0), with the first simplified form of each character.
"""

from __future__ import annotations

import functools
import re
import unicodedata
from importlib import resources

from rumu.values import SCRIPTS, Bilingual

UNKNOWN = Bilingual(zh="未詳", en="not known")

SCRIPT_NAMES: dict[str, Bilingual] = {name: Bilingual(zh=zh, en=name) for name, zh in SCRIPTS.items()}

DYNASTIES = {
    "Shang": "商",
    "Zhou": "周",
    "Qin": "秦",
    "Han": "漢",
    "Wei": "魏",
    "Three Kingdoms": "三國",
    "Jin": "晉",
    "Northern Wei": "北魏",
    "Southern and Northern": "南北朝",
    "Sui": "隋",
    "Tang": "唐",
    "Five Dynasties": "五代",
    "Song": "宋",
    "Liao": "遼",
    "Yuan": "元",
    "Ming": "明",
    "Qing": "清",
    "Republic": "民國",
    "contemporary": "當代",
}

HEIGHT_SOURCES = {
    "photometric": Bilingual(
        zh="高度由多盞燈下的照片以光度立體法量得；只量到紙面與筆跡的實際起伏，不是墨色深淺。",
        en="The height was measured from photographs under several lamps (photometric stereo): "
        "the relief that is really there, not how dark the ink is.",
    ),
    "inflation": Bilingual(
        zh="高度由這張圖的墨跡輪廓推算（膨脹法），並非量得；紙上的墨沒有可量的起伏。",
        en="The height was computed from the outline of the ink in this picture (inflation). It was not "
        "measured: ink on flat paper has no relief to measure.",
    ),
    "density": Bilingual(
        zh="高度由這張圖的墨色濃淡推算，並非量得；紙上的墨沒有可量的起伏。",
        en="The height was computed from how dark the ink in this picture is. It was not "
        "measured: ink on flat paper has no relief to measure.",
    ),
}

_WORDS = {"attributed": "傳", "copy": "摹本", "or": "或", "early": "早期", "late": "晚期"}
_NAMED = re.compile("|".join(sorted(map(re.escape, DYNASTIES), key=len, reverse=True)), re.IGNORECASE)
_BY_LOWER = {name.lower(): name for name in DYNASTIES}
_BY_CHINESE = {chinese: name for name, chinese in DYNASTIES.items()}


def dynasty_key(text: str) -> str:
    """The key that works are browsed by.

    It is 'Tang' for 'Tang (attributed)' or 唐, and 'Tang/Song' for 'Tang/Song copy'. A text that names no
    dynasty of the table stays as it is.
    """
    if text.strip() in _BY_CHINESE:
        return _BY_CHINESE[text.strip()]
    names = dict.fromkeys(_BY_LOWER[name.lower()] for name in _NAMED.findall(text))
    return "/".join(names) if names else text.strip()


def dynasty_name(key: str) -> Bilingual:
    """The name of a dynasty, or of several, by the key."""
    if not key:
        return UNKNOWN
    return Bilingual(zh="／".join(DYNASTIES.get(name, name) for name in key.split("/")), en=key)


def period_name(text: str) -> Bilingual:
    """A period from a table in both languages, as far as its words are in the vocabulary."""
    if text.strip() in _BY_CHINESE:
        return Bilingual(zh=text.strip(), en=_BY_CHINESE[text.strip()])
    chinese = _NAMED.sub(lambda match: DYNASTIES[_BY_LOWER[match[0].lower()]], text)
    for english, word in _WORDS.items():
        chinese = re.sub(rf"\b{english}\b", word, chinese, flags=re.IGNORECASE)
    tidy = re.sub(r"(?<=[^\x00-\x7f]) (?=[^\x00-\x7f])", "", chinese)
    return Bilingual(zh=tidy.replace(" (", "（").replace(")", "）").replace("/", "／"), en=text)


def script_key(text: str) -> str:
    """The key of a script: 'regular' for 'Regular script', 楷書, 楷书 or 楷; another text stays as it is."""
    words = fold(text.strip()).removesuffix("script").strip()
    names = {form: name for name, zh in SCRIPTS.items() for form in (name, fold(zh), fold(zh)[:1])}
    return names.get(words, text.strip())


def script_name(script: str) -> Bilingual:
    """The name of a script; an unknown one stays as it is."""
    return SCRIPT_NAMES.get(script, UNKNOWN if not script else Bilingual(zh=script, en=script))


# --- text as searches compare it -------------------------------------------------------------------


def fold(text: str) -> str:
    """Text in the form that searches compare: NFKC, lower case, simplified characters."""
    return unicodedata.normalize("NFKC", text).lower().translate(_simplified_forms())


def variants(character: str) -> tuple[str, ...]:
    """A character in all forms that searches treat as equal, itself first."""
    simplified = character.translate(_simplified_forms())
    others = (chr(code) for code, form in _simplified_forms().items() if form == simplified)
    return tuple(dict.fromkeys((character, simplified, *others)))


@functools.cache
def _simplified_forms() -> dict[int, str]:
    """The simplified form of each traditional character, as str.translate takes it."""
    text = resources.files("rumu.gallery").joinpath("variants.txt").read_text(encoding="utf-8")
    packed = text.replace("\n", "")
    return {ord(traditional): form for traditional, form in zip(packed[::2], packed[1::2], strict=True)}
