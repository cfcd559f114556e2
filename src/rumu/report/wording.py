"""What the pages say, in Chinese and English; one place, so that the two never drift apart."""

from __future__ import annotations

from typing import NamedTuple

from rumu.values import Assessment, Level, Source


class Text(NamedTuple):
    """One statement in both languages."""

    zh: str
    en: str


LEVELS: dict[Level, Text] = {
    "excellent": Text("优", "excellent"),
    "good": Text("良", "good"),
    "medium": Text("中", "medium"),
    "bad": Text("差", "bad"),
}

PARTS: dict[str, tuple[Text, Text]] = {
    "brushwork": (
        Text("用笔", "Brushwork"),
        Text(
            "笔画的粗细与走向像不像范字。",
            "How like the master's the strokes' widths and directions are.",
        ),
    ),
    "structure": (
        Text("结体", "Structure"),
        Text(
            "笔画的位置像不像范字，缺笔与多余也算在内。",
            "How like the master's the places of the strokes are, missing and extra ones included.",
        ),
    ),
    "ink": (
        Text("墨法", "Ink"),
        Text(
            "笔墨的轻重：与范字相同为一百，每轻或重四分之一减半。",
            "The weight of the ink: 100 at the master's own, half of it for each quarter more or less.",
        ),
    ),
}

SOURCES: dict[Source, Text] = {
    "photometric": Text(
        "高度由多灯照片测得（光度立体）。", "Height measured from photographs under several lamps."
    ),
    "inflation": Text(
        "高度由墨迹“充气”计算而来，不是实测的起伏。",
        "Height computed from the ink by inflation; not measured relief.",
    ),
    "density": Text(
        "高度由墨色浓淡计算而来，不是实测的起伏。",
        "Height computed from the darkness of the ink; not measured relief.",
    ),
}

KINDS: dict[str, Text] = {
    "lean": Text("倾斜", "Lean"),
    "size": Text("大小", "Size"),
    "offset": Text("偏位", "Off centre"),
    "missing": Text("缺笔", "Missing"),
    "extra": Text("多余", "Extra"),
    "displaced": Text("移位", "Out of place"),
    "heavy": Text("偏粗", "Too heavy"),
    "thin": Text("偏细", "Too thin"),
}

UNITS: dict[str, str] = {"deg": "°", "degrees": "°", "percent": "%"}

MEANS: tuple[Text, ...] = (
    Text(
        "分数估计一组人给这张临作打出的平均分（零至一百）。它按真人给楷书毛笔临作的评分校准，校准时从不使用同一个字的评分来检验。",
        "The score estimates the mean mark that a panel of people would give this copy, from 0 to 100. It is "
        "calibrated on human marks of brush copies in regular script, and tested on characters held out.",
    ),
    Text(
        "区间是八成区间：同样的临作，十次里约有八次，评委的平均分会落在其中。",
        "The interval is an 80 % one: for about eight in ten such copies the panel's mean lies inside it.",
    ),
    Text(
        "倾斜、位置和大小先取出、单独列出；只有超出容许的部分才扣分。",
        "Lean, place and size are taken out first and listed apart; only what is beyond a tolerance costs.",
    ),
)

MEANS_NOT: tuple[Text, ...] = (
    Text(
        "它不是对书写者的评价；一张纸说明不了一个人的水平。",
        "It is no verdict on the writer: one sheet does not show what a person can do.",
    ),
    Text(
        "篆、隶、行、草没有真人评分可校准，分数只宜在同一字的几次临写之间比较。",
        "No human marks calibrate seal, clerical, running or cursive script: there, compare only copies of "
        "one character with each other.",
    ),
    Text(
        "由墨迹算出的高度看不见力度与纸上的起伏。",
        "A height computed from ink does not see pressure or the relief of the paper.",
    ),
)

SIMULATED = Text("模拟样本，并非真人书写", "Simulated sample, not written by a person")

