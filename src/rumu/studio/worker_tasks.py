"""What runs in the worker processes: marks, surfaces and jobs, so that readers never wait for them."""

from __future__ import annotations

import os
from functools import lru_cache
from typing import TYPE_CHECKING, Any

from rumu.studio import job_handlers, sheet_printing, uploads
from rumu.studio.sheet_printing import SheetRequest
from rumu.studio.storage import Storage

if TYPE_CHECKING:
    from rumu.gallery.derived import DerivedFile, MeshShape
    from rumu.gallery.store import Gallery
    from rumu.gallery.tile_maps import MapName
    from rumu.pipeline import PreparedMaster
    from rumu.studio.attempts import MarkedCopy
    from rumu.studio.sheet_cells import ReadSheet

_MAX_MASTERS = 12  # prepared masters that stay in memory of each process


def warm_up(storage: Storage) -> int:
    """Load everything that a mark needs by marking a starter work against itself; return the process id."""
    from rumu import pipeline
    from rumu.gallery.starter import starter_works
    from rumu.studio.marking import load_calibration_of

    work = starter_works(script="regular")[0]
    pipeline.assess(work.path, work.path, calibration=load_calibration_of(storage))
    _open_gallery(storage)
    return os.getpid()


def mark(
    storage: Storage,
    *,
    data: bytes,
    work_id: str,
    digest: str,
    script: str,
    framed: bool = False,
) -> MarkedCopy:
    """Mark a picture against a work. digest: of the work, so that a changed one is read anew.

    script: of the work. framed: whether the picture is the cell that was written in.

    Raises Unusable when it is no picture.
    """
    from rumu.studio.marking import load_calibration_of, mark_copy

    master = _prepare_master(storage, work_id, digest)
    return mark_copy(
        data,
        master,
        script=script,
        calibration=load_calibration_of(storage),
        framed=framed,
    )


def read_sheet(storage: Storage, *, data: bytes) -> ReadSheet:
    """Find the cells of a photographed practice sheet. Raises Unusable, see `sheet_cells`."""
    from rumu.studio import sheet_cells

    return sheet_cells.read_sheet(_open_gallery(storage), data)


def mark_sheet_cells(
    storage: Storage, *, masters: str, character: str, pictures: list[bytes]
) -> list[MarkedCopy]:
    """Mark the cells of one character of a sheet."""
    from rumu.studio import sheet_cells
    from rumu.studio.marking import load_calibration_of

    calibration = load_calibration_of(storage)
    return sheet_cells.mark_cells(masters, character, pictures, calibration=calibration)


def look_at_photograph(
    storage: Storage, *, data: bytes, corners: list[list[float]] | None, around: bool = False
) -> dict[str, Any]:
    """Whether a picture is of a practice sheet, and the corners of the printed cell near or around some."""
    import numpy as np

    from rumu.gallery.assets import decode_picture
    from rumu.pages.cell_flatten import find_cell_around, refine_corners
    from rumu.pages.sheet_reading import is_sheet

    picture = np.asarray(decode_picture(data).convert("RGB"))
    sheet = is_sheet(picture)
    find = find_cell_around if around else refine_corners
    cell = find(picture, np.array(corners)) if corners is not None and not sheet else None
    return {"sheet": sheet, "cell": None if cell is None else cell.round(2).tolist()}


def flatten_cell(storage: Storage, *, data: bytes, corners: list[list[float]]) -> bytes:
    """Return the cell between four corners of a picture as a PNG. Raises ImageError for corners of none."""
    import numpy as np

    from rumu.gallery.assets import decode_picture
    from rumu.pages import cell_flatten
    from rumu.studio.sheet_cells import png_of

    picture = np.asarray(decode_picture(data).convert("RGB"))
    return png_of(cell_flatten.flatten_cell(picture, np.array(corners)))


def plan_sheet(storage: Storage, *, request: SheetRequest) -> dict[str, Any]:
    """What the pages of a practice sheet hold, see `sheet_printing`."""
    return sheet_printing.plan_sheet(_open_gallery(storage), request).facts


def print_sheet(storage: Storage, *, request: SheetRequest) -> bytes:
    """Return a practice sheet as a PDF."""
    return sheet_printing.print_sheet(_open_gallery(storage), request)


def preview_sheet(storage: Storage, *, request: SheetRequest, number: int) -> bytes:
    """Return a page of a practice sheet as a PNG."""
    return sheet_printing.preview_sheet(_open_gallery(storage), request, number)


def derived_file(
    storage: Storage,
    *,
    kind: str,
    shape: MeshShape,
    work_id: str | None = None,
    picture: str | None = None,
) -> DerivedFile:
    """Return a file derived from a work or from a stored picture; it is made when it does not exist yet."""
    from rumu.gallery.assets import assets_of, picture_assets
    from rumu.gallery.catalog import work
    from rumu.gallery.derived import derived_of

    gallery = _open_gallery(storage)
    store = gallery.store
    assets = assets_of(store, work(gallery, work_id)) if work_id else picture_assets(store, str(picture))
    return derived_of(store, assets, kind, shape=shape)


def image_part(storage: Storage, *, work_id: str, words: tuple[str, str, str, str, str]) -> tuple[bytes, str]:
    """Return a part of a work's picture, see `rumu.gallery.iiif_image.image_response`."""
    from rumu.gallery.iiif_image import image_response

    return image_response(_open_gallery(storage), work_id, *words)


def make_tiles(storage: Storage, *, work_id: str, name: MapName) -> None:
    """Make the tile set of a map of a work, see `rumu.gallery.tile_maps`."""
    from rumu.gallery.tile_maps import make_tiles as make

    make(_open_gallery(storage), work_id, name)


def add_work(storage: Storage, *, data: bytes, facts: dict[str, str], spacing: float | None) -> str:
    """Add a picture as a work and return its id."""
    return uploads.add_work(_open_gallery(storage), data, facts, spacing=spacing)


def run_job(storage: Storage, *, job_id: str) -> None:
    """Run a job that was taken from the queue."""
    job_handlers.run_job(_open_gallery(storage), job_id, storage=storage)


@lru_cache(maxsize=2)
def _open_gallery(storage: Storage) -> Gallery:
    """Open the gallery as it is; unlike `rumu.gallery.catalog.open_gallery` this adds nothing to it."""
    from rumu.database.engine import open_database
    from rumu.gallery.store import Gallery, Store

    return Gallery(open_database(storage.database), Store.open(storage.files))


@lru_cache(maxsize=_MAX_MASTERS)
def _prepare_master(storage: Storage, work_id: str, digest: str) -> PreparedMaster:
    from rumu import pipeline
    from rumu.gallery.assets import assets_of
    from rumu.gallery.catalog import work

    gallery = _open_gallery(storage)
    row = work(gallery, work_id)
    surface = assets_of(gallery.store, row).surface()
    return pipeline.prepare_master(surface, character=row.character, script=row.script)
