"""Words of the catalogue in both languages: scripts, dynasties, and where a height comes from."""

from __future__ import annotations

import re

from rumu.values import Bilingual

UNKNOWN = Bilingual(zh="未詳", en="not known")

SCRIPT_NAMES = {
    "seal": Bilingual(zh="篆書", en="seal"),
    "clerical": Bilingual(zh="隸書", en="clerical"),
    "regular": Bilingual(zh="楷書", en="regular"),
    "running": Bilingual(zh="行書", en="running"),
    "cursive": Bilingual(zh="草書", en="cursive"),
}

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


def dynasty_key(told: str) -> str:
    """What a work is browsed by: 'Tang' of 'Tang (attributed)' or 唐, 'Tang/Song' of 'Tang/Song copy'.

    Words that name no dynasty of the table stay as they are.
    """
    if told.strip() in _BY_CHINESE:
        return _BY_CHINESE[told.strip()]
    named = dict.fromkeys(_BY_LOWER[name.lower()] for name in _NAMED.findall(told))
    return "/".join(named) if named else told.strip()


def dynasty_name(key: str) -> Bilingual:
    """A key of `dynasty_key` in both languages."""
    if not key:
        return UNKNOWN
    return Bilingual(zh="／".join(DYNASTIES.get(name, name) for name in key.split("/")), en=key)


def period_in_words(told: str) -> Bilingual:
    """What a table says of a period, in both languages as far as its words are known."""
    if told.strip() in _BY_CHINESE:
        return Bilingual(zh=told.strip(), en=_BY_CHINESE[told.strip()])
    chinese = _NAMED.sub(lambda found: DYNASTIES[_BY_LOWER[found[0].lower()]], told)
    for english, word in _WORDS.items():
        chinese = re.sub(rf"\b{english}\b", word, chinese, flags=re.IGNORECASE)
    tidy = re.sub(r"(?<=[^\x00-\x7f]) (?=[^\x00-\x7f])", "", chinese)
    return Bilingual(zh=tidy.replace(" (", "（").replace(")", "）").replace("/", "／"), en=told)


def script_name(script: str) -> Bilingual:
    """A script in both languages; an unknown word stays as it is."""
    return SCRIPT_NAMES.get(script, UNKNOWN if not script else Bilingual(zh=script, en=script))