REFUSED_ADVICE: tuple[Text, ...] = (
    Text(
        "一张照片只拍一个字，字占画面一半以上，四边留白。",
        "Show one character alone, filling more than half of the picture, with paper on all four sides.",
    ),
    Text(
        "光线均匀，墨黑纸白；手和影子不要入画。",
        "Light the sheet evenly: dark ink, pale paper, no hand and no shadow in the picture.",
    ),
    Text("对焦清楚，字边至少两百像素。", "Focus well; the character should be at least 200 pixels tall."),
)

QUALITY: dict[str, Text] = {
    "residual": Text(
        "模型未能解释的亮度（占像素亮度，中位数）", "Brightness the model leaves unexplained, median share"
    ),
    "shadow_share": Text("落在阴影里的观测比例", "Share of values that lie in shadow"),
    "paper_p": Text(
        "纸面左右坡度（应近于零）", "Median slope across; near 0 when the sheet faced the camera"
    ),
    "paper_q": Text(
        "纸面上下坡度（应近于零）", "Median slope up and down; near 0 when the sheet faced the camera"
    ),
    "strength_spread": Text("最强灯与最弱灯之比", "Strongest lamp over the weakest, as used"),
    "black_level": Text("视为无光的亮度", "Brightness taken for darkness"),
    "measured_share": Text("实测像素的比例", "Share of the pixels that were measured"),
    "brightness": Text("反照率的除数", "What the albedo was divided by, to stay within 1"),
    "lamps": Text("灯数", "Number of lamps"),
    "fourth_lamp": Text("第四灯的核对（越小越好）", "Check by the fourth lamp; small is good"),
    "ink_share": Text("墨迹占画面的比例", "Share of the picture that is ink"),
    "contrast": Text("墨的浓度（中位数，一为全黑）", "Median darkness of the ink; 1 is black"),
    "half_width": Text("笔画半宽（中位数，像素）", "Median half-width of the strokes, in pixels"),
    "noise": Text("墨与纸之差为纸面起伏的多少倍", "Ink against paper, over the paper's own spread"),
    "edge": Text("墨迹边缘的清晰度（一为清晰）", "Sharpness of the outline; 1 is sharp"),
    "between": Text("每个边缘像素对应的半墨像素", "Half-dark pixels for each pixel of outline; few is crisp"),
    "coherence": Text(
        "墨迹成片的程度（一为成片）", "How far the ink hangs together; 1 is solid, 0 is speckle"
    ),
}


def quality_meaning(name: str) -> Text:
    """What a named figure of `Surface.quality` tells; an unknown one is shown by its name alone."""
    plain = name.replace("_", " ")
    return QUALITY.get(name, Text(plain, plain))


def kind_name(kind: str) -> Text:
    """The short name of a remark's kind."""
    return KINDS.get(kind, Text(kind, kind.replace("_", " ").capitalize()))


def with_unit(size: float, unit: str) -> str:
    """'3.2°', '12 %' (a share 'of the ink'), '0.4 mm': one decimal under ten, none above."""
    if unit.startswith("of the"):
        return f"{100 * abs(size):.0f} %"
    number = f"{abs(size):.1f}" if abs(size) < 10 else f"{abs(size):.0f}"
    sign = UNITS.get(unit, unit)
    return f"{number}{sign}" if sign == "°" else f"{number} {sign}".rstrip()


def basis(mark: Assessment) -> list[Text]:
    """What a mark rests on that a person must be told: another calibration, own weights, the interval."""
    said = []
    if mark.calibration:
        said.append(Text(f"另用校準：{mark.calibration}", f"Another calibration: {mark.calibration}"))
    if mark.weights:
        zh, en = (
            join.join(f"{PARTS[name][0][k]} {weight:g}" for name, weight in mark.weights.items())
            for k, join in enumerate(("、", ", "))
        )
        said.append(
            Text(
                f"分數按自定權重合計各分項：{zh}。", f"The score weighs the parts by your own weights: {en}."
            )
        )
    if mark.interval_note:
        said.append(Text(mark.interval_note_zh or mark.interval_note, mark.interval_note))
    return said
