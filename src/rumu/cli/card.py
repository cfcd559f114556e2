"""card: the card that makes a capture of a phone's photographs, to print."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

import typer

from rumu.cli.options import AsJson
from rumu.cli.terminal import Outcome, print_outcome


@print_outcome
def card(
    *,
    out: Annotated[Path, typer.Option("-o", "--out", help="PDF to write.")],
    paper: Annotated[Literal["A4", "Letter"], typer.Option(help="The paper.")] = "A4",
    as_json: AsJson = False,
) -> Outcome:
    """The capture card: photographs of it with a lamp in three or more places go to `reconstruct --card`."""
    from rumu.card.drawing import card_pdf
    from rumu.card.layout import CardLayout
    from rumu.outputs import whole_file

    if out.suffix.lower() != ".pdf":
        raise typer.BadParameter(f"expected a name that ends in .pdf, got {out}", param_hint="'-o'")
    data = card_pdf(paper)
    with whole_file(out) as part:
        part.write_bytes(data)
    window = CardLayout(paper).window
    facts = {"out": out, "paper": paper, "window_mm": [window.width, window.height]}
    text = (
        f"{out}: {paper}, a window of {window.width:.0f} x {window.height:.0f} mm for the writing\n"
        "  print it at 100%, without scaling; its line must measure 100 mm"
    )
    return Outcome(facts, text)
