"""Routes of works with their files and annotations, of facets and of collections."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Annotated, Any, Literal
from urllib.parse import quote

from fastapi import APIRouter, Depends, Query, Request, Response

from rumu.database.tables import Annotation, Work
from rumu.errors import GalleryError
from rumu.gallery import annotations as gallery_annotations
from rumu.gallery import catalog
from rumu.gallery.assets import assets_of
from rumu.gallery.derived import KINDS, MESHES, PLAIN, MeshShape, viewer_facts
from rumu.gallery.exhibitions import exhibition, order_works
from rumu.gallery.filters import Filters, count_facets
from rumu.gallery.single_page import single_page
from rumu.gallery.tile_maps import LAMPS, MAPS, MapName, has_tiles, tiles_etag
from rumu.gallery.whole_works import CharacterWithin, characters_within, count_characters
from rumu.studio.errors import Missing, Unusable
from rumu.values import SCRIPTS
from rumu.web.addresses import client_address, service_url
from rumu.web.collection_schemas import CollectionRead, CollectionUpdate, ExhibitionRead, OrderUpdate
from rumu.web.dependencies import Limit, Offset, OwnerUser, PathId, SearchText, ServiceDep, WorkId
from rumu.web.responses import file_response, requested_etags
from rumu.web.schemas import (
    AnnotationCreate,
    AnnotationRead,
    AnnotationUpdate,
    CharacterWithinRead,
    Extended,
    SurfaceRead,
    WorkRead,
    WorkUpdate,
    file_version,
)
from rumu.web.search_schemas import FacetValueRead, WorkPage
from rumu.web.service import Service

router = APIRouter(tags=["works"])
annotations_router = APIRouter(tags=["annotations"])
FileKind = Literal[
    "thumb", "thumb-normals", "cover", "cover-normals", "picture", "albedo", "normals", "normals-16",
    "height16", "heights", "mask", "lamp-a", "lamp-b", "lamp-c", "glb", "stl", "ply", "facts",
]  # fmt: skip


def mesh_shape(
    exaggeration: Annotated[float, Query(ge=0.01, le=100, allow_inf_nan=False)] = PLAIN.exaggeration,
    width: Annotated[float | None, Query(ge=5, le=2000, allow_inf_nan=False)] = PLAIN.width,
    base: Annotated[float, Query(ge=0.2, le=100, allow_inf_nan=False)] = PLAIN.base,
) -> MeshShape:
    """The shape of a mesh, as a request asks for it."""
    return MeshShape(exaggeration, width, base)


MeshShapeQuery = Annotated[MeshShape, Depends(mesh_shape)]


def find_work(service: Service, work_id: str) -> Work:
    """The row of a work. Raises Missing when there is none."""
    try:
        return catalog.work(service.gallery, work_id)
    except GalleryError as error:
        raise Missing(zh="沒有這件作品。", en="There is no such work.") from error


def work_filters(
    *,
    script: SearchText = None,
    dynasty: SearchText = None,
    hand: SearchText = None,
    character: SearchText = None,
    collection: SearchText = None,
    q: SearchText = None,
    masters: Annotated[bool, Query(description="Only works that are a character to copy.")] = False,
    within: Annotated[
        str | None, Query(max_length=200, description="Only the characters of this page or scroll.")
    ] = None,
) -> dict[str, Any]:
    """What works must match, by the names of `gallery.filters.Filters`."""
    if script not in (None, "", "none", *SCRIPTS):
        raise Unusable("script", zh="沒有這種書體。", en=f"Expected a script among {', '.join(SCRIPTS)}.")
    filters = {"script": script, "dynasty": dynasty, "hand": hand, "character": character}
    return filters | {"collection": collection, "query": q, "masters": masters, "within": within}


WorkFilters = Annotated[dict[str, Any], Depends(work_filters)]


@router.get("/api/works", response_model=WorkPage)
def list_works(
    service: ServiceDep, filters: WorkFilters, offset: Offset = 0, limit: Limit = 60
) -> catalog.ListPage[Extended]:
    """Works that match all filters, those that the search means most nearly first.

    A word of `q` is a character in any of its forms, its pinyin, a calligrapher, a title, a script or a
    dynasty, in Chinese or in Latin letters; works must match every word.
    """
    page = catalog.works(service.gallery, **filters, offset=offset, limit=limit)
    with service.gallery.database.reading() as session:
        counts = count_characters(session, (work.id for work in page.items))
    items = tuple(
        Extended(work, meanings=list(page.meanings.get(work.id, ())), characters=counts.get(work.id, 0))
        for work in page.items
    )
    return catalog.ListPage(items, page.total, page.understood)


@router.get("/api/facets", response_model=dict[str, list[FacetValueRead]])
def list_facets(service: ServiceDep, filters: WorkFilters) -> dict[str, Any]:
    """The values of each facet, counted among the works that match all filters but its own."""
    return count_facets(service.gallery, Filters(**filters))


@router.get("/api/collections", response_model=list[CollectionRead])
def list_collections(service: ServiceDep) -> list[Extended]:
    """Every collection."""
    return [Extended(row, works=count) for row, count in catalog.collections(service.gallery)]


@router.get("/api/collections/{collection_id}", response_model=ExhibitionRead)
def get_collection(service: ServiceDep, collection_id: PathId) -> Extended:
    """One collection, with its cover and its tour."""
    try:
        shown = exhibition(service.gallery, collection_id)
    except GalleryError as error:
        raise Missing(zh="沒有這個專題。", en="There is no such collection.") from error
    facts = {name: getattr(shown, name) for name in ("works", "cover", "chosen", "tour")}
    return Extended(shown.collection, **facts)


@router.patch("/api/collections/{collection_id}", response_model=ExhibitionRead)
def update_collection(
    service: ServiceDep, user: OwnerUser, collection_id: PathId, changes: CollectionUpdate
) -> Extended:
    """Change title, description, source, licence, cover or tour of a collection."""
    get_collection(service, collection_id)
    columns = to_columns(changes.model_dump())
    for name in ("cover", "tour"):
        if name in columns:
            columns[f"{name}_id"] = columns.pop(name)
    catalog.change_collection(service.gallery, collection_id, columns)
    return get_collection(service, collection_id)


@router.put("/api/collections/{collection_id}/order", status_code=204)
def order_collection(service: ServiceDep, user: OwnerUser, collection_id: PathId, order: OrderUpdate) -> None:
    """Choose which works of a collection come first, and in which order."""
    get_collection(service, collection_id)
    order_works(service.gallery, collection_id, order.works)


@router.delete("/api/collections/{collection_id}", status_code=204)
def delete_collection(service: ServiceDep, user: OwnerUser, collection_id: PathId) -> None:
    """Delete a collection with all its works and everything that belongs to them, attempts too."""
    get_collection(service, collection_id)
    catalog.delete_collection(service.gallery, collection_id)


@router.get("/api/works/{work_id}", response_model=WorkRead)
def get_work(service: ServiceDep, work_id: WorkId) -> Extended:
    """All that is known of a work."""
    work = find_work(service, work_id)
    previous, following = catalog.neighbours(service.gallery, work_id)
    page = None if work.parent_id is None else catalog.work(service.gallery, work.parent_id)
    beside = characters_within(service.gallery, work_id if page is None else page.id)
    return Extended(
        work,
        characters=len(beside) if page is None else 0,
        within=page
        and {
            "id": page.id,
            "title": page.title,
            "place": work.place,
            "same": [one.id for one in beside if work.character and one.character == work.character],
        },
        collection_title=catalog.collection(service.gallery, work.collection_id).title,
        annotations=gallery_annotations.annotations_of(service.gallery, work_id),
        previous=previous,
        next=following,
    )


@router.get("/api/works/{work_id}/characters", response_model=list[CharacterWithinRead])
def list_characters(service: ServiceDep, work_id: WorkId) -> Sequence[CharacterWithin]:
    """The characters of a page or scroll in reading order; none of any other work."""
    find_work(service, work_id)
    return characters_within(service.gallery, work_id)


@router.get("/api/works/{work_id}/viewer", response_model=SurfaceRead)
def get_surface(service: ServiceDep, work_id: WorkId) -> dict[str, Any]:
    """What the viewer needs of a work; the files at the URLs in it never change."""
    work = find_work(service, work_id)
    service.files.get(work, "facts")
    facts = viewer_facts(
        service.gallery,
        work_id,
        url=lambda kind, tag: service_url(f"/api/works/{quote(work_id, safe='')}/files/{kind}?v={tag}"),
    )
    return facts | {"tiles": tile_services(service, work, lamps=facts["three_lamps"] is not None)}


def tile_services(service: Service, work: Work, *, lamps: bool = False) -> dict[str, str] | None:
    """The image services of a work's maps and their version; None where it is too small for tiles.

    lamps: whether it has photographs under the paper's three lamps.
    """
    if not has_tiles(work):
        return None
    assets = assets_of(service.gallery.store, work)
    measured: tuple[MapName, ...] = () if assets.measured is None else ("picture",)
    names: tuple[MapName, ...] = (*MAPS, "heights", *measured, *(LAMPS if lamps else ()))
    services: dict[str, str] = {
        name: service_url(f"/iiif/tiles/{name}/{quote(work.id, safe='')}") for name in names
    }
    return services | {"version": tiles_etag(assets, "albedo")}


@router.get("/api/works/{work_id}/files/{kind}", response_class=Response)
def get_file(
    *,
    request: Request,
    service: ServiceDep,
    work_id: WorkId,
    kind: FileKind,
    v: Annotated[str | None, Query(max_length=80, description="The version, as URLs give it.")] = None,
    download: bool = False,
    shape: MeshShapeQuery,
) -> Response:
    """A picture, map or mesh. exaggeration: of a mesh's height. download: to be saved.

    A GLB or PLY is answered with the nearest exaggeration of 0.1, 0.25, 0.5, 0.75, 1, 1.25, 1.5, 2, 2.5, 3,
    4, 5, 6, 8, 10, 15, 25, 50 and 100.
    width, base: of an STL, in millimetres: from its left to its right side (by default as large as the sheet,
    100 mm long if its size is unknown), and the thickness below its lowest point.
    """
    if shape.exaggeration != PLAIN.exaggeration and kind not in MESHES:
        raise Unusable(zh="只有立體模型可以放大高度。", en="Only a mesh has an exaggeration.")
    if (shape.width, shape.base) != (PLAIN.width, PLAIN.base) and kind != "stl":
        raise Unusable(zh="只有 STL 可以指定寬度和底座厚度。", en="Only an STL has a width and a base.")
    work = find_work(service, work_id)

    def count_mesh() -> None:
        if kind in MESHES:
            limit = service.settings.rate_limits.meshes
            service.rate_limiter.hit(limit, "meshes", client_address(request))

    etags = requested_etags(request.headers)
    content = service.files.get(work, kind, shape=shape, client_etags=etags, before_making=count_mesh)
    stem = _file_stem(work_id)
    name = f"{stem}.{kind}" if kind in MESHES else f"{stem}-{kind}{KINDS[kind].suffix}"
    immutable = v in (content.etag, file_version(work))
    return file_response(request, content, filename=name if download else None, immutable=immutable)


@router.get("/api/works/{work_id}/export.html", response_class=Response)
def export_work(service: ServiceDep, work_id: WorkId) -> Response:
    """The work with the viewer inside, in one file that needs no server and no network."""
    find_work(service, work_id)
    page = single_page(service.gallery, work_id, static=service.settings.static)
    headers = {"Content-Disposition": f'attachment; filename="{_file_stem(work_id)}.html"'}
    return Response(page, media_type="text/html; charset=utf-8", headers=headers)


@router.patch("/api/works/{work_id}", response_model=WorkRead)
def update_work(service: ServiceDep, user: OwnerUser, work_id: WorkId, changes: WorkUpdate) -> Extended:
    """Change what is known of a work. A spacing of null takes the spacing back."""
    work = find_work(service, work_id)
    values = to_columns(changes.model_dump())
    if "spacing" in changes.model_fields_set:
        if work.kind == "capture" and changes.spacing != work.spacing:  # heights were measured at this size
            raise Unusable(
                "spacing",
                zh="多燈照片的像素大小由照片而來，不能另改。",
                en="The size of a pixel came with these photographs and cannot be changed here.",
            )
        values["spacing"] = changes.spacing
    catalog.change_work(service.gallery, work_id, values)
    return get_work(service, work_id)


@router.delete("/api/works/{work_id}", status_code=204)
def delete_work(service: ServiceDep, user: OwnerUser, work_id: WorkId) -> None:
    """Delete a work with everything that belongs to it, attempts too."""
    find_work(service, work_id)
    catalog.delete_work(service.gallery, work_id)


@annotations_router.get("/api/works/{work_id}/annotations", response_model=list[AnnotationRead])
def list_annotations(service: ServiceDep, work_id: PathId) -> Sequence[Annotation]:
    """The annotations of a work, in order."""
    find_work(service, work_id)
    return gallery_annotations.annotations_of(service.gallery, work_id)


@annotations_router.post("/api/works/{work_id}/annotations", response_model=AnnotationRead, status_code=201)
def add_annotation(
    service: ServiceDep, user: OwnerUser, work_id: PathId, annotation: AnnotationCreate
) -> Annotation:
    """Add a note on a point of a work."""
    find_work(service, work_id)
    values = to_columns(annotation.model_dump())
    return gallery_annotations.add_annotation(service.gallery, work_id, values, author=user.id)


@annotations_router.patch("/api/works/{work_id}/annotations/{annotation_id}", response_model=AnnotationRead)
def update_annotation(
    service: ServiceDep, user: OwnerUser, work_id: PathId, annotation_id: PathId, changes: AnnotationUpdate
) -> Annotation:
    """Change the point or the texts of an annotation."""
    _check_annotation(service, work_id, annotation_id)
    values = to_columns(changes.model_dump())
    return gallery_annotations.change_annotation(service.gallery, annotation_id, values, of=work_id)


@annotations_router.delete("/api/works/{work_id}/annotations/{annotation_id}", status_code=204)
def delete_annotation(service: ServiceDep, user: OwnerUser, work_id: PathId, annotation_id: PathId) -> None:
    """Delete an annotation."""
    _check_annotation(service, work_id, annotation_id)
    gallery_annotations.delete_annotation(service.gallery, annotation_id, of=work_id)


def _check_annotation(service: Service, work_id: str, annotation_id: str) -> None:
    with service.gallery.database.reading() as session:
        row = session.get(Annotation, annotation_id)
    if row is None or row.work_id != work_id:
        raise Missing(zh="沒有這條註解。", en="There is no such annotation.")


def to_columns(values: dict[str, Any]) -> dict[str, Any]:
    """{"title": {"zh", "en"}} as title_zh and title_en; what is null is left out, so it stays as it was."""
    columns: dict[str, Any] = {}
    for name, value in values.items():
        if isinstance(value, dict):
            columns |= {f"{name}_{language}": value[language] for language in ("zh", "en")}
        elif value is not None:
            columns[name] = value
    return columns


def _file_stem(work_id: str) -> str:
    """The id as the start of a file's name in a header."""
    return re.sub(r"[^A-Za-z0-9._~-]", "_", work_id)


slash_router = APIRouter(tags=["works"], include_in_schema=False)
"""Works with a slash in their id, which imports once let in. It is included last: other routes come first."""

slash_router.get("/api/works/{work_id:path}/viewer", response_model=SurfaceRead)(get_surface)
slash_router.get("/api/works/{work_id:path}/files/{kind}", response_class=Response)(get_file)
slash_router.get("/api/works/{work_id:path}", response_model=WorkRead)(get_work)
slash_router.patch("/api/works/{work_id:path}", response_model=WorkRead)(update_work)
slash_router.delete("/api/works/{work_id:path}", status_code=204)(delete_work)
