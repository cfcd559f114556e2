"""The text of a whole work for IIIF viewers: annotations, a table of contents, and a search within it.

Each character is an annotation (`supplementing`) on its place; each column is a range with a range for each
of its characters; and a service finds words in the text, also across columns, and answers by version 2 of
the Content Search API or by version 1, which Mirador 4 asks.
"""

from __future__ import annotations

import math
import unicodedata
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any
from urllib.parse import urlencode

from rumu.database.tables import Work
from rumu.gallery.catalog import work
from rumu.gallery.store import Gallery
from rumu.gallery.vocabulary import fold
from rumu.gallery.whole_works import UNKNOWN_CHARACTER, CharacterWithin, characters_within, text_lines

SEARCH_CONTEXT = "http://iiif.io/api/search/2/context.json"
SEARCH_1_CONTEXT = "http://iiif.io/api/search/1/context.json"
_LANGUAGE = "zh-Hant"
_CONTEXT = 8  # characters before and after a match that are shown with it
_MOST_MATCHES = 500


@dataclass(frozen=True, slots=True)
class PagePlaces:
    """Where characters lie on a canvas. canvas: its id. width, height: in pixels."""

    canvas: str
    width: int
    height: int

    def target(self, characters: Sequence[CharacterWithin]) -> str:
        """The part of the canvas around characters, in whole pixels."""
        points = [point for one in characters for point in one.place["polygon"]]
        left = math.floor(min(x for x, _ in points) * self.width)
        top = math.floor(min(y for _, y in points) * self.height)
        right = math.ceil(max(x for x, _ in points) * self.width)
        bottom = math.ceil(max(y for _, y in points) * self.height)
        return f"{self.canvas}#xywh={left},{top},{max(1, right - left)},{max(1, bottom - top)}"


def text_annotations(characters: Sequence[CharacterWithin], places: PagePlaces) -> dict[str, Any]:
    """The page of annotations with the text of a work: one for each character."""
    return {
        "id": f"{places.canvas}/text",
        "type": "AnnotationPage",
        "label": {_LANGUAGE: ["釋文"], "en": ["Text"]},
        "items": [
            _text_annotation(f"{places.canvas}/text/{one.id}", one.character, places.target([one]))
            for one in characters
            if one.character
        ],
    }


def _text_annotation(name: str, text: str, target: str) -> dict[str, Any]:
    return {
        "id": name,
        "type": "Annotation",
        "motivation": "supplementing",
        "body": {"type": "TextualBody", "value": text, "language": _LANGUAGE, "format": "text/plain"},
        "target": target,
    }


def text_ranges(characters: Sequence[CharacterWithin], places: PagePlaces) -> list[dict[str, Any]]:
    """The table of contents: a range for each column, in it one for each character."""
    base = places.canvas.rpartition("/")[0]
    return [
        {
            "id": f"{base}/range/{line[0].place['register']}-{line[0].place['column']}",
            "type": "Range",
            "label": {_LANGUAGE: ["".join(one.character or UNKNOWN_CHARACTER for one in line)]},
            "items": [
                {
                    "id": f"{base}/range/{one.id}",
                    "type": "Range",
                    "label": {_LANGUAGE: [one.character or UNKNOWN_CHARACTER]},
                    "items": [{"type": "Canvas", "id": places.target([one])}],
                }
                for one in line
            ],
        }
        for line in text_lines(characters)
    ]


# --- search ----------------------------------------------------------------------------------------


def search_services(base: str, work_id: str) -> list[dict[str, Any]]:
    """The services by which a manifest offers the search. base: of the service."""
    name = _search_name(base, work_id)
    return [
        {"id": name, "type": "SearchService2"},
        {
            "@context": SEARCH_1_CONTEXT,
            "@id": f"{name}/1",
            "@type": "SearchService1",
            "profile": "http://iiif.io/api/search/1/search",
        },
    ]


def search_text(gallery: Gallery, work_id: str, query: str, *, base: str) -> dict[str, Any]:
    """What a search finds in the text of a work: an annotation page of the Content Search API 2.

    query: words, parted by spaces; each is found wherever it stands, in any form of its characters.
    base: of the service. Raises GalleryError when there is no such work.
    """
    found = _find(gallery, work_id, query, base=base)
    page: dict[str, Any] = {
        "@context": SEARCH_CONTEXT,
        "id": f"{_search_name(base, work_id)}?{urlencode({'q': query})}",
        "type": "AnnotationPage",
        "items": [_text_annotation(part.id, part.text, part.target) for one in found for part in one.parts],
    }
    if found:
        page["annotations"] = [{"type": "AnnotationPage", "items": [_context(one) for one in found]}]
    return page


