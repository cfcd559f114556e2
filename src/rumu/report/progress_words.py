"""What two attempts changed, in the words of a page: which stroke, what it was, what it is now."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from rumu.assessment.progress import FaultChange, NumberChange
from rumu.characters.stroke_data import find_character
from rumu.report.wording import kind_name, with_unit
from rumu.strokes.naming import place_of, stroke_title
from rumu.values import Bilingual, Remark

FAULTS: Mapping[str, Bilingual] = {
    "stroke_short": Bilingual("太短", "too short"),
    "stroke_long": Bilingual("太長", "too long"),
    "stroke_heavy": Bilingual("太粗", "too heavy"),
    "stroke_thin": Bilingual("太細", "too thin"),
    "entry_heavy": Bilingual("起筆太重", "too heavy where it begins"),
    "entry_light": Bilingual("起筆太輕", "too light where it begins"),
    "exit_blunt": Bilingual("收筆禿鈍", "blunt where it ends"),
    "no_hook": Bilingual("沒有鉤出", "without its flick"),
    "displaced": Bilingual("移位", "out of place"),
    "stroke_angle": Bilingual("斜了", "at a wrong angle"),
    "missing": Bilingual("缺筆", "missing"),
    "extra": Bilingual("多出一筆", "a stroke too many"),
    "blot": Bilingual("有墨漬", "blotted"),
    "lean": Bilingual("傾斜", "leaning"),
    "size": Bilingual("大小不合", "of another size"),
    "offset": Bilingual("偏位", "off centre"),
    "aspect": Bilingual("寬窄不合", "of another shape"),
    "heavy": Bilingual("筆畫偏粗", "too heavy"),
    "thin": Bilingual("筆畫偏細", "too thin"),
    "squeeze": Bilingual("比例不合", "out of proportion"),
    "part_place": Bilingual("位置不合", "not in place beside each other"),
    "inner": Bilingual("裡面大小不合", "wrong in the size of what is enclosed"),
    "sticks_out": Bilingual("出頭", "sticking out"),
    "filled": Bilingual("留白糊住", "with white run shut"),
    "open": Bilingual("框沒有封口", "not closed"),
    "spacing": Bilingual("間距不勻", "unevenly spaced"),
    "rough": Bilingual("筆畫抖動", "trembling"),
    "pale": Bilingual("墨色太淡", "pale"),
    "dry": Bilingual("枯筆", "dry"),
}
"""What is wrong, so that it can follow the name of a stroke."""

_OF_PARTS = ("squeeze", "part_place")
"""Kinds of remark that speak of one part beside the other."""

_SENTENCES: Mapping[str, Bilingual] = {
    "gone": Bilingual(
        "{who}：上次{was}（{from}），這次好了。", "{who}: {was} last time ({from}), now right."
    ),
    "there": Bilingual("{who}：上次漏寫，這次寫到了。", "{who}: missing last time, written this time."),
    "smaller": Bilingual(
        "{who}：仍{now}，但好些了：{from} → {to}。", "{who}: still {now}, but less so: {from} → {to}."
    ),
    "same": Bilingual(
        "{who}：仍{now}，與上次差不多（{to}）。", "{who}: still {now}, about as before ({to})."
    ),
    "larger": Bilingual(
        "{who}：{now}，比上次明顯：{from} → {to}。", "{who}: {now}, more than before: {from} → {to}."
    ),
    "turned": Bilingual(
        "{who}：上次{was}（{from}），這次{now}（{to}），過了頭。",
        "{who}: {was} last time ({from}), now {now} ({to}).",
    ),
    "over": Bilingual(
        "{who}：仍{now}，卻偏到另一邊：{from} → {to}。",
        "{who}: still {now}, but to the other side: {from} → {to}.",
    ),
    "new": Bilingual("{who}：這次{now}（{to}），上次沒有。", "{who}: {now} this time ({to}), not last time."),
}


def describe_fault(change: FaultChange, *, character: str) -> Bilingual:
    """One sentence on what became of a fault. character: the master's, '' where it is not known."""
    was, now = change.before or change.remark, change.after or change.remark
    form: str = change.status
    if form == "gone" and change.remark.kind == "missing":
        form = "there"
    elif form == "turned" and was.kind == now.kind:
        form = "over"
    who = stroke_name(change.remark, character=character)
    sizes = {"from": size_words(was), "to": size_words(now)}
    return Bilingual(
        *(
            sentence.format(who=name, was=fault_words(was)[k], now=fault_words(now)[k], **sizes)
            for k, (sentence, name) in enumerate(zip(_SENTENCES[form], who, strict=True))
        )
    )


def describe_mark(change: NumberChange) -> Bilingual:
    """One sentence on the whole mark."""
    before, after = f"{change.before:.0f}", f"{change.after:.0f}"
    if change.change == "same":
        return Bilingual(
            f"整體與上一張差不多：{before} → {after}，相差不超過評分本身的誤差。",
            f"About as before, as a whole: {before} → {after}, no more than the mark's own error.",
        )
    zh, en = ("比上一張好", "Better") if change.change == "better" else ("不如上一張", "Not as good")
    return Bilingual(f"整體{zh}：{before} → {after}。", f"{en} as a whole: {before} → {after}.")


def fault_words(remark: Remark) -> Bilingual:
    """What is wrong, without its place and size."""
    name = kind_name(remark.kind)
    return FAULTS.get(remark.kind, Bilingual(name.zh, name.en[:1].lower() + name.en[1:]))


def size_words(remark: Remark) -> str:
    """Its size with its unit, as remarks print it."""
    return with_unit(remark.size, remark.unit)


def stroke_name(remark: Remark, *, character: str) -> Bilingual:
    """'第三筆「橫」', 'The third stroke, a horizontal'; without its number, by its place; or the whole."""
    known = None if remark.stroke is None else find_character(character)
    if known is not None and remark.stroke is not None and remark.stroke <= len(known.strokes):
        name = known.strokes[remark.stroke - 1].name
        return Bilingual(stroke_title(remark.stroke, name).zh, f"Stroke {remark.stroke}, {name.en}")
    lines = remark.master_outline or remark.outline
    if not lines:
        return Bilingual("整字", "The whole")
    if remark.kind in _OF_PARTS:
        return Bilingual("兩部", "The two parts")
    if len(lines) > 1:
        return Bilingual("幾筆", "Several strokes")
    xy = np.array(lines[0], dtype=float)
    zh, en = place_of((xy.min(axis=0) + xy.max(axis=0)) / 2)
    return Bilingual(f"{zh}的一筆", f"The stroke at the {en}")
