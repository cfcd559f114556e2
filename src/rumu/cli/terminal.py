"""What a command shows: progress while it works, then its outcome, and with which exit code it ends.

Progress goes to stderr, and only when a person is looking at it.
A command returns an Outcome or raises; `print_outcome` turns either into output and an exit code, so that no
traceback reaches a person and `--json` is always one object on stdout and nothing else there.
"""

from __future__ import annotations

import contextlib
import dataclasses
import functools
import json
import math
import os
import signal
import sys
import time
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NoReturn, ParamSpec

import typer

from rumu.cli.interrupt import INTERRUPTED
from rumu.cli.run_time import RunTime, Stage
from rumu.errors import DiskFull, RumuError
from rumu.outputs import is_full

P = ParamSpec("P")

FINE, FAILED, WRONG_USAGE = 0, 1, 2
"""Exit codes of a command that came to its end, and of one that could not begin."""
Advance = Callable[[int, int], None]
"""Called with (done, total)."""


@dataclass(frozen=True, slots=True)
class Outcome:
    """What a command found.

    facts: what `--json` prints. text: what a person reads, a string or something rich can print.
    refused: one line for stderr when the command did its work and the answer is no (exit code 1).
    """

    facts: Mapping[str, Any]
    text: Any
    refused: str | None = None


def print_outcome(command: Callable[P, Outcome]) -> Callable[P, None]:
    """Print what `command` returns, or one line about why it failed, and end with the right code."""

    @functools.wraps(command)
    def run(*args: P.args, **kwargs: P.kwargs) -> None:
        as_json = bool(kwargs.get("as_json"))
        _sweep_killed()
        try:
            outcome = command(*args, **kwargs)
        except DiskFull as error:
            _fail(f"{error}  {error.zh}", as_json=as_json)
        except RumuError as error:
            _fail(str(error), as_json=as_json)
        except KeyboardInterrupt:
            raise SystemExit(INTERRUPTED) from None
        except (typer.BadParameter, typer.Exit):
            raise
        except Exception as error:
            if is_full(error):
                full = DiskFull(getattr(error, "filename", None) or "output")
                _fail(f"{full}  {full.zh}", as_json=as_json)
            _fail(_unexpected(error), as_json=as_json)
        with _quiet_pipe():
            _print(outcome, as_json=as_json)
        if outcome.refused is not None:
            _complain(outcome.refused)
            raise SystemExit(FAILED)

    return run


def _sweep_killed() -> None:
    """Delete temporary folders that killed commands left, in the system's folder and in the person's data."""
    from rumu.homes import user_home
    from rumu.workspaces import sweep

    sweep()
    with contextlib.suppress(RumuError, OSError):  # said by the command that needs the folder
        home = user_home()
        for folder in (home, *(entry for entry in home.iterdir() if entry.is_dir())):
            sweep(folder)


def plain(value: Any) -> Any:
    """`value` as JSON can say it: dataclasses as objects, arrays as lists, NaN and infinity as null."""
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        return {f.name: plain(getattr(value, f.name)) for f in dataclasses.fields(value)}
    if isinstance(value, Mapping):
        return {str(key): plain(item) for key, item in value.items()}
    if hasattr(value, "tolist"):  # numpy arrays and scalars, without importing numpy
        return plain(value.tolist())
    if isinstance(value, (list, tuple)):
        return [plain(item) for item in value]
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    return str(value) if isinstance(value, Path) else value


def counted(number: int, thing: str) -> str:
    """A number of things, whose plural ends in s: '1 page', '2 pages'."""
    return f"{number} {thing}" if number == 1 else f"{number} {thing}s"


def speak_plainly() -> None:
    """Warnings as one line; a terminal that lacks a character gets its escape instead of a crash."""
    for stream in (sys.stdout, sys.stderr):
        with contextlib.suppress(AttributeError, ValueError):
            stream.reconfigure(errors="backslashreplace")  # type: ignore[union-attr]
    with contextlib.suppress(ValueError):  # only the main thread may
        signal.signal(signal.SIGTERM, lambda number, frame: sys.exit(128 + number))
    if not _debugging():
        # What rumu warns about is a UserWarning; the rest is for programmers.
        warnings.simplefilter("ignore")
        warnings.simplefilter("default", UserWarning)
        warnings.showwarning = lambda message, *_, **__: _complain(f"warning: {message}")


@contextlib.contextmanager
def _quiet_pipe() -> Iterator[None]:
    """`rumu ... | head` ends quietly when the reader leaves."""
    try:
        yield
    except OSError as error:
        # Python flushes stdout once more at exit; it must find a file that takes it.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        if isinstance(error, BrokenPipeError):
            raise SystemExit(FINE) from None
        _complain(f"the output cannot be written ({error.strerror or error})")
        raise SystemExit(FAILED) from None


