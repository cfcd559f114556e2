"""Works: looked for, looked at, changed."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from anyio.to_thread import run_sync
from fastapi import APIRouter, Depends, Query, Request, Response

from rumu.assessment.scripts import SCRIPTS
from rumu.database.tables import Work
from rumu.errors import GalleryError
from rumu.gallery import annotations as said
from rumu.gallery import catalog
from rumu.gallery.derived import KINDS, MESHES, viewer_facts
from rumu.gallery.filters import Filters, count_facets
from rumu.studio.errors import Missing, Unusable
from rumu.web.caching import file_response, requested_etags
from rumu.web.cards import collection_facts, file_version, work_card, work_facts
from rumu.web.dependencies import Limit, Offset, OwnerUser, PathId, SearchText, ServiceDep
from rumu.web.files import FileContent
from rumu.web.schemas import CollectionRead, FacetValueRead, SurfaceRead, WorkPage, WorkRead, WorkUpdate
from rumu.web.service import Service

router = APIRouter(tags=["works"])
Kind = Literal[
    "thumb", "thumb-normals", "picture", "albedo", "normals", "normals-16", "height16", "heights", "mask",
    "lamp-a", "lamp-b", "lamp-c", "glb", "stl", "ply", "facts",
]  # fmt: skip
Exaggeration = Annotated[float, Query(ge=0.01, le=100, allow_inf_nan=False)]


def found_work(service: Service, work_id: str) -> Work:
    """Raises Missing."""
    try:
        return catalog.work(service.gallery, work_id)
    except GalleryError as error:
        raise Missing("沒有這件作品。", "There is no such work.") from error


def asked_for(
    *,
    script: SearchText = None,
    dynasty: SearchText = None,
    hand: SearchText = None,
    character: SearchText = None,
    collection: SearchText = None,
    q: SearchText = None,
) -> dict[str, Any]:
    """What is asked of works, as the catalogue names it."""
    if script not in (None, "", "none", *SCRIPTS):
        raise Unusable("script", zh="沒有這種書體。", en=f"Expected a script among {', '.join(SCRIPTS)}.")
    asked = {"script": script, "dynasty": dynasty, "hand": hand, "character": character}
    return asked | {"collection": collection, "query": q}


AskedFor = Annotated[dict[str, Any], Depends(asked_for)]


@router.get("/api/works", response_model=WorkPage)
def works(service: ServiceDep, asked: AskedFor, offset: Offset = 0, limit: Limit = 60) -> dict[str, Any]:
    """Works that match all that is asked; a character is found in any of its forms."""
    page = catalog.works(service.gallery, **asked, offset=offset, limit=limit)
    return {"total": page.total, "items": [work_card(work) for work in page.items]}


@router.get("/api/facets", response_model=dict[str, list[FacetValueRead]])
def facets(service: ServiceDep, asked: AskedFor) -> dict[str, Any]:
    """What can be chosen further; the counts of a facet heed all choices but its own."""
    found = count_facets(service.gallery, Filters(**asked))
    return {
        name: [{"value": v.value, "zh": v.zh, "en": v.en, "count": v.count} for v in values]
        for name, values in found.items()
    }


@router.get("/api/collections", response_model=list[CollectionRead])
def collections(service: ServiceDep) -> list[dict[str, Any]]:
    """Every collection."""
    return [collection_facts(row, count) for row, count in catalog.collections(service.gallery)]


@router.get("/api/collections/{collection_id}", response_model=CollectionRead)
def collection(service: ServiceDep, collection_id: PathId) -> dict[str, Any]:
    """One collection."""
    for row, count in catalog.collections(service.gallery):
        if row.id == collection_id:
            return collection_facts(row, count)
    raise Missing("沒有這個集子。", "There is no such collection.")


@router.get("/api/works/{work_id}", response_model=WorkRead)
def work(service: ServiceDep, work_id: PathId) -> dict[str, Any]:
    """All that is known of a work."""
    return told(service, found_work(service, work_id))


@router.get("/api/works/{work_id}/viewer", response_model=SurfaceRead)
def viewer(service: ServiceDep, work_id: PathId) -> dict[str, Any]:
    """What the viewer needs of a work; the addresses in it may be kept for ever."""
    found_work(service, work_id)
    service.files.of_work(work_id, "facts")
    return viewer_shape(viewer_facts(service.gallery, work_id))


@router.get("/api/works/{work_id}/files/{kind}", response_class=Response)
async def file(
    *,
    request: Request,
    service: ServiceDep,
    work_id: PathId,
    kind: Kind,
    v: Annotated[str | None, Query(max_length=80, description="The version, as addresses have it.")] = None,
    download: bool = False,
    exaggeration: Exaggeration = 1.0,
) -> Response:
    """A picture, map or mesh. exaggeration: of a mesh's height. download: to be saved."""
    name = f"{work_id}.{kind}" if kind in MESHES else f"{work_id}-{kind}{KINDS[kind].suffix}"
    sent = service.files.at_address((work_id, kind, exaggeration, v or ""))
    if sent is None:
        sent = await run_sync(_file, request, service, work_id, kind, exaggeration)
    return file_response(request, sent, filename=name if download else None)


