"""IIIF Presentation 3: a manifest of each work and collection, so that any IIIF viewer can show them.

Both are built from iiif-prezi3's models, which refuse what the specification does not allow.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import Any

from sqlalchemy import select

from rumu.database.tables import Annotation, Collection, Work
from rumu.gallery import catalog
from rumu.gallery.annotations import annotations_of
from rumu.gallery.iiif_image import MAX_SIDE
from rumu.gallery.iiif_text import PagePlaces, places_of, search_services, text_annotations, text_ranges
from rumu.gallery.rights import is_address, rights_address
from rumu.gallery.store import Gallery
from rumu.gallery.tile_maps import MAPS, MapName, has_tiles
from rumu.gallery.vocabulary import HEIGHT_SOURCES, dynasty_name, script_name
from rumu.gallery.whole_works import CharacterWithin, characters_within

_CHINESE, _ENGLISH = "zh-Hant", "en"
_MAP_NAMES: dict[MapName, tuple[str, str]] = {
    "albedo": ("反照率圖塊", "Tiles of its albedo"),
    "normals": ("法線圖塊", "Tiles of its normals"),
}


def manifest(gallery: Gallery, work_id: str, *, base: str) -> dict[str, Any]:
    """The manifest of a work: its picture through the Image API, metadata, annotations and mesh.

    base: of the service, e.g. 'https://example.org'. Raises GalleryError when there is no such work.
    """
    from iiif_prezi3 import Manifest  # type: ignore[import-untyped]

    row = catalog.work(gallery, work_id)
    collection = catalog.collection(gallery, row.collection_id)
    base = base.rstrip("/")
    url = f"{base}/iiif/works/{row.id}"
    credit = "; ".join(filter(None, (row.licence, row.attribution)))
    facts: dict[str, Any] = {
        "id": f"{url}/manifest.json",
        "label": _label(*row.title),
        "summary": _label(*HEIGHT_SOURCES[row.height_source]),
        "metadata": _metadata(_facts(row, collection)),
        "requiredStatement": {
            "label": _label("授權與出處", "Licence and credit"),
            "value": _label(credit, credit),
        },
        "thumbnail": [_image(row, base=base, size=f"!{min(256, row.width)},{min(256, row.height)}")],
        "homepage": [
            {
                "id": f"{base}/#/works/{row.id}",
                "type": "Text",
                "label": _label("在光下看", "See it under a lamp"),
                "format": "text/html",
            }
        ],
        "rendering": [
            {
                "id": f"{base}/api/works/{row.id}/files/glb",
                "type": "Model",
                "label": _label("立體模型（glTF）", "3-D model (glTF)"),
                "format": "model/gltf-binary",
            }
        ],
        "partOf": [{"id": f"{base}/iiif/collections/{collection.id}.json", "type": "Collection"}],
        "items": [_canvas(row, annotations_of(gallery, work_id), canvas=f"{url}/canvas", base=base)],
    }
    if row.parent_id is not None:
        facts["partOf"].insert(
            0, {"id": f"{base}/iiif/works/{row.parent_id}/manifest.json", "type": "Manifest"}
        )
    if row.record is not None and row.record["provider"] and is_address(row.record["manifest"]):
        facts["provider"] = [_provider(one, row.record) for one in row.record["provider"]]
    if has_tiles(row):
        facts["seeAlso"] = [_tile_service(name, row, base=base) for name in MAPS]
    within = characters_within(gallery, work_id)
    if within:
        places = places_of(row, base=base)
        facts["items"][0].setdefault("annotations", []).append(text_annotations(within, places))
        facts["structures"] = [_contents(url, within, places)]
        facts["service"] = search_services(base, row.id)
    rights = rights_address(row.licence)
    model = Manifest(**facts | ({"rights": rights} if rights else {}))
    plain: dict[str, Any] = json.loads(model.json())
    return plain


def _contents(url: str, within: Sequence[CharacterWithin], places: PagePlaces) -> dict[str, Any]:
    """The table of contents of a whole work."""
    return {
        "id": f"{url}/range/text",
        "type": "Range",
        "label": _label("釋文", "Text"),
        "items": text_ranges(within, places),
    }


def _tile_service(name: MapName, row: Work, *, base: str) -> dict[str, Any]:
    """Where a map of a large work is served in tiles."""
    return {
        "id": f"{base}/iiif/tiles/{name}/{row.id}/info.json",
        "type": "Dataset",
        "label": _label(*_MAP_NAMES[name]),
        "format": "application/ld+json",
        "profile": "http://iiif.io/api/image/3/context.json",
    }


def _provider(name: dict[str, list[str]], record: dict[str, Any]) -> dict[str, Any]:
    """The museum that a work came from, as it names itself."""
    home = record["homepage"] if is_address(record.get("homepage", "")) else record["manifest"]
    page = {"id": home, "type": "Text", "label": name, "format": "text/html"}
    return {"id": record["manifest"], "type": "Agent", "label": name, "homepage": [page]}


def collection_manifest(gallery: Gallery, collection_id: str, *, base: str) -> dict[str, Any]:
    """A collection of the gallery as a IIIF collection: the manifests of its works, in order.

    base: of the service. Raises GalleryError when there is no such collection.
    """
    from iiif_prezi3 import Collection as IiifCollection  # type: ignore[import-untyped]

    base = base.rstrip("/")
    collection = catalog.collection(gallery, collection_id)
    with gallery.database.reading() as session:
        rows = session.execute(
            select(Work.id, Work.title_zh, Work.title_en)
            .where(Work.collection_id == collection_id, Work.parent_id.is_(None))
            .order_by(Work.position, Work.id)
        ).all()
    items = [
        {"id": f"{base}/iiif/works/{name}/manifest.json", "type": "Manifest", "label": _label(zh, en)}
        for name, zh, en in rows
    ]
    facts: dict[str, Any] = {
        "id": f"{base}/iiif/collections/{collection.id}.json",
        "label": _label(*collection.title),
        "metadata": _metadata(
            [("來源", "Source", collection.source, collection.source), _licence(collection.licence)]
        ),
    }
    if any(collection.note):
        facts["summary"] = _label(*collection.note)
    # The items are alike: only one of them is checked by the model, which takes long for thousands.
    plain: dict[str, Any] = json.loads(IiifCollection(**facts, items=items[:1]).json())
    return plain | {"items": items}


def _canvas(row: Work, annotations: tuple[Annotation, ...], *, canvas: str, base: str) -> dict[str, Any]:
    painting = {
        "id": f"{canvas}/painting",
        "type": "Annotation",
        "motivation": "painting",
        "body": _image(row, base=base, size="max"),
        "target": canvas,
    }
    facts: dict[str, Any] = {
        "id": canvas,
        "type": "Canvas",
        "label": _label(*row.title),
        "width": row.width,
        "height": row.height,
        "items": [{"id": f"{canvas}/page", "type": "AnnotationPage", "items": [painting]}],
    }
    if annotations:
        comments = [comment for one in annotations for comment in _comments(one, row, canvas)]
        facts["annotations"] = [{"id": f"{canvas}/said", "type": "AnnotationPage", "items": comments}]
    return facts


def _comments(one: Annotation, row: Work, canvas: str) -> list[dict[str, Any]]:
    """An annotation in each language in which it has a text, on a small box around its point."""
    side = max(2, round(max(row.width, row.height) / 32))
    x = max(0, min(row.width - side, round(one.x * row.width - side / 2)))
    y = max(0, min(row.height - side, round(one.y * row.height - side / 2)))
    texts = {_CHINESE: (one.title_zh, one.text_zh), _ENGLISH: (one.title_en, one.text_en)}
    return [
        {
            "id": f"{canvas}/said/{one.id}/{language}",
            "type": "Annotation",
            "motivation": "commenting",
            "body": {
                "type": "TextualBody",
                "language": language,
                "format": "text/plain",
                "value": "\n".join(filter(None, text)),
            },
            "target": f"{canvas}#xywh={x},{y},{side},{side}",
        }
        for language, text in texts.items()
        if any(text)
    ]


def _image(row: Work, *, base: str, size: str) -> dict[str, Any]:
    service = f"{base}/iiif/image/{row.id}"
    width, height = row.width, row.height
    longest = MAX_SIDE if size == "max" else 256
    factor = min(1.0, longest / max(width, height))
    return {
        "id": f"{service}/full/{size}/0/default.jpg",
        "type": "Image",
        "format": "image/jpeg",
        "width": max(1, int(width * factor + 1e-6)),
        "height": max(1, int(height * factor + 1e-6)),
        "service": [{"id": service, "type": "ImageService3", "profile": "level2"}],
    }


Fact = tuple[str, str, str, str]


def _facts(row: Work, collection: Collection) -> list[Fact]:
    dynasty = dynasty_name(row.dynasty)
    return [
        ("字", "Character", row.character, row.character),
        ("書體", "Script", *script_name(row.script)),
        ("書者", "Hand", *row.hand),
        ("時代", "Period", row.period_zh or dynasty.zh, row.period_en or dynasty.en),
        ("所示", "Shows", *row.material),
        ("所屬", "Collection", *collection.title),
        ("來源", "Source", row.source, row.source),
        _licence(row.licence),
    ]


def _licence(licence: str) -> Fact:
    return ("授權", "Licence", "未註明" if licence == "none stated" else licence, licence)


def _metadata(facts: list[Fact]) -> list[dict[str, Any]]:
    return [
        {"label": _label(zh, en), "value": _label(value_zh, value_en)}
        for zh, en, value_zh, value_en in facts
        if value_zh or value_en
    ]


def _label(zh: str, en: str) -> dict[str, list[str]]:
    texts = {language: [text] for language, text in ((_CHINESE, zh), (_ENGLISH, en)) if text}
    return texts or {"none": [""]}
