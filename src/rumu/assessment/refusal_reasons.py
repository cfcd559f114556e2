"""Why a copy is refused, in both languages, with what to do about it."""

from __future__ import annotations

from dataclasses import dataclass, replace


@dataclass(frozen=True, slots=True)
class Refusal:
    """Why a copy is not marked. code: one word or two, for programs; zh, en: one sentence, for a person.

    turned_by: degrees clockwise, 90, 180 or 270, by which the picture must be turned to be upright; None
        where turning is not what it needs.
    """

    code: str
    zh: str
    en: str
    turned_by: int | None = None


def refusal_of(code: str) -> Refusal:
    """The sentences of a code; those of what holds no writing for a code that is not known."""
    return Refusal(code, *_SENTENCES.get(code, _SENTENCES["blank"]))


def thin_refusal(*, width: float, expected: float) -> Refusal:
    """The refusal of a copy whose lines are this wide, in pixels, where the master's would be `expected`."""
    return replace(
        refusal_of("too thin"),
        zh=f"線條太細，不是毛筆的筆畫：這裏約寬 {width:.0f} 像素，範字這樣大時約寬 {expected:.0f}。"
        "硬筆和鉛筆寫的字不能評分，請用毛筆書寫。",
        en=f"the lines are too thin for strokes of a brush: about {width:.0f} pixels wide, where the "
        f"master's would be {expected:.0f} at this size; write it with a brush, not with a pen or a pencil",
    )


def turned_refusal(degrees: int) -> Refusal:
    """The refusal of a photograph that is upright once it is turned by 90, 180 or 270 degrees clockwise."""
    refusal = refusal_of(_TURNED[degrees])
    return replace(refusal, turned_by=degrees)


_TURNED = {90: "turned left", 180: "upside down", 270: "turned right"}
_SENTENCES = {
    "blank": (
        "畫面上沒有字。",
        "nothing is written in the picture",
    ),
    "black": (
        "畫面一片黑，看不到紙。",
        "the picture is black and shows no paper",
    ),
    "noise": (
        "畫面裏是噪點或雜物，不是寫在紙上的字。",
        "the picture holds noise or other things and no writing on paper",
    ),
    "too thin": (
        "線條太細，不是毛筆的筆畫；硬筆和鉛筆寫的字不能評分，請用毛筆書寫。",
        "the lines are too thin for strokes of a brush; write it with a brush, not with a pen or a pencil",
    ),
    "uneven light": (
        "光線不勻，有一部分太暗，看不清筆畫；請避開陰影、在均勻的光線下再拍。",
        "the light is too uneven to see the writing everywhere; photograph it without a shadow",
    ),
    "flat": (
        "這個曲面是平的，沒有可比的起伏；請改用一張字的圖片。",
        "the surface is flat and holds no relief to compare; mark the ink of one image instead",
    ),
    "too small": (
        "字太小，看不清筆畫；請靠近些再拍，讓字佔畫面一半以上。",
        "the writing is too small to see its strokes; let it fill more than half of the picture",
    ),
    "cut off": (
        "字被畫面的邊切掉了一部分；請把整個字拍進畫面。",
        "a part of the character is cut off by the edge of the picture; show all of it",
    ),
    "several characters": (
        "畫面裏不止一個字；請只留與範字相同的那一個。",
        "there are several characters in the picture; leave only the one that the master shows",
    ),
    "mirrored": (
        "這個字左右反了；請檢查照片是不是鏡像。",
        "the character is mirrored; see whether the photo was flipped",
    ),
    "upside down": (
        "照片上下顛倒了；請把照片轉一百八十度。",
        "the photograph is upside down; turn it by 180 degrees",
    ),
    "turned left": (
        "照片向左（逆時針）轉了九十度；請把照片向右（順時針）轉九十度。",
        "the photograph is turned by 90 degrees to the left; turn it by 90 degrees clockwise",
    ),
    "turned right": (
        "照片向右（順時針）轉了九十度；請把照片向左（逆時針）轉九十度。",
        "the photograph is turned by 90 degrees to the right; turn it by 90 degrees anticlockwise",
    ),
    "outline only": (
        "只描了筆畫的輪廓，裏面是空的；請用毛筆寫實。",
        "only the outline of the strokes is drawn and they are hollow; write them with the brush",
    ),
    "another character": (
        "寫的不是範字上的那個字，或者看不出是字；請核對範字。",
        "this is not the master's character, or no character at all; see whether the master is the right one",
    ),
}
