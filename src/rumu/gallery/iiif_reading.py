"""Manifests and collections of the IIIF Presentation API, versions 2 and 3, as values of one form.

What a museum says is kept in its own languages; what it writes in other ways than the specification has it,
as large museums do, is read as far as it makes sense.
"""

from __future__ import annotations

import html
import json
import re
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from rumu.errors import GalleryError
from rumu.values import Bilingual

Texts = dict[str, list[str]]
"""Texts by language, 'none' where no language is said."""

_TAG = re.compile(r"<[^<>]{1,200}>")
_MOST_FACTS = 200
_LONGEST = 20_000  # characters of one text
_LONGEST_ADDRESS = 2000
_OTHER_SERVICES = ("auth", "search", "geo")  # that may stand beside the one of the picture
_NO_PICTURES = frozenset(
    {"sound", "video", "movingimage", "text", "textualbody", "contentastext", "model", "dataset"}
)


@dataclass(frozen=True, slots=True)
class CanvasPicture:
    """A canvas and the picture on it.

    id: of the canvas. picture: address of the image itself. service: base address of its Image API, '' if
    there is none. width, height: of the canvas, 0 where they are not said. number: of the picture on it.
    region, rotation: what of the picture is shown, as the Image API writes it.
    """

    id: str
    label: Texts
    picture: str
    service: str
    width: int = 0
    height: int = 0
    number: int = 1
    region: str = "full"
    rotation: str = "0"


@dataclass(frozen=True, slots=True)
class MuseumManifest:
    """A work as a museum describes it. record: what is kept of it, the fields of rows.RecordRow."""

    id: str
    label: Texts
    record: dict[str, Any]
    canvases: tuple[CanvasPicture, ...]
    without_picture: int = 0


@dataclass(frozen=True, slots=True)
class MuseumCollection:
    """A list of manifests and further collections. members: their addresses, each once."""

    id: str
    label: Texts
    members: tuple[str, ...]


def read_presentation(data: bytes, *, url: str) -> MuseumManifest | MuseumCollection:
    """A manifest or a collection. url: where it came from, for messages, and its id where it has none.

    Raises GalleryError for what is neither.
    """
    try:
        facts = json.loads(data.decode("utf-8-sig"))
    except (ValueError, RecursionError) as error:
        raise _no_manifest(url) from error
    if not isinstance(facts, dict):
        raise _no_manifest(url)
    kind = _plain_kind(facts)
    if kind == "collection":
        return _collection(facts, url)
    if kind == "manifest" or "sequences" in facts:
        return _manifest(facts, url)
    raise _no_manifest(url)


class NotAManifest(GalleryError):  # noqa: N818  what it is, not that it went wrong
    """A document that is neither a manifest nor a collection."""


def _no_manifest(url: str) -> NotAManifest:
    return NotAManifest(
        f"{url}: expected a manifest or a collection of the IIIF Presentation API 2 or 3",
        zh="這個網址不是 IIIF 清單（Presentation 2 或 3）。",
    )


def _plain_kind(facts: dict[str, Any]) -> str:
    """'manifest', 'collection', 'image' and the like: of 'sc:Manifest' and 'Manifest' alike."""
    kind = facts.get("type") or facts.get("@type") or ""
    kind = kind[0] if isinstance(kind, list) and kind else kind
    return str(kind).rpartition(":")[2].lower()


def _address(facts: Any) -> str:
    """The id of an object, or the address that stands in place of one."""
    if isinstance(facts, str):
        return facts[:_LONGEST_ADDRESS]
    if isinstance(facts, dict):
        return str(facts.get("id") or facts.get("@id") or "")[:_LONGEST_ADDRESS]
    return ""


def _objects(value: Any) -> Iterator[dict[str, Any]]:
    """The objects of a list, or of one that stands alone."""
    for one in value if isinstance(value, list) else [value]:
        if isinstance(one, dict):
            yield one


# --- texts -----------------------------------------------------------------------------------------


