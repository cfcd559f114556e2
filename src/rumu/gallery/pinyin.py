"""Readings of Chinese text in pinyin, and pinyin as people type it: with or without tones, with ü or v."""

from __future__ import annotations

import functools
import re
import unicodedata

_LIST = """
a ai an ang ao ba bai ban bang bao bei ben beng bi bian biao bie bin bing bo bu ca cai can cang cao ce
cen ceng cha chai chan chang chao che chen cheng chi chong chou chu chua chuai chuan chuang chui chun
chuo ci cong cou cu cuan cui cun cuo da dai dan dang dao de dei deng di dia dian diao die ding diu dong
dou du duan dui dun duo e ei en er fa fan fang fei fen feng fo fou fu ga gai gan gang gao ge gei gen
geng gong gou gu gua guai guan guang gui gun guo ha hai han hang hao he hei hen heng hong hou hu hua
huai huan huang hui hun huo ji jia jian jiang jiao jie jin jing jiong jiu ju juan jue jun ka kai kan
kang kao ke kei ken keng kong kou ku kua kuai kuan kuang kui kun kuo la lai lan lang lao le lei leng li
lia lian liang liao lie lin ling liu lo long lou lu luan lun luo lv lve ma mai man mang mao me mei men
meng mi mian miao mie min ming miu mo mou mu na nai nan nang nao ne nei nen neng ni nian niang niao nie
nin ning niu nong nou nu nuan nuo nv nve o ou pa pai pan pang pao pei pen peng pi pian piao pie pin ping
po pou pu qi qia qian qiang qiao qie qin qing qiong qiu qu quan que qun ran rang rao re ren reng ri rong
rou ru ruan rui run ruo sa sai san sang sao se sen seng sha shai shan shang shao she shei shen sheng shi
shou shu shua shuai shuan shuang shui shun shuo si song sou su suan sui sun suo ta tai tan tang tao te
teng ti tian tiao tie ting tong tou tu tuan tui tun tuo wa wai wan wang wei wen weng wo wu xi xia xian
xiang xiao xie xin xing xiong xiu xu xuan xue xun ya yan yang yao ye yi yin ying yo yong you yu yuan yue
yun za zai zan zang zao ze zei zen zeng zha zhai zhan zhang zhao zhe zhei zhen zheng zhi zhong zhou zhu
zhua zhuai zhuan zhuang zhui zhun zhuo zi zong zou zu zuan zui zun zuo
"""
SYLLABLES = frozenset(_LIST.split())
_PREFIXES = frozenset(syllable[:end] for syllable in SYLLABLES for end in range(1, len(syllable)))
_LONGEST = max(map(len, SYLLABLES))
_TONES = {"\u0304": "1", "\u0301": "2", "\u030c": "3", "\u0300": "4"}  # macron, acute, caron, grave
_MOST_WAYS = 8  # of splitting one word: 'xianguan' has four
_MOST_LETTERS = 80  # of a word that is read as pinyin

_SURNAMES = {
    "曾": "zeng", "單": "shan", "单": "shan", "解": "xie", "仇": "qiu", "查": "zha", "繆": "miao",
    "缪": "miao", "朴": "piao", "區": "ou", "区": "ou", "任": "ren", "華": "hua", "华": "hua",
    "蓋": "ge", "盖": "ge", "翟": "zhai", "褚": "chu", "員": "yun", "员": "yun", "種": "chong",
    "种": "chong", "樂": "yue", "乐": "yue", "尉": "yu", "冼": "xian", "葉": "ye", "叶": "ye",
    "車": "che", "石": "shi", "沈": "shen", "长": "zhang", "長": "zhang", "召": "shao", "祭": "zhai",
    "洗": "xian", "宓": "mi", "那": "na", "曲": "qu", "令": "ling",
}  # fmt: skip
"""Readings that a character has as a surname."""


