"""What the pages say, in Chinese and English; one place, so that the two never drift apart."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Literal

from rumu.values import Assessment, Bilingual, Level, Source

Language = Literal["zh", "en"]

LEVELS: dict[Level, Bilingual] = {
    "excellent": Bilingual("優", "excellent"),
    "good": Bilingual("良", "good"),
    "medium": Bilingual("中", "medium"),
    "bad": Bilingual("差", "bad"),
}

PARTS: dict[str, tuple[Bilingual, Bilingual]] = {
    "brushwork": (
        Bilingual("用筆", "Brushwork"),
        Bilingual(
            "筆畫的粗細、走向與墨邊（起筆、行筆、轉折、收筆）像不像範字。",
            "How like the master's the strokes' widths, directions and edges are: how they begin, turn, end.",
        ),
    ),
    "structure": (
        Bilingual("結體", "Structure"),
        Bilingual(
            "筆畫的位置像不像範字，缺筆與多餘也算在內。",
            "How like the master's the places of the strokes are, missing and extra ones included.",
        ),
    ),
    "ink": (
        Bilingual("墨法", "Ink"),
        Bilingual(
            "筆墨的輕重：與範字相同為一百，每輕或重四分之一減半。",
            "The weight of the ink: 100 at the master's own, half of it for each quarter more or less.",
        ),
    ),
}

SOURCES: dict[Source, Bilingual] = {
    "photometric": Bilingual(
        "高度由多燈照片測得（光度立體）。", "Height measured from photographs under several lamps."
    ),
    "inflation": Bilingual(
        "高度由墨跡「充氣」計算而來，不是實測的起伏。",
        "Height computed from the ink by inflation; not measured relief.",
    ),
    "density": Bilingual(
        "高度由墨色濃淡計算而來，不是實測的起伏。",
        "Height computed from the darkness of the ink; not measured relief.",
    ),
}

KINDS: dict[str, Bilingual] = {
    "lean": Bilingual("傾斜", "Lean"),
    "size": Bilingual("大小", "Size"),
    "offset": Bilingual("偏位", "Off centre"),
    "missing": Bilingual("缺筆", "Missing"),
    "no_hook": Bilingual("鉤未出", "No hook"),
    "extra": Bilingual("多餘", "Extra"),
    "displaced": Bilingual("移位", "Out of place"),
    "heavy": Bilingual("偏粗", "Too heavy"),
    "thin": Bilingual("偏細", "Too thin"),
    "aspect": Bilingual("寬窄", "Width for its height"),
    "squeeze": Bilingual("比例", "Proportion"),
    "part_place": Bilingual("兩部位置", "Place of the parts"),
    "inner": Bilingual("內外大小", "What is enclosed"),
    "spacing": Bilingual("間距", "Spacing"),
    "stroke_angle": Bilingual("筆畫斜了", "Stroke at a wrong angle"),
    "stroke_short": Bilingual("筆畫太短", "Stroke too short"),
    "stroke_long": Bilingual("筆畫太長", "Stroke too long"),
    "sticks_out": Bilingual("出頭", "Sticks out"),
    "stroke_heavy": Bilingual("一筆太粗", "Stroke too heavy"),
    "stroke_thin": Bilingual("一筆太細", "Stroke too thin"),
    "entry_heavy": Bilingual("起筆太重", "Entry too heavy"),
    "entry_light": Bilingual("起筆太輕", "Entry too light"),
    "exit_blunt": Bilingual("收筆禿鈍", "Blunt exit"),
    "rough": Bilingual("筆畫抖動", "Trembling edges"),
    "blot": Bilingual("墨漬", "Blot"),
    "filled": Bilingual("留白糊住", "White run shut"),
    "open": Bilingual("沒有封口", "Box not closed"),
    "pale": Bilingual("墨色太淡", "Pale ink"),
    "dry": Bilingual("枯筆", "Dry brush"),
}

UNITS: dict[str, str] = {"deg": "°", "degrees": "°", "percent": "%"}

MEANS: tuple[Bilingual, ...] = (
    Bilingual(
        "分數估計一組人給這張臨作打出的平均分（零至一百）。它按真人給楷書毛筆臨作的評分校準，校準時從不使用同一個字的評分來檢驗。",
        "The score estimates the mean mark that a panel of people would give this copy, from 0 to 100. It is "
        "calibrated on human marks of brush copies in regular script, and tested on characters held out.",
    ),
    Bilingual(
        "區間是八成區間：同樣的臨作，十次裡約有八次，評委的平均分會落在其中。",
        "The interval is an 80% one: for about eight in ten such copies the panel's mean lies inside it.",
    ),
    Bilingual(
        "傾斜、位置和大小先取出、單獨列出；只有超出容許的部分才扣分。",
        "Lean, place and size are taken out first and listed apart; only what is beyond a tolerance costs.",
    ),
)

MEANS_NOT: tuple[Bilingual, ...] = (
    Bilingual(
        "它不是對書寫者的評價；一張紙說明不了一個人的水平。",
        "It is no verdict on the writer: one sheet does not show what a person can do.",
    ),
    Bilingual(
        "篆、隸、行、草沒有真人評分可校準，分數只宜在同一字的幾次臨寫之間比較。",
        "No human marks calibrate seal, clerical, running or cursive script: there, compare only copies of "
        "one character with each other.",
    ),
    Bilingual(
        "由墨跡算出的高度看不見力度與紙上的起伏。",
        "A height computed from ink does not see pressure or the relief of the paper.",
    ),
)

SIMULATED = Bilingual("模擬樣本，並非真人書寫", "Simulated sample, not written by a person")

REFUSED_ADVICE: tuple[Bilingual, ...] = (
    Bilingual(
        "一張照片只拍一個字，字佔畫面一半以上，四邊留白。",
        "Show one character alone, filling more than half of the picture, with paper on all four sides.",
    ),
    Bilingual(
        "光線均勻，墨黑紙白；手和影子不要入畫。",
        "Light the sheet evenly: dark ink, pale paper, no hand and no shadow in the picture.",
    ),
    Bilingual(
        "對焦清楚，字邊至少兩百像素。", "Focus well; the character should be at least 200 pixels tall."
    ),
)

QUALITY: dict[str, Bilingual] = {
    "residual": Bilingual(
        "模型未能解釋的亮度（佔像素亮度，中位數）", "Brightness the model leaves unexplained, median share"
    ),
    "shadow_share": Bilingual("落在陰影裡的觀測比例", "Share of values that lie in shadow"),
    "paper_p": Bilingual(
        "紙面左右坡度（應近於零）", "Median slope across; near 0 when the sheet faced the camera"
    ),
    "paper_q": Bilingual(
        "紙面上下坡度（應近於零）", "Median slope up and down; near 0 when the sheet faced the camera"
    ),
    "strength_spread": Bilingual("最強燈與最弱燈之比", "Strongest lamp over the weakest, as used"),
    "black_level": Bilingual("視為無光的亮度", "Brightness taken for darkness"),
    "measured_share": Bilingual("實測像素的比例", "Share of the pixels that were measured"),
    "brightness": Bilingual("反照率的除數", "What the albedo was divided by, to stay within 1"),
    "lamps": Bilingual("燈數", "Number of lamps"),
    "materials": Bilingual(
        "另計的材質數（光澤、金屬、粗面）", "Materials beside Lambert's: gloss, metal, rough"
    ),
    "fourth_lamp": Bilingual("第四燈的核對（越小越好）", "Check by the fourth lamp; small is good"),
    "ink_share": Bilingual("墨跡佔畫面的比例", "Share of the picture that is ink"),
    "darkest": Bilingual("最濃處的墨（一為全黑）", "Darkness of the darkest ink; 1 is black"),
    "contrast": Bilingual("墨的濃度（中位數，一為全黑）", "Median darkness of the ink; 1 is black"),
    "half_width": Bilingual("筆畫半寬（中位數，像素）", "Median half-width of the strokes, in pixels"),
    "noise": Bilingual("墨與紙之差為紙面起伏的多少倍", "Ink against paper, over the paper's own spread"),
    "edge": Bilingual("墨跡邊緣的清晰度（一為清晰）", "Sharpness of the outline; 1 is sharp"),
    "between": Bilingual(
        "每個邊緣像素對應的半墨像素", "Half-dark pixels for each pixel of outline; few is crisp"
    ),
    "light": Bilingual(
        "紙邊最暗處與最亮處之比（一為光線均勻）",
        "Darkest over brightest part of the paper's border; 1 is even light",
    ),
    "character": Bilingual("單字邊長（像素）", "Side of one character, in pixels"),
    "reduced": Bilingual("原圖縮小的倍數", "Times the picture was reduced"),
    "coherence": Bilingual(
        "墨跡成片的程度（一為成片）", "How far the ink hangs together; 1 is solid, 0 is speckle"
    ),
}


def quality_meaning(name: str) -> Bilingual:
    """What a named figure of `Surface.quality` means; an unknown one is shown by its name alone."""
    plain = name.replace("_", " ")
    return QUALITY.get(name, Bilingual(plain, plain))


def kind_name(kind: str) -> Bilingual:
    """The short name of a remark's kind."""
    return KINDS.get(kind, Bilingual(kind, kind.replace("_", " ").capitalize()))


