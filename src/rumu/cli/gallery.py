"""gallery list | show | add | export | remove: the works, and how they get in and out."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

from rumu.cli.options import AsJson
from rumu.cli.terminal import Outcome, bar, counted, print_outcome, working

if TYPE_CHECKING:
    from rumu.database.tables import Work
    from rumu.gallery.labels import SharedMetadata
    from rumu.gallery.metadata import CollectionMetadata, WorkMetadata
    from rumu.gallery.store import Gallery

Id = Annotated[str, typer.Argument(metavar="ID", help="Id of a work, as `gallery list` prints it.")]
Collection = Annotated[
    str | None, typer.Option(help="Id of the collection: letters, digits, hyphens; made when it is new.")
]
TitleZh = Annotated[str | None, typer.Option(help="Title in Chinese.")]
TitleEn = Annotated[str | None, typer.Option(help="Title in English.")]
ScriptOf = Annotated[str | None, typer.Option(help="Script: seal, clerical, regular, running or cursive.")]
Hand = Annotated[str | None, typer.Option(help="Who wrote it.")]
Dynasty = Annotated[str | None, typer.Option(help="Dynasty or period, such as Tang or 唐.")]
Material = Annotated[str | None, typer.Option(help="What it is: ink on paper, a rubbing.")]
Source = Annotated[str | None, typer.Option("--source", help="Where the pictures come from.")]
Licence = Annotated[str | None, typer.Option(help="Licence of the pictures; 'none stated' without it.")]
Attribution = Annotated[str | None, typer.Option(help="The credit to give.")]

_WIDE_SPACE = "\u3000"  # as wide as a Chinese character

app = typer.Typer(help="The works of the gallery.", no_args_is_help=True, rich_markup_mode=None)


@app.command("list")
@print_outcome
def list_works(
    *,
    script: Annotated[
        str | None, typer.Option(help="Only this script: seal, clerical, regular, running, cursive.")
    ] = None,
    character: Annotated[
        str | None, typer.Option(help="Only this character, in its traditional or simplified form.")
    ] = None,
    dynasty: Annotated[str | None, typer.Option(help="Only this dynasty, such as Tang.")] = None,
    hand: Annotated[str | None, typer.Option(help="Only this hand, by its name.")] = None,
    collection: Annotated[str | None, typer.Option(help="Only this collection, by its id.")] = None,
    within: Annotated[
        str | None, typer.Option(metavar="ID", help="The characters of this page or scroll, by its id.")
    ] = None,
    search: Annotated[
        str | None, typer.Option(help="Words in title, character, hand, collection, dynasty or script.")
    ] = None,
    offset: Annotated[int, typer.Option(min=0, help="How many works to pass over.")] = 0,
    limit: Annotated[int, typer.Option(min=0, help="How many works to print; 0 for all.")] = 60,
    as_json: AsJson = False,
) -> Outcome:
    """The works: id, character, script, hand; of a work of no single character its title, too."""
    from rumu.gallery.catalog import open_gallery, works

    page = works(
        open_gallery(), script=script, character=character, dynasty=dynasty, hand=hand,
        collection=collection, within=within, query=search, offset=offset, limit=limit or 1_000_000,
    )  # fmt: skip
    facts = {"total": page.total, "works": [_facts(work) for work in page.items]}
    if not page.items:
        return Outcome(facts, "no work matches")
    wide = max(len(work.id) for work in page.items)
    lines = [
        f"{w.id:<{wide}}  {w.character or _WIDE_SPACE}  {w.script:<9} {_both_names(w.hand_en, w.hand_zh)}"
        + ("" if w.character else f"; {_both_names(w.title_en, w.title_zh)}")
        for w in page.items
    ]
    if page.total > len(lines):
        lines.append(f"{len(lines)} of {page.total} works; --offset and --limit show others")
    return Outcome(facts, "\n".join(lines))


@app.command()
@print_outcome
def show(
    work_id: Id,
    out: Annotated[Path | None, typer.Option("-o", "--out", help="PNG to write the picture to.")] = None,
    as_json: AsJson = False,
) -> Outcome:
    """One work: whose hand, from where, under which licence; with -o its picture."""
    from rumu.gallery.catalog import open_gallery, work
    from rumu.gallery.whole_works import characters_within

    gallery = open_gallery()
    found = work(gallery, work_id)
    within = characters_within(gallery, work_id)
    if out is not None:
        _write_png(gallery.store.read(found.picture), out)
    lines = [
        f"{_both_names(found.title_zh, found.title_en)} ({found.id})",
        f"  hand: {_both_names(found.hand_zh, found.hand_en) or 'not known'}",
        f"  period: {_both_names(found.period_zh, found.period_en) or 'not known'}",
        f"  shows: {_both_names(found.material_zh, found.material_en) or 'not said'}",
        f"  height: {_HEIGHTS[found.height_source]}",
        f"  source: {found.source or 'not said'}",
        f"  licence: {found.licence}" + (f"; {found.attribution}" if found.attribution else ""),
        f"  picture: {out or gallery.store.path(found.picture) or found.picture}",
    ]
    if within:
        named = sum(one.character != "" for one in within)
        lines.append(
            f"  characters: {len(within)}, {named} of them named; `gallery list --within {found.id}`"
        )
    if found.parent_id is not None:
        lines.append(f"  stands on: {found.parent_id}")
    facts = {**_facts(found), "parent": found.parent_id, "place": found.place, "characters": len(within)}
    return Outcome({**facts, "file": out}, "\n".join(lines))


@app.command()
@print_outcome
def add(
    path: Annotated[
        Path | None,
        typer.Argument(metavar="[PATH]", help="An image, or a folder of photographs under lamps."),
    ] = None,
    *,
    font: Annotated[Path | None, typer.Option(help="A font (TTF, OTF, WOFF2) to draw from instead.")] = None,
    characters: Annotated[
        str | None, typer.Option(help="With --font: the characters to take, each a work.")
    ] = None,
    text: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE",
            help="Of a page or scroll: a text file with what is written; each character becomes a work.",
        ),
    ] = None,
    character: Annotated[str, typer.Option(help="The character that the picture shows.")] = "",
    title_zh: TitleZh = None,
    title_en: TitleEn = None,
    script: ScriptOf = None,
    hand: Hand = None,
    dynasty: Dynasty = None,
    material: Material = None,
    source: Source = None,
    licence: Licence = None,
    attribution: Attribution = None,
    collection: Collection = None,
    card: Annotated[
        bool,
        typer.Option("--card", help="Of a folder: the printed card in its photographs tells the lamps."),
    ] = False,
    spacing: Annotated[float | None, typer.Option(help="Of an image: millimetres per pixel.")] = None,
    method: Annotated[
        Literal["inflation", "density"], typer.Option(help="Of an image: how its height is computed.")
    ] = "inflation",
    as_json: AsJson = False,
) -> Outcome:
    """One work: an image, a page with its text, a capture folder (reconstructed), or characters of a font."""
    from rumu.gallery.catalog import open_gallery

    if (path is None) == (font is None) or (font is None) != (characters is None):
        raise typer.BadParameter("expected PATH, or --font with --characters")
    if text is not None and (path is None or path.is_dir() or character):
        raise typer.BadParameter("expected --text with the picture of a page, and without --character")
    if card and (path is None or not path.is_dir()):
        raise typer.BadParameter(f"expected --card with a folder of photographs, got {path or font}")
    if spacing is not None and not spacing > 0:
        raise typer.BadParameter(f"expected millimetres per pixel above 0, got {spacing}")
    shared = shared_metadata(
        title_zh=title_zh, title_en=title_en, script=script, hand=hand, dynasty=dynasty, material=material,
        source=source, licence=licence, attribution=attribution,
    )  # fmt: skip
    gallery = open_gallery()
    from rumu.gallery.add_work import add_capture, add_glyphs, add_picture, named_collection

    target, metadata = named_collection(collection), shared.work_metadata(character=character)
    if text is not None and path is not None:
        return _add_page(gallery, path, text, _with_title(metadata, path), target, spacing=spacing)
    if font is not None:
        added = add_glyphs(gallery, font, characters or "", metadata=metadata, collection=target)
    elif path is not None and path.is_dir():
        with working("Reconstructing"):
            metadata = _with_title(metadata, path)
            added = (add_capture(gallery, path, metadata=metadata, collection=target, card=card),)
    else:
        picture = Path(str(path))
        metadata = _with_title(metadata, picture)
        added = (
            add_picture(
                gallery, picture, metadata=metadata, collection=target, method=method, spacing=spacing
            ),
        )
    lines = [f"{one.id}: {'added' if one.new else 'was there already'}" for one in added]
    lines += [f"  note: {note.en}" for one in added for note in one.notes]
    works = [{"id": one.id, "new": one.new, "notes": [note._asdict() for note in one.notes]} for one in added]
    return Outcome({"works": works}, "\n".join(lines))


@app.command()
@print_outcome
def export(
    work_id: Annotated[
        str | None, typer.Argument(metavar="[ID]", help="With --html: the work to show.")
    ] = None,
    out: Annotated[
        Path | None, typer.Option("-o", "--out", help="Folder to write; with --html the page.")
    ] = None,
    collection: Annotated[
        list[str] | None, typer.Option(help="Only this collection, by its id; may be given repeatedly.")
    ] = None,
    html: Annotated[
        bool, typer.Option("--html", help="Write one page on which one work can be lit and turned.")
    ] = False,
    as_json: AsJson = False,
) -> Outcome:
    """The gallery, or collections of it, as a folder that `import` takes; with --html one work as a page."""
    if out is None:
        raise typer.BadParameter("expected a place to write to", param_hint="'-o'")
    if html != (work_id is not None) or (html and collection):
        raise typer.BadParameter("expected --html with the ID of one work, or neither")
    if work_id is not None:
        return _page(work_id, out)
    from rumu.gallery.archive import export_gallery
    from rumu.gallery.catalog import open_gallery

    with bar("Exporting") as advance:
        count = export_gallery(open_gallery(), out, collections=collection or None, progress=advance)
    return Outcome({"works": count, "out": out}, f"{counted(count, 'work')} in {out}")


@app.command()
@print_outcome
def remove(
    work_id: Annotated[str | None, typer.Argument(metavar="[ID]", help="The work to remove.")] = None,
    collection: Annotated[
        str | None, typer.Option(help="A whole collection to remove instead, by its id.")
    ] = None,
    as_json: AsJson = False,
) -> Outcome:
    """Remove a work, or a collection with all its works, and the attempts at them."""
    from rumu.gallery.catalog import delete_collection, delete_work, open_gallery

    if (work_id is None) == (collection is None):
        raise typer.BadParameter("expected the ID of a work, or --collection")
    gallery = open_gallery()
    if work_id is not None:
        delete_work(gallery, work_id)
        return Outcome({"removed": 1}, f"{work_id}: removed")
    count = delete_collection(gallery, str(collection))
    return Outcome({"removed": count}, f"{collection}: removed with {counted(count, 'work')}")


_HEIGHTS = {
    "photometric": "measured from photographs under several lamps",
    "inflation": "computed from the outline of the ink, not measured",
    "density": "computed from how dark the ink is, not measured",
}


def _add_page(
    gallery: Gallery,
    path: Path,
    text: Path,
    metadata: WorkMetadata,
    collection: CollectionMetadata,
    *,
    spacing: float | None,
) -> Outcome:
    """A page with its text, and the characters on it as works."""
    from rumu.gallery.add_page import add_page
    from rumu.gallery.page_import import read_text_file

    words = read_text_file(text)
    with working("Reading the page"):
        added = add_page(gallery, path, text=words, metadata=metadata, collection=collection, spacing=spacing)
    lines = [
        f"{added.id}: {'added' if added.new else 'was there already'}",
        f"  {counted(added.characters, 'character')} within it, {added.named} of them named by the text",
    ]
    work = {"id": added.id, "new": added.new, "characters": added.characters, "named": added.named}
    return Outcome({"works": [work | {"notes": []}]}, "\n".join(lines))


def _page(work_id: str, out: Path) -> Outcome:
    from importlib import resources

    from rumu.gallery.catalog import open_gallery
    from rumu.gallery.single_page import write_page

    static = Path(str(resources.files("rumu").joinpath("web", "static")))
    size = write_page(open_gallery(), work_id, out, static=static)
    return Outcome({"id": work_id, "out": out, "bytes": size}, f"{work_id}: {out} ({size / 1e6:.1f} MB)")


def shared_metadata(**given: str | None) -> SharedMetadata:
    """The metadata that options of a command give, for all works of it."""
    from rumu.gallery.labels import SharedMetadata
    from rumu.values import Bilingual

    zh, en = given.pop("title_zh"), given.pop("title_en")
    both = {name: Bilingual(text, text) for name in ("hand", "material") if (text := given.pop(name))}
    if zh or en:
        both["title"] = Bilingual(str(zh or en), str(en or zh))
    return SharedMetadata({name: text for name, text in given.items() if text}, both)


def _with_title(metadata: Any, path: Path) -> Any:
    """The metadata with a title: where none was given, the character or the name of the file."""
    from dataclasses import replace

    from rumu.values import Bilingual

    name = metadata.character or path.resolve().stem
    return metadata if metadata.title.zh else replace(metadata, title=Bilingual(name, name))


def _write_png(data: bytes, target: Path) -> None:
    import io

    from PIL import Image

    from rumu.outputs import whole_file

    if target.suffix.lower() != ".png":
        raise typer.BadParameter(f"expected a name that ends in .png, got {target}", param_hint="'-o'")
    with whole_file(target) as part:
        with Image.open(io.BytesIO(data)) as picture:
            if picture.format == "PNG":
                part.write_bytes(data)
                return
        from rumu.gallery.assets import decode_picture

        decode_picture(data).save(part, "PNG")


def _both_names(first: str, second: str) -> str:
    """Both names, or one where they are the same."""
    return first if first == second else f"{first} {second}".strip()


def _facts(work: Work) -> dict[str, Any]:
    both = ("title", "hand", "period", "material")
    plain = ("id", "character", "script", "dynasty", "source", "licence", "attribution", "kind", "width")
    more = ("height", "height_source", "spacing", "picture", "surface", "capture", "digest", "origin")
    facts: dict[str, Any] = {name: getattr(work, name) for name in (*plain, *more)}
    facts["collection"] = work.collection_id
    return facts | {name: getattr(work, name)._asdict() for name in both}