def read_texts(value: Any) -> Texts:
    """Texts by language, of version 3 or 2; markup is taken out, empty texts are left out."""
    found: dict[str, list[str]] = {}
    _collect(value, "none", found)
    return {language: texts[:50] for language, texts in list(found.items())[:50] if texts}


def _collect(value: Any, language: str, found: dict[str, list[str]]) -> None:
    if isinstance(value, list):
        for one in value:
            _collect(one, language, found)
    elif isinstance(value, dict):
        if "@value" in value:
            _collect(value["@value"], str(value.get("@language") or "none"), found)
            return
        for name, texts in value.items():
            if not str(name).startswith("@"):
                _collect(texts, str(name), found)
    elif isinstance(value, str | int | float) and not isinstance(value, bool):
        text = _clean(str(value))
        if text and text not in found.setdefault(language[:40], []):
            found[language[:40]].append(text)


def _clean(text: str) -> str:
    """Text without markup and control characters."""
    plain = html.unescape(_TAG.sub(" ", text)) if "<" in text or "&" in text else text
    kept = "".join(c for c in plain if c in "\n\t" or (ord(c) >= 32 and ord(c) != 127))
    kept = re.sub(r"[\ud800-\udfff]", "", kept)
    return re.sub(r"[ \t]+", " ", kept).strip()[:_LONGEST]


def in_both(texts: Texts) -> Bilingual:
    """A text in Chinese and in English; where one is missing, what there is stands for both."""
    chinese = _in_language(texts, ("zh-hant", "zh-tw", "zh-hk", "zh", "lzh", "ja"))
    english = _in_language(texts, ("en",))
    other = next((one[0] for one in texts.values()), "")
    if not chinese and not english:
        return Bilingual(other, other)
    return Bilingual(chinese or english, english or chinese)


def _in_language(texts: Texts, wanted: tuple[str, ...]) -> str:
    for start in wanted:
        for language, some in texts.items():
            if language.lower() == start or language.lower().startswith(f"{start}-"):
                return some[0]
    return ""


# --- manifests -------------------------------------------------------------------------------------


def _manifest(facts: dict[str, Any], url: str) -> MuseumManifest:
    label = read_texts(facts.get("label"))
    canvases = list(_canvases(facts))
    pictures = [list(_pictures_on(canvas)) for canvas in canvases]
    name = _address(facts) or url
    return MuseumManifest(
        id=name,
        label=label,
        record=_record(facts, label, name),
        canvases=tuple(one for found in pictures for one in found),
        without_picture=pictures.count([]),
    )


def _canvases(facts: dict[str, Any]) -> Iterator[dict[str, Any]]:
    if "sequences" in facts:
        for sequence in list(_objects(facts["sequences"]))[:1]:  # further ones are the same in other orders
            yield from _objects(sequence.get("canvases"))
    yield from _objects(facts.get("items"))


def _pictures_on(canvas: dict[str, Any]) -> Iterator[CanvasPicture]:
    """The pictures painted on a canvas, as pieces of a leaf are; of a choice the first or the default."""
    seen = set()
    for painted in _painted(canvas):
        body, region, rotation = _chosen(painted)
        service = _image_service(body)
        shown = (service or _address(body), region)
        if shown[0] and shown not in seen and _plain_kind(body) not in _NO_PICTURES:
            seen.add(shown)
            yield CanvasPicture(
                id=_address(canvas),
                label=read_texts(canvas.get("label")),
                picture=_address(body),
                service=service,
                width=_whole_number(canvas.get("width")),
                height=_whole_number(canvas.get("height")),
                number=len(seen),
                region=region,
                rotation=rotation,
            )


def _chosen(body: dict[str, Any]) -> tuple[dict[str, Any], str, str]:
    """The picture of a body, of a choice the default or the first; the region and rotation that are shown."""
    kind = _plain_kind(body)
    if kind == "choice":
        body = next(_objects(body.get("default") or body.get("items") or body.get("item")), {})
        kind = _plain_kind(body)
    if kind != "specificresource":
        return body, "full", "0"
    return next(_objects(body.get("source") or body.get("full")), {}), *_selected(body)


