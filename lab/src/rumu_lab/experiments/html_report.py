"""OUT/report.html and its figures, made of what OUT holds; it says what is missing, and needs no network."""

from __future__ import annotations

import base64
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rumu.errors import OutputError
from rumu.values import Bilingual
from rumu_lab.experiments import figures
from rumu_lab.experiments.findings import Findings
from rumu_lab.experiments.protocol import declared
from rumu_lab.experiments.results import findings_from, read_result
from rumu_lab.experiments.runner import EXPERIMENTS

PAPER_SAYS: tuple[tuple[str, str], ...] = (
    ("level accuracy, over the five scripts", "83.33 % and up (5 of 6, or 20 of 24; N is not given)"),
    ("absolute score error of its own method", "5.7 ± 1.78 (a standard deviation; N and test are not given)"),
)
"""What the paper reports, quoted apart; never in one column with ours."""


@dataclass(frozen=True, slots=True)
class Figure:
    """One figure of the page. files: relative to OUT; the first is shown."""

    files: tuple[str, ...]
    caption: Bilingual


@dataclass(frozen=True, slots=True)
class WrittenReport:
    """What `write_report` made. missing: experiments that OUT does not hold."""

    page: Path
    figures: tuple[str, ...]
    missing: tuple[str, ...]
    warnings: tuple[Bilingual, ...]


def write_report(out: Path) -> WrittenReport:
    """Figures and page from the results under `out`. Raises OutputError when it holds none."""
    from rumu.outputs import whole_file

    found = {e.name: plain for e in EXPERIMENTS if (plain := read_result(e.name, out=out)) is not None}
    if not found:
        raise OutputError(f"{out}: expected results of 'rumu experiments run all -o {out}', found none")
    findings = {name: findings_from(plain) for name, plain in found.items()}
    drawn = {name: draw(found, out) for name, found in findings.items()}
    missing = tuple(e.name for e in EXPERIMENTS if e.name not in found and not e.alone)
    warnings = warnings_of(found)
    page = out / "report.html"
    with whole_file(page) as part:
        part.write_text(_render(out, found, findings, drawn, missing=missing, warnings=warnings), "utf-8")
    return WrittenReport(
        page, tuple(f for fs in drawn.values() for one in fs for f in one.files), missing, warnings
    )


def draw(findings: Findings, out: Path) -> tuple[Figure, ...]:
    """The figures of one experiment: those that it wrote itself, and charts written under OUT/figures."""
    made = [
        Figure((f["file"],), Bilingual(f["zh"], f["en"]))
        for f in findings.facts.get("figures", ())
        if (out / f["file"]).is_file()
    ]
    painter = _PAINTERS.get(findings.name)
    return (*made, *(painter(findings.facts, out) if painter else ()))


def warnings_of(found: Mapping[str, Mapping[str, Any]]) -> tuple[Bilingual, ...]:
    """What a reader must know before any figure: quick runs, several versions of the code or the protocol."""
    warnings = []
    if any(plain["quick"] for plain in found.values()):
        warnings.append(
            Bilingual(
                "這是小樣快跑，數字不成結果。",
                "This is a quick run on a small subset: its figures are no result.",
            )
        )
    if any(plain["protocol_sha256"] != declared().sha256 for plain in found.values()):
        warnings.append(
            Bilingual(
                "有的結果出自另一份方案。",
                "Some results were made under a protocol other than the present one.",
            )
        )
    if len({plain["code_sha256"] for plain in found.values()}) > 1:
        warnings.append(
            Bilingual(
                "各項結果不是同一版程序所得。", "Not all results were made by the same version of the code."
            )
        )
    return tuple(warnings)


def _chart(paths: Sequence[Path], out: Path, zh: str, en: str) -> Figure:
    return Figure(tuple(p.relative_to(out).as_posix() for p in paths), Bilingual(zh, en))


def _paint_human(facts: Mapping[str, Any], out: Path) -> tuple[Figure, ...]:
    from rumu_lab.experiments.human_marks import OWN_SCALE, SHARED

    rows, ours = facts["methods"], (OWN_SCALE, SHARED)
    error = figures.error_bars(
        rows, out / "figures/figure-7-human", ours=ours, label="mean absolute error, points (human marks)"
    )
    ranks = figures.dots(
        sorted(rows, key=lambda row: -(row.get("within") or 0.0)),
        out / "figures/ranks-human",
        name="method",
        keys=("within", "within_low", "within_high"),
        label="Spearman with the panel, mean within a character",
        ours=ours,
    )
    span = "粗線為 95 % 區間，細線為一個標準差。"
    return (
        _chart(
            error,
            out,
            f"圖七（真人評分）：絕對誤差。{span}",
            "Figure 7 on human marks: absolute error. Thick line: 95 % interval of the mean; thin: one SD.",
        ),
        _chart(
            ranks, out, "同字等級相關，95 % 區間。", "Rank correlation within a character, 95 % intervals."
        ),
    )