def split_pinyin(word: str) -> tuple[tuple[str, ...], ...]:
    """All ways to read a word as whole syllables; none where it is no pinyin.

    A tone that is given, by a mark or a number, stands behind its syllable as a number: 'yǒng' and 'yong3'
    are (('yong3',),), 'xian' is (('xian',), ('xi', 'an')). ü is v.
    """
    letters, tones, bounds = _letters_and_tones(word)
    if not letters or len(letters) > _MOST_LETTERS:
        return ()
    found: list[tuple[str, ...]] = []

    def extend(at: int, syllables: tuple[str, ...]) -> None:
        if at == len(letters) and len(found) < _MOST_WAYS:
            found.append(syllables)
        for end in range(min(len(letters), at + _LONGEST), at, -1):
            if (
                len(found) < _MOST_WAYS
                and letters[at:end] in SYLLABLES
                and not bounds & set(range(at + 1, end))
            ):
                marks = [tones[k] for k in range(at, end) if k in tones]
                if len(marks) <= 1:
                    extend(end, (*syllables, letters[at:end] + "".join(marks)))

    if _can_be_split(letters):
        extend(0, ())
    return tuple(found)


def unfinished_pinyin(word: str) -> tuple[tuple[str, ...], ...]:
    """Ways to read a word as syllables of which the last is begun: 'lanti' is (('lan', 'ti'),)."""
    letters, _, _ = _letters_and_tones(word)
    ends = range(len(letters) - 1, max(0, len(letters) - _LONGEST), -1)
    heads = [(letters[:end], letters[end:]) for end in ends if letters[end:] in _PREFIXES]
    return tuple((*without_tones(way), tail) for head, tail in heads for way in split_pinyin(head))[
        :_MOST_WAYS
    ]


def without_tones(syllables: tuple[str, ...]) -> tuple[str, ...]:
    """The syllables without the numbers of their tones."""
    return tuple(syllable.rstrip("12345") for syllable in syllables)


def _letters_and_tones(word: str) -> tuple[str, dict[int, str], set[int]]:
    """Letters a to z; the tone at the place of a letter; places where a syllable must end."""
    letters, tones, bounds = "", {}, set()
    for char in unicodedata.normalize("NFD", word.lower().replace("u:", "ü").replace("lue", "lve")):
        if "a" <= char <= "z":
            letters += char
        elif char == "\u0308" and letters.endswith("u"):
            letters = letters[:-1] + "v"
        elif letters and char in _TONES:
            tones[len(letters) - 1] = _TONES[char]
        elif letters and char in "012345":
            tones[len(letters) - 1] = char if char != "0" else "5"
            bounds.add(len(letters))
        elif letters and char in "'’-":
            bounds.add(len(letters))
        else:
            return "", {}, set()
    return letters.replace("nue", "nve"), tones, bounds


def _can_be_split(letters: str) -> bool:
    """Whether there is a way at all; without this check long words that have none take for ever."""
    reached = {0}
    for at in range(len(letters)):
        if at in reached:
            ends = range(at + 1, min(len(letters), at + _LONGEST) + 1)
            reached.update(end for end in ends if letters[at:end] in SYLLABLES)
    return len(letters) in reached


# --- readings --------------------------------------------------------------------------------------


@functools.cache
def character_readings(character: str) -> tuple[str, ...]:
    """The readings of one character with the numbers of their tones, the most usual first; () if none."""
    from pypinyin import Style, pinyin

    found = pinyin(character, style=Style.TONE3, heteronym=True, errors="ignore", v_to_u=False)
    return tuple(dict.fromkeys(found[0])) if found else ()


@functools.lru_cache(maxsize=4096)
def text_readings(*forms: str, surname: bool = False, most: int = 8) -> tuple[tuple[str, ...], ...]:
    """Readings of a run of Chinese characters, without tones: as a phrase, and with other usual readings.

    forms: the same text in traditional and simplified characters, which phrases are looked up by. surname:
    it is a name, whose first character has a reading of its own. most: how many readings.
    """
    from pypinyin import lazy_pinyin

    found = [tuple(lazy_pinyin(form, errors="ignore", v_to_u=False)) for form in forms]
    length = len(forms[0])
    found = [way for way in found if len(way) == length]
    if not found:
        return ()
    if surname and forms[0][0] in _SURNAMES:
        found.insert(0, (_SURNAMES[forms[0][0]], *found[0][1:]))
    for at, character in enumerate(forms[0]):
        for other in dict.fromkeys(without_tones(character_readings(character)[:3])):
            found.append((*found[0][:at], other, *found[0][at + 1 :]))
    return tuple(dict.fromkeys(found))[:most]


def is_han(text: str) -> bool:
    """Whether all characters of a text are Chinese characters."""
    return bool(re.fullmatch(r"[㐀-鿿豈-﫿\U00020000-\U0003ffff〇]+", text))