def with_unit(size: float, unit: str) -> str:
    """'3.2°', '12%' (a share 'of the ink'), '0.4 mm': one decimal under ten, none above."""
    if unit.startswith("of the"):
        return f"{abs(size):.0%}"
    number = f"{abs(size):.1f}" if abs(size) < 10 else f"{abs(size):.0f}"
    sign = UNITS.get(unit, unit)
    return f"{number}{sign}" if sign in ("°", "%") else f"{number} {sign}".rstrip()


def standing(percentile: float) -> Bilingual:
    """Where a copy stands among learners' copies, in tenths."""
    tenths = round(percentile / 10)
    if tenths <= 0:
        return Bilingual("在學習者的臨作裡，屬最低的一成。", "Among the lowest tenth of learners' copies.")
    if tenths >= 10:
        return Bilingual("比幾乎所有學習者的臨作都好。", "Better than nearly all learners' copies.")
    return Bilingual(
        f"學習者的臨作，每十張裡比 {tenths} 張好。", f"Better than {tenths} of 10 learners' copies."
    )


def deduction_note(mark: Assessment) -> Bilingual | None:
    """What was taken off a mark for how the whole stands in its picture; None where that is less than 1."""
    told = {name: points for name, points in mark.deductions.items() if points >= 1}
    if not told:
        return None
    zh, en = (
        join.join(pattern.format(_TAKEN_OFF[name][k], points) for name, points in told.items())
        for k, (join, pattern) in enumerate((("、", "{} {:.0f} 分"), (", ", "{1:.0f} points for {0}")))
    )
    return Bilingual(
        f"整字在圖片裡的位置扣了：{zh}。圖片的邊緣當作格子；不是格子的話，請裁到格子再評。",
        f"Taken off for how the whole stands in the picture: {en}. The edges of the picture count as the "
        "cell: where they are not, crop it to the cell.",
    )