def _paint_severities(facts: Mapping[str, Any], out: Path) -> tuple[Figure, ...]:
    from rumu_lab.experiments.severities import SHARED, SHIPPED

    error = figures.error_bars(
        facts["methods"],
        out / "figures/figure-7-severities",
        ours=(SHARED, SHIPPED),
        label="mean absolute error, points (declared severities)",
    )
    curves = {"rumu, as shipped": facts["marks_by_severity"]}
    curves |= {f"expected, {name}": list(scores) for name, scores in declared().expected_scores.items()}
    fall = figures.lines(
        curves,
        out / "figures/marks-by-severity",
        ours="rumu, as shipped",
        x_label="severity of one simulated fault",
        y_label="mark",
    )
    return (
        _chart(
            error,
            out,
            "圖七（模擬毛病）：與聲明程度的絕對誤差。",
            "Figure 7 on simulated severities: absolute error against the declared scale.",
        ),
        _chart(
            fall,
            out,
            "毛病漸重，分數漸低；虛線為三張聲明的程度表。",
            "Our mean mark as one fault grows, beside the three declared tables.",
        ),
    )


def _paint_levels(facts: Mapping[str, Any], out: Path) -> tuple[Figure, ...]:
    rows = [*facts["scripts"], *facts["human"]]
    chart = figures.dots(
        rows,
        out / "figures/table-1",
        name="where",
        keys=("accuracy", "low", "high"),
        label="levels that are right, %, with the exact 95 % interval",
        ours=[row["where"] for row in facts["scripts"]],
    )
    return (_chart(chart, out, "表一的正確率與精確區間。", "Table 1 as a chart, with exact intervals."),)


def _paint_nuisance(facts: Mapping[str, Any], out: Path) -> tuple[Figure, ...]:
    chart = figures.bars(
        facts["methods"],
        out / "figures/nuisance",
        name="method",
        value="ratio",
        label="drift / fall for one step of severity (dashed: what was wanted)",
        ours=("rumu",),
        limit=facts["wanted"],
    )
    return (_chart(chart, out, "照片干擾下的漂移。", "Drift under nuisances of the photograph."),)


def _paint_runtime(facts: Mapping[str, Any], out: Path) -> tuple[Figure, ...]:
    chart = figures.bars(
        facts["methods"],
        out / "figures/runtime",
        name="method",
        value="median",
        label="milliseconds for a pair (logarithmic)",
        ours=("rumu",),
        logarithmic=True,
    )
    return (_chart(chart, out, "每對所需時間。", "Time for a pair."),)


def _paint_ablation(facts: Mapping[str, Any], out: Path) -> tuple[Figure, ...]:
    chart = figures.dots(
        facts["gains"],
        out / "figures/ablation",
        name="what",
        keys=("gain", "low", "high"),
        label="gain in mean Spearman within a character, 95 % interval",
        zero=True,
    )
    return (_chart(chart, out, "各部分的增益。", "What each part adds."),)


_PAINTERS: Mapping[str, Callable[[Mapping[str, Any], Path], tuple[Figure, ...]]] = {
    "human": _paint_human,
    "severities": _paint_severities,
    "development": _paint_severities,
    "validation": _paint_severities,
    "locked": _paint_severities,
    "levels": _paint_levels,
    "nuisance": _paint_nuisance,
    "runtime": _paint_runtime,
    "ablation": _paint_ablation,
}


def _render(
    out: Path,
    found: Mapping[str, Mapping[str, Any]],
    findings: Mapping[str, Findings],
    drawn: Mapping[str, Sequence[Figure]],
    *,
    missing: Sequence[str],
    warnings: Sequence[Bilingual],
) -> str:
    from jinja2 import ChoiceLoader, Environment, PackageLoader, StrictUndefined

    import rumu

    loader = ChoiceLoader([PackageLoader("rumu_lab.experiments"), PackageLoader("rumu.report")])
    environment = Environment(
        loader=loader, autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True
    )
    parts = [
        {
            "name": e.name,
            "title": e.title,
            "origin": found[e.name],
            "findings": findings[e.name],
            "figures": [
                (f"data:image/png;base64,{base64.b64encode((out / f.files[0]).read_bytes()).decode()}", f)
                for f in drawn[e.name]
            ],
        }
        for e in EXPERIMENTS
        if e.name in found
    ]
    titles = {e.name: e.title for e in EXPERIMENTS}
    return environment.get_template("experiments.html").render(
        title="rumu experiments",
        version=rumu.__version__,
        protocol=declared().sha256,
        parts=parts,
        missing=[(name, titles[name]) for name in missing],
        warnings=warnings,
        paper=PAPER_SAYS,
    )
