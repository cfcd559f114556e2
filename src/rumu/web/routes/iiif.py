"""The gallery for every IIIF viewer, also on other sites: Presentation 3 and Image 3. And one work as one
file."""

from __future__ import annotations

import hashlib
from typing import Annotated, Any

from fastapi import APIRouter, Path, Request, Response
from fastapi.responses import JSONResponse, RedirectResponse

from rumu.errors import GalleryError
from rumu.gallery.iiif import collection_manifest, manifest
from rumu.gallery.iiif_image import BadImageRequest, image_info
from rumu.gallery.single_page import single_page
from rumu.studio import worker
from rumu.studio.errors import Missing
from rumu.web.caching import file_response, requested_etags
from rumu.web.dependencies import PathId, ServiceDep
from rumu.web.files import FileContent
from rumu.web.routes.works import found_work

router = APIRouter(tags=["iiif"])
OPEN = {"Access-Control-Allow-Origin": "*"}
_PROFILE = "http://iiif.io/api/presentation/3/context.json"
Word = Annotated[str, Path(max_length=80)]


@router.get("/iiif/works/{work_id}/manifest.json", response_class=JSONResponse)
def of_work(request: Request, service: ServiceDep, work_id: PathId) -> Response:
    """The manifest of a work."""
    found_work(service, work_id)
    return _told(manifest(service.gallery, work_id, base=_base(request)))


@router.get("/iiif/collections/{collection_id}.json", response_class=JSONResponse)
def of_collection(request: Request, service: ServiceDep, collection_id: PathId) -> Response:
    """The manifests of a collection's works."""
    try:
        return _told(collection_manifest(service.gallery, collection_id, base=_base(request)))
    except GalleryError as error:
        raise Missing("沒有這個集子。", "There is no such collection.") from error


@router.get("/iiif/image/{work_id}", include_in_schema=False)
def image(work_id: PathId) -> Response:
    """The specification sends who asks for the picture itself to its description."""
    return RedirectResponse(f"/iiif/image/{work_id}/info.json", 303, headers=OPEN)


@router.get("/iiif/image/{work_id}/info.json", response_class=JSONResponse)
def info(request: Request, service: ServiceDep, work_id: PathId) -> Response:
    """What sizes and parts a picture is served in."""
    found_work(service, work_id)
    facts = image_info(service.gallery, work_id, base=f"{_base(request)}/iiif/image")
    kind = 'application/ld+json;profile="http://iiif.io/api/image/3/context.json"'
    return JSONResponse(facts, media_type=kind, headers=OPEN)


@router.get("/iiif/image/{work_id}/{region}/{size}/{rotation}/{name}", response_class=Response)
def part(
    *,
    request: Request,
    service: ServiceDep,
    work_id: PathId,
    region: Word,
    size: Word,
    rotation: Word,
    name: Word,
) -> Response:
    """A part of a picture, as the Image API names it. name: default.jpg and the like."""
    work = found_work(service, work_id)
    quality, _, ending = name.rpartition(".")
    asked = "/".join((work.digest, region, size, rotation, name))
    tag = hashlib.sha256(asked.encode("utf-8", "replace")).hexdigest()[:20]
    if tag in requested_etags(request.headers):
        answer = file_response(request, FileContent(b"", None, "", tag))
    else:
        try:
            data, kind = service.workers.ask(
                worker.image_part,
                work_id=work_id,
                words=(region, size, rotation, quality, ending),
            )
        except BadImageRequest as error:
            facts = {"error": {"code": "image_request", "zh": "圖像請求不合規範。", "en": str(error)}}
            return JSONResponse(facts, 400, headers=OPEN)
        answer = file_response(request, FileContent(data, None, kind, tag))
    answer.headers.update(OPEN)
    return answer


@router.get("/api/works/{work_id}/export.html", response_class=Response, tags=["works"])
def export(service: ServiceDep, work_id: PathId) -> Response:
    """The work with the viewer inside, in one file that needs no server and no network."""
    found_work(service, work_id)
    page = single_page(service.gallery, work_id, static=service.settings.static)
    headers = {"Content-Disposition": f'attachment; filename="{work_id}.html"'}
    return Response(page, media_type="text/html; charset=utf-8", headers=headers)


def _told(facts: dict[str, Any]) -> Response:
    return JSONResponse(facts, media_type=f'application/ld+json;profile="{_PROFILE}"', headers=OPEN)


def _base(request: Request) -> str:
    return str(request.base_url).rstrip("/")