def search_text_1(gallery: Gallery, work_id: str, query: str, *, base: str) -> dict[str, Any]:
    """What `search_text` finds, as an annotation list of the Content Search API 1."""
    found = _find(gallery, work_id, query, base=base)
    return {
        "@context": ["http://iiif.io/api/presentation/2/context.json", SEARCH_1_CONTEXT],
        "@id": f"{_search_name(base, work_id)}/1?{urlencode({'q': query})}",
        "@type": "sc:AnnotationList",
        "within": {"@type": "sc:Layer", "total": sum(len(one.parts) for one in found)},
        "resources": [
            {
                "@id": part.id,
                "@type": "oa:Annotation",
                "motivation": "sc:painting",
                "resource": {"@type": "cnt:ContentAsText", "chars": part.text, "language": _LANGUAGE},
                "on": part.target,
            }
            for one in found
            for part in one.parts
        ],
        "hits": [
            {
                "@type": "search:Hit",
                "annotations": [part.id for part in one.parts],
                "match": one.text,
                "before": one.match.before,
                "after": one.match.after,
            }
            for one in found
        ],
    }


def _search_name(base: str, work_id: str) -> str:
    return f"{base.rstrip('/')}/iiif/works/{work_id}/search"


def places_of(row: Work, *, base: str) -> PagePlaces:
    """The canvas of a work. base: of the service."""
    return PagePlaces(f"{base.rstrip('/')}/iiif/works/{row.id}/canvas", row.width, row.height)


@dataclass(frozen=True, slots=True)
class _Match:
    """Characters that a word of a search is, with the text before and after them."""

    characters: tuple[CharacterWithin, ...]
    before: str
    after: str


@dataclass(frozen=True, slots=True)
class _Part:
    """The characters of a match in one column. id: of their annotation. target: their part of the canvas."""

    id: str
    text: str
    target: str


@dataclass(frozen=True, slots=True)
class _Found:
    """A match as annotations, one in each column that it runs through. id: of the match."""

    id: str
    match: _Match
    parts: tuple[_Part, ...]

    @property
    def text(self) -> str:
        """What was found, as it is written in the work."""
        return "".join(part.text for part in self.parts)


def _find(gallery: Gallery, work_id: str, query: str, *, base: str) -> list[_Found]:
    """All matches of a search. Raises GalleryError when there is no such work."""
    row = work(gallery, work_id)
    places, name = places_of(row, base=base), _search_name(base, row.id)
    found = []
    for number, match in enumerate(_matches(characters_within(gallery, work_id), query)):
        parts = (
            _Part(f"{name}/{number}-{k}", "".join(one.character for one in members), places.target(members))
            for k, members in enumerate(text_lines(match.characters))
        )
        found.append(_Found(f"{name}/{number}", match, tuple(parts)))
    return found


def _matches(characters: Sequence[CharacterWithin], query: str) -> Iterator[_Match]:
    """All places of each word, in reading order; characters that are not known match nothing."""
    folded = [fold(one.character) if one.character else "\n" for one in characters]
    shown = [one.character or UNKNOWN_CHARACTER for one in characters]
    count = 0
    for word in dict.fromkeys(_words(query)):
        wanted = [fold(character) for character in word]
        for at in range(len(folded) - len(wanted) + 1):
            if folded[at : at + len(wanted)] == wanted:
                end = at + len(wanted)
                before, after = shown[max(0, at - _CONTEXT) : at], shown[end : end + _CONTEXT]
                yield _Match(tuple(characters[at:end]), "".join(before), "".join(after))
                count += 1
                if count == _MOST_MATCHES:
                    return


def _words(query: str) -> Iterator[str]:
    """The words of a search, without punctuation."""
    for word in query.split():
        kept = "".join(one for one in word if unicodedata.category(one)[0] in "LN")
        if kept:
            yield kept


def _context(found: _Found) -> dict[str, Any]:
    """An annotation that says what stands around a match."""
    match = found.match
    selector = {
        "type": "TextQuoteSelector",
        "prefix": match.before,
        "exact": found.text,
        "suffix": match.after,
    }
    return {
        "id": f"{found.id}/context",
        "type": "Annotation",
        "motivation": "contextualizing",
        "target": {"type": "SpecificResource", "source": found.parts[0].id, "selector": [selector]},
    }