def _selected(body: dict[str, Any]) -> tuple[str, str]:
    """The region and the rotation that the selector of a part names."""
    for selector in _objects(body.get("selector")):
        kind = _plain_kind(selector)
        if kind == "imageapiselector":
            return str(selector.get("region") or "full"), str(selector.get("rotation") or "0")
        box = re.match(r"xywh=(?:pixel:)?(?:(percent):)?(.+)", str(selector.get("value") or ""))
        if kind == "fragmentselector" and box:
            return f"{'pct:' if box[1] else ''}{box[2]}", "0"
    return "full", "0"


def _painted(canvas: dict[str, Any]) -> Iterator[dict[str, Any]]:
    for image in _objects(canvas.get("images")):  # version 2
        yield from _objects(image.get("resource"))
    for page in _objects(canvas.get("items")):
        for annotation in _objects(page.get("items")):
            motivations = _list(annotation.get("motivation", "painting"))  # several may be named
            if any(str(one).rpartition(":")[2] == "painting" for one in motivations):
                yield from _objects(annotation.get("body"))


def _image_service(body: dict[str, Any]) -> str:
    """The base address of the Image API that serves a picture, '' if there is none.

    Beside it others may be named, such as those that ask for a login; one that says nothing of itself counts.
    """
    others = []
    for service in _objects(body.get("service")):
        kind, profile = str(service.get("type") or service.get("@type") or ""), service.get("profile")
        told = f"{kind} {profile} {service.get('@context', '')}".lower()
        if "image" in told:
            return _address(service).rstrip("/")
        if not any(name in told for name in _OTHER_SERVICES):
            others.append(_address(service).rstrip("/"))
    return next(filter(None, others), "")


def _whole_number(value: Any) -> int:
    return int(value) if isinstance(value, int | float) and not isinstance(value, bool) and value > 0 else 0


def _record(facts: dict[str, Any], label: Texts, name: str) -> dict[str, Any]:
    """What is kept of a manifest's words: rows.RecordRow without the canvas."""
    statement = facts.get("requiredStatement")
    told = _fact(statement) if isinstance(statement, dict) else None
    if told is None and facts.get("attribution"):  # version 2
        told = {"label": {"none": ["Attribution"]}, "value": read_texts(facts["attribution"])}
    rights = facts.get("rights") or facts.get("license") or ""
    provider = [read_texts(one.get("label")) for one in _objects(facts.get("provider"))]
    homepage = next((_address(one) for one in _list(facts.get("homepage") or facts.get("related"))), "")
    metadata = [_fact(one) for one in _objects(facts.get("metadata"))][:_MOST_FACTS]
    return {
        "label": label,
        "metadata": [one for one in metadata if one is not None],
        "statement": told,
        "provider": [one for one in provider if one][:20],
        "rights": _address(rights[0] if isinstance(rights, list) and rights else rights),
        "manifest": name,
        "homepage": homepage,
    }


def _fact(facts: dict[str, Any]) -> dict[str, Texts] | None:
    label, value = read_texts(facts.get("label")), read_texts(facts.get("value"))
    return {"label": label, "value": value} if value else None


def _list(value: Any) -> list[Any]:
    return value if isinstance(value, list) else [] if value is None else [value]


# --- collections -----------------------------------------------------------------------------------


def _collection(facts: dict[str, Any], url: str) -> MuseumCollection:
    members = [_address(one) for name in ("items", "members") for one in _objects(facts.get(name))]
    members += [_address(one) for name in ("manifests", "collections") for one in _list(facts.get(name))]
    told = tuple(dict.fromkeys(filter(None, members)))
    return MuseumCollection(_address(facts) or url, read_texts(facts.get("label")), told)
