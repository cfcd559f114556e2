"""Tiles of a work for deep zoom under a lamp: its albedo and its normals, each a IIIF image service."""

from __future__ import annotations

import hashlib
import io
from typing import Annotated

from fastapi import APIRouter, Path, Query, Request, Response
from fastapi.responses import JSONResponse, RedirectResponse

from rumu.database.tables import Work
from rumu.gallery.assets import Assets, assets_of
from rumu.gallery.tile_maps import MapName, has_tiles, stored_tiles, tiles_etag
from rumu.gallery.tiles import MEDIA_TYPES, TileSet, encode_jpeg
from rumu.studio import worker_tasks
from rumu.studio.errors import Missing
from rumu.web.addresses import base_url, service_url
from rumu.web.dependencies import PathId, ServiceDep
from rumu.web.files import FileContent
from rumu.web.responses import file_response, requested_etags
from rumu.web.routes.works import find_work
from rumu.web.service import Service

router = APIRouter(tags=["iiif"])
PathWord = Annotated[str, Path(max_length=80)]
Version = Annotated[str | None, Query(max_length=80, description="The version, as the viewer has it.")]

_MAKING_SECONDS = 600.0  # that the tiles of the largest work may take on a slow machine
_DAY = "public, max-age=86400"  # of an address without a version; pictures of works do not change


@router.get("/iiif/tiles/{name}/{work_id}", include_in_schema=False)
def redirect_to_tile_info(name: MapName, work_id: PathId) -> Response:
    """The Image API redirects the base URI of a picture to its description."""
    return RedirectResponse(service_url(f"/iiif/tiles/{name}/{work_id}/info.json"), 303)


@router.get("/iiif/tiles/{name}/{work_id}/info.json", response_class=JSONResponse)
def get_tile_info(
    request: Request, service: ServiceDep, name: MapName, work_id: PathId, v: Version = None
) -> Response:
    """In what tiles a map of a work is served: its albedo, sRGB, or normals, n = value / 127.5 - 1, y up.

    Heights are levels, 256 * red + green; `heights` says their scale and offset, as they are in `unit` of the
    work. Of one that was measured also its picture and, where they are, its photographs under three lamps.
    They are made when they are first asked for, which takes a minute for the largest works. There are none
    of a work of at most 1024 pixels, and no normals of one that no surface can be made of.
    """
    work = find_work(service, work_id)
    facts = _tiles(service, work, name, assets_of(service.gallery.store, work)).info
    facts = {"@context": facts["@context"], "id": f"{base_url(request)}/iiif/tiles/{name}/{work_id}"} | facts
    profile = "http://iiif.io/api/image/3/context.json"
    return JSONResponse(facts, media_type=f'application/ld+json;profile="{profile}"')


@router.get("/iiif/tiles/{name}/{work_id}/{region}/{size}/{rotation}/{file}", response_class=Response)
def get_tile(
    *,
    request: Request,
    service: ServiceDep,
    name: MapName,
    work_id: PathId,
    region: PathWord,
    size: PathWord,
    rotation: PathWord,
    file: PathWord,
    v: Version = None,
) -> Response:
    """A tile of a map. file: default.jpg, and of normals default.png, too."""
    work = find_work(service, work_id)
    suffix = file.rpartition(".")[2]
    assets = assets_of(service.gallery.store, work)
    path = "/".join((tiles_etag(assets, name), region, size, rotation, file))
    etag = hashlib.sha256(path.encode("utf-8", "replace")).hexdigest()[:20]
    immutable = v == tiles_etag(assets, "albedo")
    if etag in requested_etags(request.headers):
        return file_response(request, FileContent(b"", None, "", etag), immutable=immutable)
    data = _tile_bytes(_tiles(service, work, name, assets), region, size, rotation, file)
    if data is None:
        raise Missing(zh="沒有這一塊圖。", en="There is no such tile.")
    content = FileContent(data, None, MEDIA_TYPES[suffix], etag)
    response = file_response(request, content, immutable=immutable)
    if not immutable:
        response.headers["Cache-Control"] = _DAY
    return response


def _tiles(service: Service, work: Work, name: MapName, assets: Assets) -> TileSet:
    """The tile set of a map, made if need be. Raises Missing where there is none."""
    if not has_tiles(work):
        raise Missing(zh="這件作品不必分塊。", en="The work is too small for tiles.")
    tiles = stored_tiles(service.gallery.store, assets, name)
    if tiles is None:
        service.workers.call(worker_tasks.make_tiles, timeout=_MAKING_SECONDS, work_id=work.id, name=name)
        tiles = stored_tiles(service.gallery.store, assets, name)
    if tiles is None:  # deleted this very moment
        raise Missing(zh="沒有這一塊圖。", en="There is no such tile.")
    return tiles


def _tile_bytes(tiles: TileSet, region: str, size: str, rotation: str, file: str) -> bytes | None:
    """A tile under the name that a request gives it; None if there is none."""
    if region == "full":
        region = "0,0,{width},{height}".format(**tiles.info)
    if size == "max":
        size = "{width},{height}".format(**tiles.info["sizes"][0])
    data = tiles.read(f"{region}/{size}/{rotation}/{file}")
    if data is not None or file != "default.jpg":
        return data
    png = tiles.read(f"{region}/{size}/{rotation}/default.png")
    return None if png is None else _as_jpeg(png)


def _as_jpeg(png: bytes) -> bytes:
    """A tile that is stored as a PNG, for viewers that ask for JPEG, as all may at this level."""
    import numpy as np
    from PIL import Image

    return encode_jpeg(np.asarray(Image.open(io.BytesIO(png))))
