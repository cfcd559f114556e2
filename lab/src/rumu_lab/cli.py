"""experiments: what the marks are worth, measured so that anyone can measure it again."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

from rumu.cli.options import AsJson
from rumu.cli.terminal import Outcome, bar, print_outcome

if TYPE_CHECKING:
    from rumu_lab.experiments.run_settings import RunSettings

Name = Literal[
    "all",
    "runtime",
    "pictures",
    "e3c",
    "nested",
    "human",
    "levels",
    "severities",
    "nuisance",
    "ablation",
    "remarks",
    "gaming",
    "identity",
    "development",
    "validation",
    "locked",
]


def register(app: typer.Typer) -> None:
    commands = typer.Typer(
        help="What the marks are worth, measured.", no_args_is_help=True, rich_markup_mode=None
    )
    commands.command("run")(run)
    commands.command("report")(report)
    app.add_typer(commands, name="experiments")


@print_outcome
def run(
    *,
    name: Annotated[Name, typer.Argument(help="Which experiment; 'all' for every one of the report.")],
    data: Annotated[
        Path, typer.Option(envvar="RUMU_DATA", help="Folder of the data sets (or RUMU_DATA).")
    ] = Path("../shared/data"),
    out: Annotated[
        Path | None, typer.Option("-o", "--out", help="Folder for results, tables and figures.")
    ] = None,
    quick: Annotated[
        bool, typer.Option("--quick", help="A small subset, to see that it runs; no result.")
    ] = False,
    seed: Annotated[
        str | None, typer.Option(help="With 'locked': the seed that opens the locked test.")
    ] = None,
    log: Annotated[
        Path, typer.Option(help="With 'locked': the log that every opening is appended to.")
    ] = Path("docs/locked-test.jsonl"),
    as_json: AsJson = False,
) -> Outcome:
    """Run one experiment, or all that the report is made of, and print the figures."""
    from rumu_lab.experiments.run_settings import RunSettings

    if name == "all" and out is None:
        raise typer.BadParameter("'all' needs a folder for its results: -o OUT")
    if (name == "locked") != (seed is not None):
        raise typer.BadParameter("'locked' needs --seed, and nothing else takes it")
    settings = RunSettings(data, out, quick)
    if name == "all":
        return _run_all(settings)
    return _run_one(name, settings, {} if seed is None else {"seed": seed, "log": log})


@print_outcome
def report(
    out: Annotated[Path, typer.Argument(help="Folder that 'experiments run -o' wrote to.")],
    as_json: AsJson = False,
) -> Outcome:
    """Make the figures and one HTML page of the results that a folder holds."""
    from rumu_lab.experiments.html_report import write_report

    made = write_report(out)
    facts: dict[str, Any] = {
        "report": made.page,
        "figures": made.figures,
        "missing": made.missing,
        "warnings": [warning.en for warning in made.warnings],
    }
    lines = [str(made.page), *facts["warnings"]]
    if made.missing:
        lines.append(f"missing: {', '.join(made.missing)} (rumu experiments run NAME -o {out})")
    return Outcome(facts, "\n".join(lines))


def _run_one(name: str, settings: RunSettings, more: dict[str, Any]) -> Outcome:
    from dataclasses import replace

    from rumu.errors import CalibrationError
    from rumu_lab.experiments.runner import find, run_one, why_not

    reason = why_not(find(name), settings)
    if reason is not None:
        raise CalibrationError(f"{name}: {reason}")
    with bar(f"Running {name}") as advance:
        found = run_one(name, replace(settings, progress=advance), **more)
    return Outcome(dict(found.facts), found.text())


def _run_all(settings: RunSettings) -> Outcome:
    import contextlib
    import sys

    from rumu_lab.experiments.runner import run_all

    ended, lines = {}, []
    with contextlib.ExitStack() as bars:

        def announce(name: str) -> Any:
            bars.close()
            return bars.enter_context(bar(f"Running {name}"))

        for one in run_all(settings, announce=announce):
            bars.close()
            line = (
                f"{one.name}: {one.status}, {one.seconds:.0f} s"
                if one.why is None
                else (f"{one.name}: {one.status}, {one.why}")
            )
            print(line, file=sys.stderr, flush=True)
            ended[one.name] = {"status": one.status, "seconds": one.seconds, "why": one.why}
            lines.append(line)
    failed = [name for name, how in ended.items() if how["status"] == "failed"]
    refused = f"{', '.join(failed)} failed; the rest is kept in {settings.out}" if failed else None
    closing = f"rumu experiments report {settings.out} makes the page."
    return Outcome({"experiments": ended, "out": settings.out}, "\n".join([*lines, closing]), refused)
