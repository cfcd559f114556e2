"""Charts and sheets of pictures, as PNG and SVG files.

Words in them are English and plain ASCII, since a machine need not have a Chinese font; captions in both
languages are on the page.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from rumu.report.pictures import PAPER
from rumu_lab.experiments.findings import method_name

INK, SOFT, ACCENT, CALM = "#26231f", "#8a8175", "#a5321f", "#3d6470"
_PAPER = "#" + "".join(f"{v:02x}" for v in PAPER)


def _pyplot() -> Any:
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    pyplot.rcParams.update(
        {
            "font.size": 9,
            "axes.spines.top": False,
            "axes.spines.right": False,
            "axes.edgecolor": SOFT,
            "axes.labelcolor": INK,
            "xtick.color": INK,
            "ytick.color": INK,
            "figure.facecolor": _PAPER,
            "axes.facecolor": _PAPER,
            "savefig.facecolor": _PAPER,
            "svg.fonttype": "none",
            "svg.hashsalt": "rumu",
        }
    )
    return pyplot


def _save(figure: Any, path: Path) -> list[Path]:
    """PNG and SVG, each whole or not at all."""
    from rumu.outputs import whole_file

    written = []
    for suffix, metadata in ((".png", None), (".svg", {"Date": None})):
        target = path.with_suffix(suffix)
        with whole_file(target) as part:
            figure.savefig(part, dpi=150, bbox_inches="tight", metadata=metadata)
        written.append(target)
    _pyplot().close(figure)
    return written


def sheet(
    rows: Sequence[Sequence[np.ndarray]],
    path: Path,
    *,
    above: Sequence[str],
    beside: Sequence[str] | None = None,
) -> None:
    """Pictures in rows and columns, with words above the columns and beside the rows; one PNG."""
    from rumu.outputs import whole_file

    plt = _pyplot()
    heights = [max(picture.shape[0] / picture.shape[1] for picture in row) for row in rows]
    figure, axes = plt.subplots(
        len(rows),
        len(above),
        figsize=(2.1 * len(above), 2.1 * sum(heights) + 0.25),
        height_ratios=heights,
        squeeze=False,
        layout="constrained",
    )
    for r, row in enumerate(rows):
        for c, picture in enumerate(row):
            ax = axes[r, c]
            ax.imshow(picture, cmap="gray", vmin=0, vmax=255, interpolation="lanczos")
            ax.set_anchor("N")
            ax.set_xticks([])
            ax.set_yticks([])
            for spine in ax.spines.values():
                spine.set_visible(False)
            if r == 0:
                ax.set_title(above[c], fontsize=9)
            if c == 0 and beside is not None:
                ax.set_ylabel(beside[r], fontsize=9)
    with whole_file(path) as part:
        figure.savefig(part, dpi=150)
    plt.close(figure)


def error_bars(
    rows: Sequence[Mapping[str, Any]], path: Path, *, ours: Sequence[str], label: str
) -> list[Path]:
    """Mean absolute error of each method (bar), its 95 % interval (thick) and the deviation (thin)."""
    plt = _pyplot()
    figure, ax = plt.subplots(figsize=(6.6, 0.3 * len(rows) + 0.9))
    for y, row in enumerate(rows):
        colour = ACCENT if row["method"] in ours else CALM
        ax.barh(y, row["mae"], color=colour, alpha=0.75, height=0.66)
        ax.plot([max(row["mae"] - row["sd"], 0), row["mae"] + row["sd"]], [y, y], color=SOFT, lw=0.8)
        ax.plot([row["mae_low"], row["mae_high"]], [y, y], color=INK, lw=2.2)
        ax.text(0.3, y, f"{row['mae']:.1f} ± {row['sd']:.1f}", va="center", fontsize=7.5, color="white")
    _name_rows(ax, [method_name(row["method"]) for row in rows])
    ax.set_xlabel(label)
    return _save(figure, path)


def dots(
    rows: Sequence[Mapping[str, Any]],
    path: Path,
    *,
    name: str,
    keys: tuple[str, str, str],
    label: str,
    ours: Sequence[str] = (),
    zero: bool = False,
) -> list[Path]:
    """A value with its interval for each row, keys: (value, low, high) in the rows; zero: a line at 0."""
    plt = _pyplot()
    value, low, high = keys
    shown = [row for row in rows if row.get(value) is not None]
    figure, ax = plt.subplots(figsize=(6.6, 0.3 * len(shown) + 0.9))
    if zero:
        ax.axvline(0, color=SOFT, lw=0.8)
    for y, row in enumerate(shown):
        colour = ACCENT if row[name] in ours else CALM
        if row.get(low) is not None:
            ax.plot([row[low], row[high]], [y, y], color=colour, lw=1.6)
        ax.plot([row[value]], [y], "o", color=colour, ms=5)
    _name_rows(ax, [method_name(row[name]) for row in shown])
    ax.set_xlabel(label)
    return _save(figure, path)


def lines(
    curves: Mapping[str, Sequence[float]], path: Path, *, ours: str, x_label: str, y_label: str
) -> list[Path]:
    """Several curves over 0, 1, 2, ...; ours is drawn thick."""
    plt = _pyplot()
    figure, ax = plt.subplots(figsize=(5.2, 3.2))
    styles = ["-", "--", ":", "-."]
    for k, (name, values) in enumerate(curves.items()):
        is_ours = name == ours
        ax.plot(
            range(len(values)),
            values,
            styles[0] if is_ours else styles[k % len(styles)],
            color=ACCENT if is_ours else SOFT,
            lw=2.2 if is_ours else 1.2,
            marker="o" if is_ours else None,
            label=name,
        )
    ax.set_xlabel(x_label)
    ax.set_ylabel(y_label)
    ax.set_ylim(0, 102)
    ax.legend(frameon=False)
    return _save(figure, path)


def bars(
    rows: Sequence[Mapping[str, Any]],
    path: Path,
    *,
    name: str,
    value: str,
    label: str,
    ours: Sequence[str] = (),
    limit: float | None = None,
    logarithmic: bool = False,
) -> list[Path]:
    """One bar a row; limit: a line that was wanted."""
    plt = _pyplot()
    shown = [row for row in rows if row.get(value) is not None]
    figure, ax = plt.subplots(figsize=(6.6, 0.3 * len(shown) + 0.9))
    for y, row in enumerate(shown):
        ax.barh(y, row[value], color=ACCENT if row[name] in ours else CALM, alpha=0.75, height=0.66)
    if limit is not None:
        ax.axvline(limit, color=INK, lw=1.0, ls="--")
    if logarithmic:
        ax.set_xscale("log")
    _name_rows(ax, [method_name(row[name]) for row in shown])
    ax.set_xlabel(label)
    return _save(figure, path)


def _name_rows(ax: Any, names: Sequence[str]) -> None:
    ax.set_yticks(range(len(names)), names)
    ax.invert_yaxis()
    ax.tick_params(axis="y", length=0)
