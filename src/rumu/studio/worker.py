"""What runs in the worker processes: marks, surfaces and jobs, so that those who browse never wait for
them."""

from __future__ import annotations

import io
import os
import pickle
import signal
import threading
import time
from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING, Any

from rumu.errors import RumuError
from rumu.studio.pictures import Kept, kept
from rumu.studio.place import Place

if TYPE_CHECKING:
    from collections.abc import Callable

    from rumu.assessment.calibration import Calibration
    from rumu.assessment.measurement import PreparedMaster
    from rumu.gallery.derived import DerivedFile
    from rumu.gallery.gallery import Gallery
    from rumu.values import FloatArray

_MASTERS = 12  # surfaces of masters that stay in memory of each process


@dataclass(frozen=True, slots=True)
class Marked:
    """A copy as it is kept, its mark (see marking.mark_facts) and its residual points, None when refused."""

    picture: Kept
    facts: dict[str, Any]
    residual: dict[str, list[list[float]]] | None


def begin() -> None:
    """Of a worker process: it ends with its parent, however that ended, and leaves Ctrl-C to it."""
    import multiprocessing

    import cv2

    signal.signal(signal.SIGINT, signal.SIG_IGN)
    cv2.setNumThreads(1)
    if hasattr(os, "nice"):
        os.nice(15)  # where cores are few, who looks goes before who is marked
    parent = multiprocessing.parent_process()
    if parent is not None:
        threading.Thread(target=_end_with, args=(parent,), daemon=True).start()


def _end_with(parent: Any) -> None:
    parent.join()
    os._exit(1)


def answered(work: Callable[..., Any], place: Place, terms: dict[str, Any]) -> Any:
    """`work(place, **terms)`; an error that cannot travel between processes is told by its words."""
    try:
        return work(place, **terms)
    except Exception as error:
        try:
            pickle.loads(pickle.dumps(error))
        except Exception:
            raise RumuError(f"{type(error).__name__}: {error}") from None
        raise


def ready(place: Place) -> int:
    """Load everything that a mark needs, by marking a starter work against itself; the process's id."""
    from rumu import pipeline
    from rumu.gallery.starter import starter_works

    work = starter_works(script="regular")[0]
    pipeline.assess(work.path, work.path, calibration=_calibration(place))
    _gallery(place)
    return os.getpid()


def mark(place: Place, *, data: bytes, work_id: str, digest: str, script: str) -> Marked:
    """The mark of a picture against a work. digest: of the work, so that a changed one is read anew.

    Raises Unusable for what is no picture.
    """
    from rumu import pipeline
    from rumu.studio.marking import mark_facts, residual_facts

    started = time.perf_counter()
    picture = kept(data)
    assessment = pipeline.assess(
        _samples(picture),
        _master(place, work_id, digest),
        script=script or None,
        calibration=_calibration(place),
    )
    registration = assessment.registration
    residual = None if registration is None else residual_facts(registration)
    return Marked(picture, mark_facts(assessment, seconds=time.perf_counter() - started), residual)


def derived_file(
    place: Place, *, kind: str, exaggeration: float, work_id: str | None = None, picture: str | None = None
) -> DerivedFile:
    """A file derived from a work, or from a picture of the store; made when it is not there yet."""
    from rumu.gallery.assets import assets_of, picture_assets
    from rumu.gallery.catalog import work
    from rumu.gallery.derived import derived_of

    gallery = _gallery(place)
    store = gallery.store
    original = assets_of(store, work(gallery, work_id)) if work_id else picture_assets(store, str(picture))
    return derived_of(store, original, kind, exaggeration=exaggeration)


def image_part(place: Place, *, work_id: str, words: tuple[str, str, str, str, str]) -> tuple[bytes, str]:
    """A part of a work's picture, see `rumu.gallery.iiif_image.image_response`."""
    from rumu.gallery.iiif_image import image_response

    return image_response(_gallery(place), work_id, *words)


def add_work(place: Place, *, data: bytes, facts: dict[str, str], spacing: float | None) -> str:
    """Keep a picture as a work; its id."""
    from rumu.studio import additions

    return additions.add_work(_gallery(place), data, facts, spacing=spacing)


def job(place: Place, *, job_id: str) -> None:
    """Do a job that was taken from the queue, see rumu.studio.jobs."""
    from rumu.studio.jobs import perform

    perform(_gallery(place), job_id, place=place)


def _samples(picture: Kept) -> FloatArray:
    """The kept picture, as it will be seen again, as values in [0, 1]."""
    import numpy as np
    from PIL import Image

    with Image.open(io.BytesIO(picture.data)) as image:
        return np.asarray(image, dtype=np.float32) / np.float32(255)


@lru_cache(maxsize=2)
def _gallery(place: Place) -> Gallery:
    return place.open()


@lru_cache(maxsize=_MASTERS)
def _master(place: Place, work_id: str, digest: str) -> PreparedMaster:
    from rumu import pipeline
    from rumu.gallery.assets import assets_of
    from rumu.gallery.catalog import work

    gallery = _gallery(place)
    return pipeline.prepare_master(assets_of(gallery.store, work(gallery, work_id)).surface())


@lru_cache(maxsize=2)
def _calibration(place: Place) -> Calibration | None:
    from rumu.assessment.calibration import load_calibration

    return None if place.calibration is None else load_calibration(place.calibration)
