"""Routes of IIIF, for viewers on any site: Presentation API 3 and Image API 3."""

from __future__ import annotations

import hashlib
from typing import Annotated, Any

from fastapi import APIRouter, Path, Request, Response
from fastapi.responses import JSONResponse, RedirectResponse

from rumu.errors import GalleryError
from rumu.gallery.iiif import collection_manifest, manifest
from rumu.gallery.iiif_image import BadImageRequest, image_info
from rumu.studio import worker_tasks
from rumu.studio.errors import Missing
from rumu.web.dependencies import PathId, ServiceDep
from rumu.web.files import FileContent
from rumu.web.responses import file_response, requested_etags
from rumu.web.routes.works import find_work

router = APIRouter(tags=["iiif"])
CORS = {"Access-Control-Allow-Origin": "*"}
PathWord = Annotated[str, Path(max_length=80)]


@router.get("/iiif/works/{work_id}/manifest.json", response_class=JSONResponse)
def get_manifest(request: Request, service: ServiceDep, work_id: PathId) -> Response:
    """The manifest of a work."""
    find_work(service, work_id)
    return _iiif_response(manifest(service.gallery, work_id, base=_base_url(request)), "presentation")


@router.get("/iiif/collections/{collection_id}.json", response_class=JSONResponse)
def get_collection_manifest(request: Request, service: ServiceDep, collection_id: PathId) -> Response:
    """The manifests of a collection's works."""
    try:
        facts = collection_manifest(service.gallery, collection_id, base=_base_url(request))
    except GalleryError as error:
        raise Missing(zh="沒有這個集子。", en="There is no such collection.") from error
    return _iiif_response(facts, "presentation")


@router.get("/iiif/image/{work_id}", include_in_schema=False)
def redirect_to_info(work_id: PathId) -> Response:
    """The Image API redirects the base URI of a picture to its description."""
    return RedirectResponse(f"/iiif/image/{work_id}/info.json", 303, headers=CORS)


@router.get("/iiif/image/{work_id}/info.json", response_class=JSONResponse)
def get_image_info(request: Request, service: ServiceDep, work_id: PathId) -> Response:
    """In what sizes and parts a picture is served."""
    find_work(service, work_id)
    facts = image_info(service.gallery, work_id, base=f"{_base_url(request)}/iiif/image")
    return _iiif_response(facts, "image")


@router.get("/iiif/image/{work_id}/{region}/{size}/{rotation}/{name}", response_class=Response)
def get_image_part(
    *,
    request: Request,
    service: ServiceDep,
    work_id: PathId,
    region: PathWord,
    size: PathWord,
    rotation: PathWord,
    name: PathWord,
) -> Response:
    """A part of a picture, as the Image API names it. name: default.jpg and the like."""
    work = find_work(service, work_id)
    quality, _, ending = name.rpartition(".")
    path = "/".join((work.digest, region, size, rotation, name))
    etag = hashlib.sha256(path.encode("utf-8", "replace")).hexdigest()[:20]
    data, kind = b"", ""
    if etag not in requested_etags(request.headers):
        try:
            data, kind = service.workers.call(
                worker_tasks.image_part,
                work_id=work_id,
                words=(region, size, rotation, quality, ending),
            )
        except BadImageRequest as error:
            facts = {"error": {"code": "image_request", "zh": "圖像請求不合規範。", "en": str(error)}}
            return JSONResponse(facts, 400, headers=CORS)
    response = file_response(request, FileContent(data, None, kind, etag))
    response.headers.update(CORS)
    return response


def _iiif_response(facts: dict[str, Any], api: str) -> Response:
    """api: 'presentation' or 'image'."""
    profile = f"http://iiif.io/api/{api}/3/context.json"
    return JSONResponse(facts, media_type=f'application/ld+json;profile="{profile}"', headers=CORS)


def _base_url(request: Request) -> str:
    return str(request.base_url).rstrip("/")