def _file(request: Request, service: Service, work_id: str, kind: str, exaggeration: float) -> FileContent:
    if exaggeration != 1.0 and kind not in MESHES:
        raise Unusable(zh="只有立體模型可以放大高度。", en="Only a mesh has an exaggeration.")
    work = found_work(service, work_id)
    sent = service.files.of_work(
        work_id, kind, exaggeration=exaggeration, client_etags=requested_etags(request.headers)
    )
    version = request.query_params.get("v")
    if version is not None and version in (sent.etag, file_version(work)):
        service.files.set_address((work_id, kind, exaggeration, version), sent)
    return sent


@router.patch("/api/works/{work_id}", response_model=WorkRead)
def change(service: ServiceDep, user: OwnerUser, work_id: PathId, changes: WorkUpdate) -> dict[str, Any]:
    """Change what is known of a work. A spacing of null is one taken back."""
    found = found_work(service, work_id)
    given = columns(changes.model_dump())
    if "spacing" in changes.model_fields_set:
        given["spacing"] = _spacing(found, changes.spacing)
    changed = catalog.change_work(service.gallery, work_id, given)
    service.files.forget_addresses()
    return told(service, changed)


def _spacing(work: Work, told: float | None) -> float | None:
    """Raises Unusable for photographs under lamps: their heights were measured at the size they brought."""
    if work.kind == "capture" and told != work.spacing:
        raise Unusable(
            "spacing",
            zh="多燈照片的像素大小由照片而來，不能另改。",
            en="The size of a pixel came with these photographs and cannot be changed here.",
        )
    return told


@router.delete("/api/works/{work_id}", status_code=204)
def delete(service: ServiceDep, user: OwnerUser, work_id: PathId) -> None:
    """Forget a work with everything that hangs on it, attempts too."""
    found_work(service, work_id)
    catalog.delete_work(service.gallery, work_id)
    service.files.forget_addresses()


def told(service: Service, work: Work) -> dict[str, Any]:
    """All that is known of a work, as it goes out."""
    return work_facts(
        work,
        collection=catalog.collection(service.gallery, work.collection_id),
        annotations=said.said_of(service.gallery, work.id),
        neighbours=catalog.neighbours(service.gallery, work.id),
    )


def viewer_shape(facts: dict[str, Any]) -> dict[str, Any]:
    """What the gallery tells of a surface as the viewer reads it."""
    told = dict(facts)
    width, height = told.pop("pixels")
    return told | {"heights": told.pop("height"), "width": width, "height": height}


def columns(changes: dict[str, Any]) -> dict[str, Any]:
    """{"title": {"zh", "en"}} as title_zh and title_en; what is null stays as it was."""
    given = {name: value for name, value in changes.items() if value is not None}
    flat = {name: value for name, value in given.items() if not isinstance(value, dict)}
    for name, value in given.items():
        if isinstance(value, dict):
            flat |= {f"{name}_{language}": value[language] for language in ("zh", "en")}
    return flat
