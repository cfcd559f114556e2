"""The words of a capture report, in Chinese and English."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

Language = Literal["zh", "en"]

_WORDS: dict[str, tuple[str, str]] = {
    "title": ("拍攝報告", "Capture report"),
    "lamps": ("燈", "Lamps"),
    "from": ("方向取自", "directions from"),
    "tilt": ("方位", "tilt"),
    "slant": ("傾角", "slant"),
    "maps": ("各圖", "Maps"),
    "albedo": ("反照率", "Albedo"),
    "height": ("高度", "Height"),
    "normals": ("法線", "Normals"),
    "residual": ("殘差：淺為合，深紅為 {}% 以上", "Residual: pale agrees, dark red {}% or more"),
    "confidence": ("可信度：白為可信", "Confidence: white is sure"),
    "sections": ("剖面", "Sections"),
    "across": ("橫過中央，左到右", "Across the middle, left to right"),
    "down": ("縱過中央，上到下", "Down the middle, top to bottom"),
    "figures": ("數字", "Figures"),
    "size": ("大小", "Size"),
    "pixels": ("像素", "pixels"),
    "pixel": ("每像素", "One pixel"),
    "no_scale": ("比例未知，高度以像素計", "scale not known; heights are in pixels"),
    "range": ("高度範圍", "Range of the height"),
    "photographs": ("照片", "Photographs"),
    "name": ("檔名", "File"),
    "strength": ("強度", "strength"),
    "off": ("殘差 %", "residual %"),
    "shadow": ("陰影 %", "shadow %"),
    "white": ("過曝 %", "white %"),
    "sharp": ("清晰", "sharp"),
    "moved": ("錯開 px", "moved px"),
    "taken": ("拍攝時間", "taken"),
    "settings": ("曝光", "exposure"),
    "camera": ("相機", "Camera"),
    "lens": ("鏡頭", "Lens"),
    "software": ("軟體", "Software"),
    "author": ("作者", "Author"),
    "rights": ("權利", "Rights"),
    "caption": ("說明", "Caption"),
    "notes": ("附記", "Notes"),
    "record": ("製作紀錄", "How it was made"),
    "made": ("製作", "made"),
    "by": ("製作者", "by"),
    "version": ("版本", "version"),
    "read": ("讀入的檔案（SHA-256）", "Files that were read (SHA-256)"),
    "result": ("結果（SHA-256）", "Results (SHA-256)"),
    "sign": ("簽核", "Signature"),
    "checked": (
        "本人已核對以上紀錄與照片相符。",
        "I have checked that this report agrees with the photographs.",
    ),
    "signed_name": ("姓名、單位", "Name, institution"),
    "signed_date": ("日期", "Date"),
    "signature": ("簽名", "Signature"),
    "nothing": (
        "照片檔裡沒有相機、曝光與時間的記載。",
        "The files of the photographs tell neither camera nor exposure nor date.",
    ),
}


@dataclass(frozen=True, slots=True)
class CaptureWords:
    """The words of a report in one language."""

    language: Language

    @property
    def index(self) -> int:
        """The place of the language in a Bilingual."""
        return 0 if self.language == "zh" else 1

    def __getitem__(self, name: str) -> str:
        return _WORDS[name][self.index]


def all_letters() -> str:
    """Every letter that the words of both languages need."""
    return "".join(word for pair in _WORDS.values() for word in pair)
