"""page: a photographed or scanned page into its characters; photographs of our own sheets into marks."""

from __future__ import annotations

import json
import time
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from rumu.cli.options import AsJson, check_writable
from rumu.cli.sheet import are_sheets, mark_sheet_photos
from rumu.cli.terminal import Outcome, counted, print_outcome, working

if TYPE_CHECKING:
    from rumu.pages.page import Page

_MARKER = "page.json"
_LONGEST_FILE = 10**6  # bytes of a text: the longest page holds a few thousand characters


@print_outcome
def page(
    *,
    photos: Annotated[
        list[Path],
        typer.Argument(
            metavar="PHOTO...",
            help="Photograph or scan of a page: a print, a scroll, a rubbing. Or of sheets that `rumu sheet` "
            "printed: one, many, a folder, a zip, a PDF.",
        ),
    ],
    out: Annotated[
        Path, typer.Option("-o", "--out", help="Folder to write; an earlier result there is replaced.")
    ],
    text: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="What is written on it: a text file, with or without line breaks."),
    ] = None,
    reference: Annotated[
        list[str] | None,
        typer.Option(
            metavar="MASTERS",
            help="Masters whose characters may be on it: pictures, a folder, a labels.csv, a script, or the "
            "id of a work or collection; may be given repeatedly.",
        ),
    ] = None,
    jobs: Annotated[
        int | None, typer.Option(min=1, help="Of sheets: processes (default: all cores).")
    ] = None,
    dask: Annotated[
        str | None,
        typer.Option(
            metavar="ADDRESS", help="Of sheets: mark on a Dask cluster (tcp://HOST:8786, or local)."
        ),
    ] = None,
    language: Annotated[Literal["zh", "en"], typer.Option(help="Of sheets: language of the PDFs.")] = "zh",
    as_json: AsJson = False,
) -> Outcome:
    """A page -> its columns and characters, as a report, JSON, PAGE-XML, hOCR; our own sheets -> marks."""
    if are_sheets(photos):
        if text is not None or reference:
            raise typer.BadParameter(
                "--text and --reference cannot go with sheets, whose code says what is written"
            )
        return mark_sheet_photos(photos, out, jobs=jobs, dask=dask, language=language)
    if text is not None and reference:
        raise typer.BadParameter("expected --text or --reference, got both")
    (photo,) = photos
    return _read_one(photo, out, text=text, reference=reference or ())


def _read_one(photo: Path, out: Path, *, text: Path | None, reference: Sequence[str]) -> Outcome:
    """The characters of one page."""
    from rumu.gallery.page_reading import read_page
    from rumu.outputs import whole_folder

    check_writable(whole_folder(out, marker=_MARKER))
    words = None if text is None else _read_text(text)
    started = time.perf_counter()
    with working("Reading the page"):
        found = read_page(photo, text=words, reference=reference)
        seconds = time.perf_counter() - started
        _write(found, out, title=photo.stem)
    facts = {"photo": photo, "out": out, "seconds": round(seconds, 3), **found.as_json()}
    if not found.characters:
        nothing = f"{photo}: no columns of writing were found on this picture (這張圖上找不到成行的字)"
        return Outcome({**facts, "error": nothing}, f"  {out / 'report.html'}", refused=nothing)
    return Outcome(facts, _describe(found, photo, out, seconds))


def _read_text(path: Path) -> str:
    from rumu.encodings import decode_text
    from rumu.errors import RumuError
    from rumu.inputs import read_file

    content = read_file(path, error_type=RumuError, expected="a text file", most=_LONGEST_FILE)
    decoded = decode_text(content)
    if decoded is None:
        raise RumuError("expected a text file", name=path, zh="需要文字檔。")
    return decoded.text


def _write(found: Page, out: Path, *, title: str) -> None:
    """The folder of a page: its picture, what was found on it in three formats, and a report."""
    from PIL import Image

    import rumu
    from rumu.outputs import whole_folder
    from rumu.pages.exports import hocr, page_xml
    from rumu.report.pages import characters_page

    creator = f"rumu {rumu.__version__}"
    with whole_folder(out, marker=_MARKER) as folder:
        Image.fromarray(found.picture).save(folder / "page.png", compress_level=3)
        texts = {
            _MARKER: json.dumps(found.as_json(), ensure_ascii=False, indent=1) + "\n",
            "page.xml": page_xml(found, picture_name="page.png", creator=creator),
            "page.hocr": hocr(found, picture_name="page.png", creator=creator),
            "page.txt": found.text + "\n",
            "report.html": characters_page(found, title=title),
        }
        for name, content in texts.items():
            (folder / name).write_text(content, encoding="utf-8")


def _describe(found: Page, photo: Path, out: Path, seconds: float) -> str:
    columns = {(one.register, one.column) for one in found.characters}
    named = sum(one.character is not None for one in found.characters)
    small = sum(one.small is not None for one in found.characters)
    lines = [
        f"{photo}: {counted(len(found.characters), 'character')} in "
        f"{counted(len(columns), 'column' if found.direction == 'vertical' else 'row')}, {seconds:.1f} s",
        f"  named: {named}" + (f"; in double rows: {small}" if small else ""),
        f"  {out / 'report.html'}",
    ]
    return "\n".join(lines)
