"""The photographs that a list of lamps means, and what a person should know of them."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from pathlib import Path

import numpy as np

from rumu.capture.light_files import LampLine
from rumu.capture.photographs import FolderImages, capture_error, named_path, place
from rumu.values import Bilingual, FloatArray


def photographs_named(
    lamps: Sequence[LampLine], images: FolderImages, leave_out: Collection[str]
) -> tuple[dict[Path, LampLine], frozenset[str]]:
    """Photograph -> its lamp, by the names of the lamps, and which of `leave_out` are not there.

    Raises CaptureError for a photograph that is not there, or that two lamps mean.
    """
    found: dict[Path, LampLine] = {}
    gone: set[str] = set()
    for lamp in lamps:
        image = images.find(lamp.name)
        if image is None:
            gone |= images.left_out(lamp.where, lamp.name, leave_out)
            continue
        if image in found:
            before = found[image].where
            raise capture_error(
                lamp.where,
                en=f"{image.name} was named before, in {before.en}",
                zh=f"{image.name} 在 {before.zh} 已經出現過",
            )
        found[image] = lamp
    return found, frozenset(gone)


def name_notes(path: Path, images: FolderImages, found: Mapping[Path, LampLine]) -> list[Bilingual]:
    """Notes of photographs that the file calls otherwise, and of those that it does not name."""
    return [*_other_names(path.parent, found), *_not_named(path, images, found)]


def _other_names(folder: Path, found: Mapping[Path, LampLine]) -> list[Bilingual]:
    """A note when images were read that the lamp file calls otherwise."""
    other = [
        (lamp, image)
        for image, lamp in found.items()
        if image.resolve() != Path(folder, named_path(lamp.name)).resolve()
    ]
    if not other:
        return []
    (lamp, image), more = other[0], len(other) - 1
    read = image.name if image.parent.resolve() == folder.resolve() else f"{image.parent.name}/{image.name}"
    return [
        Bilingual(
            f"{lamp.where.zh}：找不到 {lamp.name}，改讀 {read}"
            + (f"；另有 {more} 行也是這樣。" if more else "。"),
            f"{lamp.where.en}: {lamp.name} is not there, {read} was read instead"
            + (f"; likewise for {more} more" if more else ""),
        )
    ]


def _not_named(path: Path, images: FolderImages, found: Mapping[Path, LampLine]) -> list[Bilingual]:
    """A note when photographs lie among those that the lamp file names, of which it names no lamp."""
    left = [image.name for image in images.besides(tuple(found))]
    if not left:
        return []
    names, more = left[:3], "..." if len(left) > 3 else ""
    return [
        Bilingual(
            f"{path.name} 沒有提到 {len(left)} 張照片，因此不用：{'、'.join(names)}{more}",
            f"{path.name} does not name {len(left)} of the photographs, which are not used: "
            f"{', '.join(names)}{more}",
        )
    ]


def told_strengths(path: Path, lamps: tuple[LampLine, ...]) -> tuple[FloatArray | None, list[Bilingual]]:
    """(N,) strengths of mean 1, None where the file tells none or the same for all, and what to say."""
    told = [lamp.strength for lamp in lamps if lamp.strength is not None]
    if told and len(told) < len(lamps):
        bare = next(lamp for lamp in lamps if lamp.strength is None)
        raise capture_error(
            bare.where,
            en="expected the strength of the lamp after x y z, as on other lines, got none",
            zh="x y z 之後應像別的行一樣有燈的強度，這裡卻沒有",
        )
    values = np.array(told)
    if not told or np.allclose(values, values[0], rtol=1e-6):
        return None, []
    where = place(path)
    note = Bilingual(
        f"{where.zh}：x y z 之後的數當作燈的強度（{values.min():.3g} 到 {values.max():.3g}）。",
        f"{where.en}: what follows x y z is taken for the strength of the lamp "
        f"({values.min():.3g} to {values.max():.3g})",
    )
    return values / values.mean(), [note]


def check_count(path: Path, lamps: int, images: FolderImages) -> None:
    """Raise CaptureError unless there are as many images as lamps, which are taken in natural order."""
    count = len(images.photographs)
    if count != lamps:
        raise capture_error(
            path,
            en=f"holds {lamps} lamps, but {count} images lie beside it",
            zh=f"裡面有 {lamps} 盞燈，旁邊卻有 {count} 張照片",
        )
