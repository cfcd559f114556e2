"""The vocabulary of the catalogue in both languages, and text as searches compare it.

variants.txt holds pairs of characters, the traditional one before the simplified one. It was made from
TSCharacters.txt of OpenCC (Apache-2.0), with the first simplified form of each character.
character_forms.txt holds pairs of other ways to write one character, the usual one first; two thirds are from
OpenCC's HKVariants, TWVariants and JPVariants.
"""

from __future__ import annotations

import functools
import re
import unicodedata
from importlib import resources
from pathlib import Path

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

_SCRIPT_WORDS = {
    "seal": "篆書 篆 篆字 篆體 大篆 小篆 zhuanshu zhuan seal sealscript smallseal",
    "clerical": "隸書 隸 隸體 分書 八分 八分書 漢隸 lishu clerical clericalscript official officialscript",
    "regular": "楷書 楷 楷體 正書 真書 正楷 大楷 小楷 kaishu regular regularscript standardscript kaiscript",
    "running": "行書 行 行體 行楷 行草 xingshu running runningscript semicursive semicursivescript",
    "cursive": "草書 草 草體 今草 狂草 章草 大草 小草 caoshu cursive cursivescript grassscript wildcursive",
}
_DYNASTY_WORDS = {
    "Han": "西漢 東漢 前漢 後漢 兩漢", "Wei": "曹魏", "Jin": "西晉 東晉 兩晉", "Three Kingdoms": "東吳 蜀漢",
    "Northern Wei": "元魏", "Southern and Northern": "南朝 北朝 六朝", "Song": "北宋 南宋 兩宋",
    "Tang": "初唐 盛唐 中唐 晚唐", "Republic": "近代 republicofchina", "contemporary": "現代 當今 modern",
}  # fmt: skip
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


@functools.cache
def words_of_scripts() -> dict[str, str]:
    """The script that each name means, folded and without spaces."""
    return {fold(word): script for script, words in _SCRIPT_WORDS.items() for word in words.split()}


@functools.cache
def words_of_dynasties() -> dict[str, str]:
    """The key of the dynasty that each name means, folded and without spaces."""
    found = {}
    for key, chinese in DYNASTIES.items():
        latin = key.replace(" ", "")
        names = (chinese, *(chinese + end for end in "代朝"), latin, f"{latin}dynasty", f"{latin}period")
        for name in (*names, *_DYNASTY_WORDS.get(key, "").split()):
            found[fold(name)] = key
    return found


# --- text as searches compare it -------------------------------------------------------------------


def fold(text: str) -> str:
    """Text in the form that searches compare: NFKC, lower case, simplified characters, usual forms."""
    return (
        unicodedata.normalize("NFKC", text).lower().translate(_usual_forms()).translate(_simplified_forms())
    )


def variants(character: str) -> tuple[str, ...]:
    """A character in all forms that searches treat as equal, itself first.

    They are its traditional and simplified form and other ways to write it. Another traditional character
    that only shares the simplified form is none: 发 is 發 or 髮, but 發 is not 髮.
    """
    simplified = character.translate(_simplified_forms())
    others = [chr(code) for code, form in _simplified_forms().items() if form == character]
    same = [form for one in (character, *others) for form in _other_forms().get(one, ())]
    more = [form.translate(_simplified_forms()) for form in same]
    return tuple(dict.fromkeys((character, simplified, *others, *same, *more)))


@functools.cache
def _simplified_forms() -> dict[int, str]:
    """The simplified form of each traditional character, as str.translate takes it."""
    return {ord(traditional): form for traditional, form in _read_pairs("variants.txt")}


@functools.cache
def _usual_forms() -> dict[int, str]:
    """The usual form of characters that are only known as another form of one, as str.translate takes it."""
    known = {*_simplified_forms(), *map(ord, _simplified_forms().values())}
    pairs = [(usual, other) for usual, other in _read_pairs("character_forms.txt") if ord(other) not in known]
    return {ord(other): usual for usual, other in reversed(pairs)}


@functools.cache
def _other_forms() -> dict[str, tuple[str, ...]]:
    """The other ways to write each character."""
    forms: dict[str, list[str]] = {}
    for one, other in _read_pairs("character_forms.txt"):
        forms.setdefault(one, []).append(other)
        forms.setdefault(other, []).append(one)
    return {character: tuple(others) for character, others in forms.items()}


def _read_pairs(name: str) -> list[tuple[str, str]]:
    packed = resources.files("rumu.gallery").joinpath(name).read_text(encoding="utf-8").replace("\n", "")
    return list(zip(packed[::2], packed[1::2], strict=True))


def file_in_other_characters(folder: Path, name: str) -> Path | None:
    """The file of a folder that a name means in traditional or simplified characters, None unless it is one.

    A program that writes a table may convert its characters: 張三.png is then 张三.png on the disk. Only the
    last part of the name is looked at, and nothing outside of the folder.
    """
    path = folder / name.replace("\\", "/")
    if not path.parent.is_dir() or not path.resolve().is_relative_to(folder.resolve()):
        return None
    found = _names_by_folded(path.parent, path.parent.stat().st_mtime_ns).get(fold(path.name), [])
    file = path.parent / found[0] if len(found) == 1 else None
    return file if file and file.is_file() and file.resolve().is_relative_to(folder.resolve()) else None


@functools.lru_cache(maxsize=8)  # a table may name thousands of files of one folder
def _names_by_folded(folder: Path, changed: int) -> dict[str, list[str]]:
    """The names in a folder by their folded form. changed: when the folder was, so that none is outdated."""
    names: dict[str, list[str]] = {}
    for one in folder.iterdir():
        names.setdefault(fold(one.name), []).append(one.name)
    return names