def _print(outcome: Outcome, *, as_json: bool) -> None:
    if as_json:
        print(json.dumps(plain(outcome.facts), ensure_ascii=False, allow_nan=False))
    elif isinstance(outcome.text, str):
        print(outcome.text)
    else:
        from rich.console import Console

        Console(soft_wrap=not sys.stdout.isatty()).print(outcome.text)
    sys.stdout.flush()


def _fail(message: str, *, as_json: bool) -> NoReturn:
    if as_json:
        print(json.dumps({"error": " ".join(message.split())}, ensure_ascii=False), flush=True)
    _complain(message)
    raise SystemExit(FAILED) from None


def tell_wrong_usage(error: Any, *, as_json: bool) -> int:
    """Print what is wrong with a command line, as an object too where one was asked for; the exit code."""
    message = error.message.replace("Value error, ", "").replace("Input should be", "expected")
    for one in getattr(error.__cause__, "errors", list)()[:1]:  # of pydantic, which does not say what came
        message += "" if repr(one["input"]) in message else f", got {one['input']!r}"
    error.message = message
    if as_json:
        print(json.dumps({"error": " ".join(error.format_message().split())}, ensure_ascii=False), flush=True)
    error.show()
    return WRONG_USAGE


def _unexpected(error: Exception) -> str:
    if _debugging():
        import traceback

        traceback.print_exception(error, file=sys.stderr)
    hint = "" if _debugging() else " (RUMU_DEBUG=1 shows where)"
    if isinstance(error, OSError) and error.strerror:
        return f"{error.filename or 'file'}: {error.strerror}{hint}"
    return f"unexpected {type(error).__name__}: {error}{hint}"


def _complain(message: str) -> None:
    """Print a message as one line on stderr."""
    print(f"rumu: {' '.join(message.split())}", file=sys.stderr)


def _debugging() -> bool:
    return os.environ.get("RUMU_DEBUG", "") not in ("", "0")


@contextlib.contextmanager
def bar(label: str) -> Iterator[Advance]:
    """Yield a function of (done, total) that moves a bar; silent when stderr is no terminal."""
    if not sys.stderr.isatty():
        yield lambda done, total: None
        return
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    with Progress(*columns, console=Console(stderr=True), transient=True) as progress:
        task = progress.add_task(label, total=None)
        yield lambda done, total: progress.update(task, completed=done, total=total)


@contextlib.contextmanager
def stages(planned: Sequence[Stage] = ()) -> Iterator[Callable[[str, int, int], None]]:
    """Yield a function of (what, done, total): bars that say what is done, how far, and for how long yet.

    planned: the stages that are to come. Each `what` begins a bar of its own, below those that are full;
    above them all one says how long the whole will take. Silent when stderr is no terminal.
    """
    if not sys.stderr.isatty():
        yield lambda what, done, total: None
        return
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

    columns = (TextColumn("{task.description}"), BarColumn(), TextColumn("{task.fields[so_far]}"))
    console, whole = Console(stderr=True), RunTime(planned)
    with Progress(*columns, TimeElapsedColumn(), console=console, transient=True) as progress:
        altogether = progress.add_task("Altogether", total=None, so_far="")
        tasks: dict[str, Any] = {}

        def show(what: str, done: int, total: int) -> None:
            left = whole.left(what, done, total)
            if left is not None:
                so_far = _Until(time.monotonic() + left)
                progress.update(
                    altogether, completed=whole.elapsed, total=whole.elapsed + left, so_far=so_far
                )
            if what not in tasks:
                for task in tasks.values():
                    progress.update(task, completed=progress.tasks[task].total)
                    progress.stop_task(task)
                tasks[what] = progress.add_task(what, total=total, so_far="")
            counted = f"{done}/{total}" if total > 1 else ""
            progress.update(tasks[what], completed=done, total=total, so_far=counted)

        yield show


@dataclass(frozen=True, slots=True)
class _Until:
    """How long it is until a time of `time.monotonic`, whenever it is shown."""

    end: float

    def __str__(self) -> str:
        return f"about {clock_time(max(0.0, self.end - time.monotonic()))} left"


def clock_time(seconds: float) -> str:
    """A time as a person reads it: '1:05' of minutes and seconds, '2:01:05' with hours."""
    minutes, rest = divmod(round(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours}:{minutes:02d}:{rest:02d}" if hours else f"{minutes}:{rest:02d}"


@contextlib.contextmanager
def working(label: str) -> Iterator[None]:
    """A turning sign beside `label` while one long step runs; silent when stderr is no terminal."""
    if not sys.stderr.isatty():
        yield
        return
    from rich.console import Console

    with Console(stderr=True).status(label):
        yield
