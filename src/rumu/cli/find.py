"""find: which master a copy is a copy of."""

from __future__ import annotations

import time
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from rumu.cli.options import AsJson
from rumu.cli.terminal import Outcome, bar, print_outcome

if TYPE_CHECKING:
    from rumu.gallery.search import SearchResult


@print_outcome
def find(
    copy: Annotated[Path, typer.Argument(metavar="COPY", help="The copy: an image or a surface folder.")],
    masters: Annotated[
        list[Path],
        typer.Option(metavar="MASTERS", help="Folder of pictures, or a labels.csv; may be given repeatedly."),
    ],
    top: Annotated[int, typer.Option(min=1, help="How many masters to name.")] = 10,
    as_json: AsJson = False,
) -> Outcome:
    """The masters that a copy is most like, best first."""
    from rumu.executors import cores
    from rumu.gallery.search import find as find_match
    from rumu.gallery.search import index_masters

    with bar("Describing masters") as advance:
        index = index_masters(masters, jobs=cores(), progress=advance)
    started = time.perf_counter()
    matches = find_match(copy, index, top=top)
    seconds = time.perf_counter() - started
    facts = {
        "copy": copy,
        "masters": len(index.masters),
        "left_out": [{"file": master.path, "reason": reason} for master, reason in index.left_out],
        "matches": [
            {"file": match.master.path}
            | {name: getattr(match.master, name) for name in ("character", "hand", "work")}
            | {"likeness": match.likeness}
            for match in matches
        ],
        "seconds": round(seconds, 3),
    }
    left_out = f" ({len(index.left_out)} more hold no writing)" if index.left_out else ""
    heading = f"{copy}, among {len(index.masters)} masters{left_out}, {seconds:.2f} s"
    return Outcome(facts, "\n".join([heading, *map(_line, matches)]))


def _line(match: SearchResult) -> str:
    master = match.master
    words = [word for word in (master.character, master.hand, master.work) if word]
    return f"  {match.likeness:.2f}  {' '.join(words)}  {master.path}".replace("    ", "  ")
