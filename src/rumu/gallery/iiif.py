"""IIIF Presentation 3: a manifest for every work and collection, so that any IIIF viewer can show them.

Both are made of iiif-prezi3's models, which refuse what the specification does not allow.
"""

from __future__ import annotations

import json
from typing import Any

from sqlalchemy import select

from rumu.database.tables import Annotation, Collection, Work
from rumu.gallery import catalog
from rumu.gallery.annotations import annotations_of
from rumu.gallery.gallery import Gallery
from rumu.gallery.iiif_image import MAX_SIDE
from rumu.gallery.vocabulary import HEIGHT_SOURCES, dynasty_name, script_name
from rumu.values import Bilingual

_CHINESE, _ENGLISH = "zh-Hant", "en"
_RIGHTS = {
    "CC-BY-ND-3.0-TW": "http://creativecommons.org/licenses/by-nd/3.0/tw/",
    "public domain": "http://creativecommons.org/publicdomain/mark/1.0/",
    "CC0-1.0": "http://creativecommons.org/publicdomain/zero/1.0/",
    "CC-BY-4.0": "http://creativecommons.org/licenses/by/4.0/",
    "CC-BY-SA-4.0": "http://creativecommons.org/licenses/by-sa/4.0/",
}


def manifest(gallery: Gallery, work_id: str, *, base: str) -> dict[str, Any]:
    """The manifest of a work: its picture through the Image API, its facts, what is said of it, its mesh.

    base: of the service, e.g. 'https://example.org'. Raises GalleryError when there is no such work.
    """
    row = catalog.work(gallery, work_id)
    of = catalog.collection(gallery, row.collection_id)
    made = _manifest(row, of, annotations_of(gallery, work_id), base=base.rstrip("/"))
    return _plain(made)


def collection_manifest(gallery: Gallery, collection_id: str, *, base: str) -> dict[str, Any]:
    """The IIIF collection of one of the gallery: the manifests of its works, in order.

    base: of the service. Raises GalleryError when there is no such collection.
    """
    from iiif_prezi3 import Collection as Made  # type: ignore[import-untyped]

    base = base.rstrip("/")
    of = catalog.collection(gallery, collection_id)
    with gallery.database.reading() as session:
        found = session.execute(
            select(Work.id, Work.title_zh, Work.title_en)
            .where(Work.collection_id == collection_id)
            .order_by(Work.position, Work.id)
        ).all()
    items = [
        {
            "id": f"{base}/iiif/works/{row[0]}/manifest.json",
            "type": "Manifest",
            "label": _label(row[1], row[2]),
        }
        for row in found
    ]
    facts: dict[str, Any] = {
        "id": f"{base}/iiif/collections/{of.id}.json",
        "label": _label(of.title_zh, of.title_en),
        "metadata": _metadata([("來源", "Source", of.source, of.source), _licence(of.licence)]),
    }
    if of.note_zh or of.note_en:
        facts["summary"] = _label(of.note_zh, of.note_en)
    # The items are alike: one is checked, and thousands are not made into objects and back.
    made = _plain(Made(**facts, items=items[:1]))
    return made | {"items": items}


def _manifest(row: Work, of: Collection, said: tuple[Annotation, ...], *, base: str) -> Any:
    from iiif_prezi3 import Manifest  # type: ignore[import-untyped]

    place = f"{base}/iiif/works/{row.id}"
    height = HEIGHT_SOURCES[row.height_source]
    credit = "; ".join(filter(None, (row.licence, row.attribution)))
    facts: dict[str, Any] = {
        "id": f"{place}/manifest.json",
        "label": _label(row.title_zh, row.title_en),
        "summary": _label(height.zh, height.en),
        "metadata": _metadata(_facts(row, of)),
        "requiredStatement": _pair(("授權與出處", "Licence and credit", credit, credit)),
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
        "partOf": [{"id": f"{base}/iiif/collections/{of.id}.json", "type": "Collection"}],
        "items": [_canvas(row, said, place=place, base=base)],
    }
    rights = next((url for name, url in _RIGHTS.items() if row.licence.startswith(name)), None)
    return Manifest(**facts | ({"rights": rights} if rights else {}))


def _canvas(row: Work, said: tuple[Annotation, ...], *, place: str, base: str) -> dict[str, Any]:
    canvas = f"{place}/canvas"
    painting = {
        "id": f"{canvas}/painting",
        "type": "Annotation",
        "motivation": "painting",
        "body": _image(row, base=base, size="max"),
        "target": canvas,
    }
    made: dict[str, Any] = {
        "id": canvas,
        "type": "Canvas",
        "label": _label(row.title_zh, row.title_en),
        "width": row.width,
        "height": row.height,
        "items": [{"id": f"{canvas}/page", "type": "AnnotationPage", "items": [painting]}],
    }
    if said:
        comments = [comment for one in said for comment in _comments(one, row, canvas)]
        made["annotations"] = [{"id": f"{canvas}/said", "type": "AnnotationPage", "items": comments}]
    return made


def _comments(one: Annotation, row: Work, canvas: str) -> list[dict[str, Any]]:
    """One annotation in each language that it speaks, on a small box around its point."""
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


def _facts(row: Work, of: Collection) -> list[Fact]:
    script, dynasty = script_name(row.script), dynasty_name(row.dynasty)
    period = Bilingual(row.period_zh or dynasty.zh, row.period_en or dynasty.en)
    return [
        ("字", "Character", row.character, row.character),
        ("書體", "Script", script.zh, script.en),
        ("書者", "Hand", row.hand_zh, row.hand_en),
        ("時代", "Period", period.zh, period.en),
        ("所示", "Shows", row.material_zh, row.material_en),
        ("所屬", "Collection", of.title_zh, of.title_en),
        ("來源", "Source", row.source, row.source),
        _licence(row.licence),
    ]


def _licence(licence: str) -> Fact:
    return ("授權", "Licence", "未註明" if licence == "none stated" else licence, licence)


def _metadata(facts: list[Fact]) -> list[dict[str, Any]]:
    return [_pair(fact) for fact in facts if fact[2] or fact[3]]


def _pair(fact: Fact) -> dict[str, Any]:
    return {"label": _label(fact[0], fact[1]), "value": _label(fact[2], fact[3])}


def _label(zh: str, en: str) -> dict[str, list[str]]:
    told = {language: [text] for language, text in ((_CHINESE, zh), (_ENGLISH, en)) if text}
    return told or {"none": [""]}


def _plain(made: Any) -> dict[str, Any]:
    facts: dict[str, Any] = json.loads(made.json())
    return facts
