"""Draw how a capture with the card is set up: `python scripts/draw_card_setup.py` writes docs/pictures/.

The left half shows it from the side, the right half from above with the places of the lamp; the card is drawn
from its own layout.
"""

from __future__ import annotations

from pathlib import Path

import matplotlib as mpl
import numpy as np

mpl.use("Agg")

import matplotlib.pyplot as plt
from matplotlib import font_manager
from matplotlib.axes import Axes
from matplotlib.patches import Circle, Polygon, Rectangle

from rumu.card.layout import GRAYS, CardLayout
from rumu.pdf_text import find_chinese_font

OUT = Path(__file__).parents[1] / "docs" / "pictures" / "card-setup.png"
INK, LAMP, SOFT = "#22201d", "#c87a12", "#8d8880"


def _label(axes: Axes, place: tuple[float, float], zh: str, en: str, **options: object) -> None:
    text = f"{zh}\n{en}" if find_chinese_font() else en
    axes.text(*place, text, fontsize=9, color=INK, va="center", **options)  # type: ignore[arg-type]


def _lamp(axes: Axes, x: float, y: float, size: float = 9.0) -> None:
    axes.add_patch(Circle((x, y), size, color=LAMP, zorder=5))
    for angle in np.radians(np.arange(0, 360, 45)):
        way = np.array([np.cos(angle), np.sin(angle)])
        start, end = np.array([x, y]) + 1.4 * size * way, np.array([x, y]) + 2.0 * size * way
        axes.plot(*zip(start, end, strict=True), color=LAMP, lw=1.2)


def draw_side(axes: Axes) -> None:
    """Books, phone, card and lamp from the side, in millimetres."""
    axes.add_patch(Rectangle((-330, -12), 700, 12, color="#d8d2c6"))
    for k, shade in enumerate(("#a89a86", "#968873", "#b5a894", "#8b7d69", "#a2937d", "#94866f")):
        axes.add_patch(Rectangle((-310 + 4 * (k % 3), 50 * k), 130, 48, color=shade))
    axes.add_patch(Rectangle((-200, 300), 240, 9, color=INK))
    axes.add_patch(Rectangle((-9, 294), 18, 6, color=SOFT))
    for x in (-105, 105):
        axes.plot([0, x], [296, 2], color=SOFT, lw=0.8, ls=":")
    axes.add_patch(Rectangle((-105, 0), 210, 2.5, color="white", ec=INK, lw=0.8))
    axes.add_patch(Circle((-42, 11), 9.5, color="#9aa0a6", ec=INK, lw=0.8))
    _lamp(axes, 250, 250)
    axes.annotate("", (22, 12), (236, 236), arrowprops={"arrowstyle": "->", "color": LAMP, "lw": 1.2})
    _label(axes, (0, 338), "手機，鏡頭伸出書堆", "phone, its lens beyond the books", ha="center")
    _label(axes, (278, 306), "小燈，離卡 30 到 50 公分", "small lamp, 30 to 50 cm away", ha="center")
    _label(axes, (115, 24), "拍攝卡", "the card")
    _label(axes, (-60, 40), "亮球", "shiny ball", ha="center")
    axes.set_xlim(-335, 375)
    axes.set_ylim(-15, 365)


def draw_above(axes: Axes) -> None:
    """The card from above with six places of the lamp, in millimetres."""
    layout = CardLayout("A4")
    width, height = layout.size
    axes.add_patch(Rectangle((0, 0), width, height, color="white", ec=INK, lw=0.8))
    for box in layout.markers.values():
        axes.add_patch(Rectangle((box.left, height - box.top - box.height), box.width, box.height, color=INK))
    for patch in layout.patches:
        box, level = patch.box, GRAYS[patch.level] ** (1 / 2.2)
        axes.add_patch(
            Rectangle((box.left, height - box.top - box.height), box.width, box.height, color=(level,) * 3)
        )
    window = layout.window
    axes.add_patch(
        Rectangle(
            (window.left, height - window.top - window.height), window.width, window.height,
            fill=False, ec=SOFT, ls="--", lw=1,
        )
    )  # fmt: skip
    bottom = height - window.top - window.height
    sheet = np.array([[40, bottom + 18], [170, bottom + 16], [171, bottom + 186], [39, bottom + 184]])
    axes.add_patch(Polygon(sheet, color="#f3ead7", ec=SOFT, lw=0.8))
    middle = sheet.mean(axis=0)
    _label(axes, (middle[0], middle[1]), "字放這裡", "the writing", ha="center")
    x, y = layout.ball
    axes.add_patch(Circle((x, height - y), 9.5, color="#9aa0a6", ec=INK, lw=0.8))
    centre = np.array([width / 2, height / 2])
    for k, angle in enumerate(np.radians(np.arange(0, 360, 60) + 20)):
        at = centre + 235 * np.array([np.cos(angle), np.sin(angle)])
        _lamp(axes, *at)
        axes.text(at[0], at[1], str(k + 1), fontsize=7, color="white", ha="center", va="center", zorder=6)
    turn = np.radians(np.linspace(30, 66, 30))
    axes.plot(centre[0] + 275 * np.cos(turn), centre[1] + 275 * np.sin(turn), color=LAMP, lw=1.2)
    _label(axes, (centre[0] + 245, centre[1] + 255), "每處拍一張", "one photograph each", ha="center")
    axes.set_xlim(-185, 440)
    axes.set_ylim(-115, 425)


def main() -> None:
    """Draw both halves beside each other."""
    font = find_chinese_font()
    if font is not None:
        font_manager.fontManager.addfont(font)
        name = font_manager.FontProperties(fname=str(font)).get_name()
        plt.rcParams["font.family"] = [name, "DejaVu Sans"]
    figure, (left, right) = plt.subplots(1, 2, figsize=(11, 4.6), width_ratios=(1.25, 1))
    draw_side(left)
    draw_above(right)
    for axes in (left, right):
        axes.set_aspect("equal")
        axes.axis("off")
    figure.tight_layout(pad=0.3)
    OUT.parent.mkdir(exist_ok=True)
    figure.savefig(OUT, dpi=110)
    print(OUT)


if __name__ == "__main__":
    main()
