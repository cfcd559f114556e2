"""A page into named characters: by its text, by the masters that are given, or by the known characters."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from rumu.errors import GalleryError, RumuError
from rumu.pages.page import Page
from rumu.pages.reading import find_characters
from rumu.strokes.shape_names import Look, ReferenceShapes, describe_look, name_shapes
from rumu.values import SCRIPTS, FloatArray

if TYPE_CHECKING:
    from rumu.gallery.masters import Master

Described = tuple[str, FloatArray]
_MOST_WORKS = 100_000


def read_page(
    picture: str | os.PathLike[str] | npt.NDArray[Any],
    *,
    text: str | None = None,
    reference: str | os.PathLike[str] | Sequence[str | os.PathLike[str]] = (),
) -> Page:
    """Find the characters of a photographed or scanned page.

    Parameters
    ----------
    picture : path or ndarray
        A file; or an array (H, W) or (H, W, 3) of bool, uint8, uint16, or float in [0, 1], values as stored.
    text : str, optional
        What is written on the page, in reading order, with or without line breaks; punctuation and spaces
        are ignored. Each character then gets its name. Without it each is named where it is certain which of
        9,574 known characters it is.
    reference : path or str, or several
        Masters whose characters alone may be named, where there is no text: pictures named by their
        characters, folders of such, a labels.csv, a script of the starter works, or the id of a work or
        collection of the gallery.

    Returns
    -------
    Page
        Its characters in reading order, with their places on the page as it lies flat; on a page with a
        printed grid, the cells that are written in, and in `cells` all of them. Where nothing on the picture
        is writing, `characters` is empty.

    Raises
    ------
    ImageError
        The file or array is no usable picture.
    RefusedImage
        The picture is blank.
    GalleryError
        There are no such masters, or none of them says which character it is.
    """
    sources = [reference] if isinstance(reference, str | os.PathLike) else list(reference)
    if text is not None and sources:
        raise GalleryError(
            "expected a text or references, got both: with a text every character has its name",
            zh="釋文和參考範字只能給一種：有了釋文，字就都有名稱了。",
        )
    references = describe_references(sources) if sources else None

    def name_looks(looks: list[Look]) -> list[tuple[str | None, float]]:
        return [(one.character, one.certainty) for one in name_shapes(looks, references=references)]

    return find_characters(picture, text=text, name_looks=None if text is not None else name_looks)


def describe_references(sources: Sequence[str | os.PathLike[str]]) -> ReferenceShapes:
    """The characters that masters show, see `read_page`. Raises GalleryError where there are none."""
    described = [one for source in sources for one in _describe_source(os.fspath(source))]
    if not described:
        names = ", ".join(map(str, sources))
        raise GalleryError(
            f"expected masters whose characters are known in {names}, found none",
            zh=f"{names} 裡沒有標明是什麼字的範字。",
        )
    return ReferenceShapes(tuple(one for one, _ in described), np.array([vector for _, vector in described]))


def _describe_source(name: str) -> Iterator[Described]:
    if name in SCRIPTS:
        from rumu.gallery.starter import starter_works

        yield from _describe_masters_of([(work.character, work.path) for work in starter_works(script=name)])
    elif Path(name).is_file() and Path(name).suffix.lower() != ".csv":
        yield from _describe_masters_of([(Path(name).stem, Path(name))])
    elif Path(name).exists():
        yield from _of_folder(Path(name))
    else:
        yield from _of_gallery(name)


def _of_folder(path: Path) -> Iterator[Described]:
    """Masters of a folder or a labels.csv; their descriptions are kept as those of a search are."""
    from rumu.gallery.search import index_masters
    from rumu.registration.descriptor import from_bytes

    index = index_masters(path)
    for master, vector in zip(index.masters, from_bytes(index.vectors), strict=True):
        character = _character_of(master)
        if character:
            yield character, vector


def _character_of(master: Master) -> str:
    """What a master shows: what its label says, or its file's name where that is one character."""
    said = master.character or master.path.stem
    return said if len(said) == 1 else ""


def _of_gallery(name: str) -> Iterator[Described]:
    """The works of a collection, the characters within a page, or the one work of this id."""
    from rumu.gallery.catalog import open_gallery, work, works
    from rumu.gallery.whole_works import characters_within

    gallery = open_gallery()
    found = list(works(gallery, collection=name, limit=_MOST_WORKS).items)
    if not found:
        within = characters_within(gallery, name)
        found = [work(gallery, one.id) for one in within if one.character] or [work(gallery, name)]
    for one in found:  # pictures are read one by one: a collection may be large
        with gallery.store.local(one.picture) as path:
            yield from _describe_masters_of([(one.character, path)])


def _describe_masters_of(pictures: Iterable[tuple[str, Path]]) -> Iterator[Described]:
    """Pictures with what they show; those that show more than one character, or no ink, are left out."""
    from rumu.surface.relief import read_with_ink

    for character, picture in pictures:
        if len(character) != 1:
            continue
        try:
            y, x = np.nonzero(read_with_ink(picture)[1].mask)
            yield character, describe_look((y, x))
        except RumuError:
            continue