_TAKEN_OFF = {
    "lean": Bilingual("傾斜", "leaning"),
    "offset": Bilingual("偏位", "its place"),
    "size": Bilingual("大小", "its size"),
}


def basis(mark: Assessment) -> list[Bilingual]:
    """What a person must know of a mark: where it stands, what was taken off, other terms, the interval."""
    lines = [] if mark.percentile is None else [standing(mark.percentile)]
    taken_off = deduction_note(mark)
    if taken_off:
        lines.append(taken_off)
    if mark.calibration:
        lines.append(Bilingual(f"另用校準：{mark.calibration}", f"Another calibration: {mark.calibration}"))
    if mark.weights:
        zh, en = (
            join.join(f"{PARTS[name][0][k]} {weight:g}" for name, weight in mark.weights.items())
            for k, join in enumerate(("、", ", "))
        )
        lines.append(
            Bilingual(
                f"分數按自定權重合計各分項：{zh}。", f"The score weighs the parts by your own weights: {en}."
            )
        )
    if mark.interval_note:
        lines.append(Bilingual(mark.interval_note_zh or mark.interval_note, mark.interval_note))
    return lines


class ReportWords:
    """The words of a report in one language. table: each by its name, in Chinese and English."""

    def __init__(self, table: Mapping[str, tuple[str, str]], language: Language) -> None:
        self._table, self._english = table, language == "en"

    def __getitem__(self, name: str) -> str:
        return self.chosen(self._table[name])

    def chosen(self, text: tuple[str, str]) -> str:
        """The Chinese or the English text; the English one, too, where there is no Chinese."""
        zh, en = text
        return en if self._english or not zh else zh

    def letters(self) -> str:
        """All letters of the table."""
        return "".join(map(self.chosen, self._table.values()))
