"""A capture folder becomes a Capture: photographs, lamps, mask, ambient frame, scale.

A folder holds the photographs of one sheet, one lamp each, and one file that says where the lamps stood:

    NAME.lp                  names each image beside its lamp; the images may lie in other folders
    light_directions*.txt    3 x N or N x 3 numbers; the images are taken in natural order
    capture.json             {"slant": 45} for images a, b, c (tilt 0, 90, 180) and d (270), the paper's kind

and may hold a mask, an ambient frame and, in capture.json beside any of them, spacing_mm and encoding.
"""

from __future__ import annotations

import os
import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from rumu.capture.decoded_size import check_memory
from rumu.capture.formats import ENCODINGS, Encoding, read_header
from rumu.capture.image import read_linear, read_mask
from rumu.capture.light_files import Description, read_description, read_directions, read_lp
from rumu.capture.lights import direction
from rumu.containment import FolderFiles
from rumu.errors import CaptureError, ImageError
from rumu.values import BoolArray, Capture, FloatArray

_SUFFIXES = (".png", ".jpg", ".jpeg", ".tif", ".tiff", ".exr", ".webp", ".bmp", ".gif", ".pgm", ".ppm")
_PAPER_TILTS = {"a": 0.0, "b": 90.0, "c": 180.0, "d": 270.0}
_DESCRIPTION = "capture.json"
_ONE_PLANE = 1e-3  # smallest singular value of the lamps that still says three directions


@dataclass(frozen=True, slots=True, eq=False)
class _Lamps:
    """The photographs, their lamps, and the file that says where the lamps stood."""

    images: tuple[Path, ...]
    lights: FloatArray
    file: Path


def read_capture(
    path: str | os.PathLike[str], *, encoding: Encoding = "auto", within: Path | None = None
) -> Capture:
    """Read a capture folder.

    Parameters
    ----------
    path : path
        A folder, or the .lp, light_directions*.txt or capture.json in it that says where the lamps stood. Of
        several kinds in one folder the .lp wins, since it names its images; then light_directions*.txt.
    encoding : {'auto', 'linear', 'srgb'}
        'auto' takes JPEG and WebP as sRGB and everything else as linear; 'linear' or 'srgb' says it outright,
        and so does "encoding" in capture.json, which is used when `encoding` is 'auto'.
    within : path, optional
        A folder that holds the capture and every file that may be read, such as that of an upload. Without it
        an .lp and capture.json may name files anywhere.

    Returns
    -------
    Capture
        images: (N, H, W) or (N, H, W, 3) float32, linear, in [0, 1]; lights: (N, 3) unit vectors toward the
        lamps; mask: (H, W) bool, all True where no mask was found; spacing: millimetres per pixel or None.

    Raises
    ------
    CaptureError, ImageError
        Naming the file and what was expected there.

    Notes
    -----
    An image named ambient (the lamps off) is subtracted, and what falls below 0 becomes 0. When any float
    image exceeds 1, all are divided by the one brightest value, so that their ratios stay.
    The mask is "mask" of capture.json, else mask.png, else NAME.mask.png, else mask.png one folder up when
    no photographs lie beside it.
    """
    if encoding not in ENCODINGS:
        raise CaptureError(f"encoding: expected one of {', '.join(ENCODINGS)}, got {encoding!r}")
    folder, named = _split_path(Path(path))
    files = None if within is None else FolderFiles(within)
    if files is not None:
        _check_links(folder, files)
    description_file = folder / _DESCRIPTION
    description = read_description(description_file) if description_file.is_file() else Description()
    lamps = _read_lamps(folder, named, description, files=files)
    _check_lamps(lamps)
    chosen = _encoding_of(folder, description) if encoding == "auto" else encoding
    images = _read_images(lamps.images, ambient=_image_by_stem(folder, "ambient"), encoding=chosen)
    return Capture(
        images=images,
        lights=lamps.lights,
        mask=_read_folder_mask(folder, description, files=files, shape=images.shape[1:3]),
        spacing=description.spacing_mm,
        names=tuple(
            image.relative_to(folder).as_posix() if image.is_relative_to(folder) else str(image)
            for image in lamps.images
        ),
    )


def _split_path(path: Path) -> tuple[Path, Path | None]:
    if path.is_dir():
        return path, None
    if not path.exists():
        raise CaptureError(f"{path}: expected a capture folder or its .lp file, there is no such file")
    if path.suffix.lower() in (".lp", ".txt", ".json"):
        return path.parent, path
    raise CaptureError(f"{path}: expected a capture folder or its .lp file, got another kind of file")


def _check_links(folder: Path, files: FolderFiles) -> None:
    """Raise CaptureError for a link in the folder of an upload that leads out of it."""
    for path in folder.iterdir():
        if path.is_symlink() and not files.holds(path):
            raise CaptureError(
                f"{path}: leads out of the capture", zh=f"{path.name}：指向這組照片以外的檔案。"
            )


def _encoding_of(folder: Path, description: Description) -> Encoding:
    for known in ENCODINGS:
        if description.encoding in (known, None):
            return known
    raise CaptureError(
        f'{folder / _DESCRIPTION}: expected "encoding" among {", ".join(ENCODINGS)}, '
        f"got {description.encoding!r}"
    )


# --- which images, which lamps ---------------------------------------------------------------------


def _read_lamps(
    folder: Path, named: Path | None, description: Description, *, files: FolderFiles | None
) -> _Lamps:
    file = named or _lamp_file(folder, description)
    kind = file.suffix.lower()
    if kind != ".json" and description.slant is not None:
        raise CaptureError(
            f'{folder}: {file.name} says where the lamps stood and so does "slant" in {_DESCRIPTION}; '
            "keep one of them"
        )
    if kind == ".lp":
        return _from_lp(file, files)
    return _from_json(file, description) if kind == ".json" else _from_table(file)


def _lamp_file(folder: Path, description: Description) -> Path:
    for kind in (r".+\.lp", r"light_directions.*\.txt"):
        found = [p for p in _files(folder) if re.fullmatch(kind, p.name, re.IGNORECASE)]
        if len(found) > 1:
            names = ", ".join(p.name for p in found)
            raise CaptureError(f"{folder}: found {names}; expected one, or the path of the one to use")
        if found:
            return found[0]
    if description.slant is not None:
        return folder / _DESCRIPTION
    raise CaptureError(
        f"{folder}: expected an .lp file, light_directions.txt, or {_DESCRIPTION} with a slant, found none"
    )


def _from_lp(path: Path, files: FolderFiles | None) -> _Lamps:
    lines = read_lp(path)
    images = []
    for line in lines:
        image = _find_named(path.parent, line.name, files)
        if image is None:
            raise CaptureError(
                f"{line.where}: expected the image {line.name}, there is no such file",
                zh=f"{path.name} 所列的照片 {line.name} 不在這裡；請一併放入，或更正檔名。",
            )
        images.append(image)
    return _Lamps(tuple(images), np.array([line.light for line in lines]).reshape(-1, 3), path)


def _find_named(folder: Path, name: str, files: FolderFiles | None) -> Path | None:
    """The file of a name; where that is not found, as from another machine, one of its last part here.

    files: of an upload, which alone may be found; None for any files of this machine.
    """
    forward = name.replace("\\", "/")
    last = forward.rsplit("/", 1)[-1]
    if files is not None:
        return files.find(name, beside=folder) or files.find(last, beside=folder)
    for candidate in (folder / name, folder / forward, folder / last):
        if candidate.is_file():
            return candidate
    return None


def _from_table(path: Path) -> _Lamps:
    lights = read_directions(path)
    images = _photographs(path.parent)
    if len(images) != len(lights):
        raise CaptureError(f"{path}: holds {len(lights)} lamps, but {len(images)} images lie beside it")
    return _Lamps(tuple(images), lights, path)


def _from_json(path: Path, description: Description) -> _Lamps:
    if description.slant is None:
        raise CaptureError(f'{path}: expected "slant", the degrees of the lamps from straight above')
    given = bool(description.tilts)
    tilts = description.tilts or _PAPER_TILTS
    images, lights = [], []
    for stem, tilt in tilts.items():
        image = _image_by_stem(path.parent, stem)
        if image is None and (given or stem != "d"):
            raise CaptureError(f"{path}: expected an image named {stem} (such as {stem}.png), found none")
        if image is not None:
            images.append(image)
            lights.append(direction(tilt=tilt, slant=description.slant))
    return _Lamps(tuple(images), np.array(lights), path)


def _files(folder: Path) -> list[Path]:
    """Files of a folder, by name, without hidden ones: copying from a Mac leaves a ._NAME beside each."""
    try:
        return sorted(p for p in folder.iterdir() if p.is_file() and not p.name.startswith("."))
    except OSError as error:
        raise CaptureError(f"{folder}: cannot be read ({error.strerror})") from error


def _image_files(folder: Path) -> list[Path]:
    """Those that images may be, by their suffix."""
    return [p for p in _files(folder) if p.suffix.lower() in _SUFFIXES]


def _photographs(folder: Path) -> list[Path]:
    """Image files in natural order (2 before 10), without masks, the ambient frame and normal maps."""
    aside = re.compile(r"(.*\.)?(mask|ambient)|normals?(_gt)?", re.IGNORECASE)
    return sorted(
        (p for p in _image_files(folder) if not aside.fullmatch(p.stem)),
        key=lambda p: [(text, int(digits or 0)) for text, digits in re.findall(r"(\D*)(\d*)", p.name)],
    )


def _image_by_stem(folder: Path, stem: str) -> Path | None:
    """The one image of this name with any suffix, None when there is none."""
    found = [p for p in _image_files(folder) if p.stem.lower() == stem.lower()]
    if len(found) > 1:
        names = ", ".join(p.name for p in found)
        raise CaptureError(f"{folder}: expected one image named {stem}, found {names}")
    return found[0] if found else None


def _check_lamps(lamps: _Lamps) -> None:
    count = len(lamps.images)
    if count < 3:
        raise CaptureError(f"{lamps.file}: expected at least 3 images, got {count}")
    if float(np.linalg.svd(lamps.lights, compute_uv=False)[-1]) <= _ONE_PLANE:
        raise CaptureError(
            f"{lamps.file}: expected lamps from at least three sides, got {count} that lie in one plane"
        )


# --- pixels ----------------------------------------------------------------------------------------


def _read_images(paths: tuple[Path, ...], *, ambient: Path | None, encoding: Encoding) -> FloatArray:
    check_memory([read_header(path).image_memory() for path in paths], paths[0].parent)
    first = read_linear(paths[0], encoding=encoding)
    dark = None if ambient is None else read_linear(ambient, encoding=encoding)
    if ambient is not None and dark is not None:
        _check_same_size(ambient, dark, paths[0], first)
    images = np.empty((len(paths), *first.shape), dtype=np.float32)
    for i, path in enumerate(paths):
        image = first if i == 0 else read_linear(path, encoding=encoding)
        _check_same_size(path, image, paths[0], first)
        images[i] = image if dark is None else np.maximum(image - dark, 0)
    peak = float(images.max())
    if peak > 1:
        images /= np.float32(peak)
    return images


def _check_same_size(path: Path, image: FloatArray, first_path: Path, first: FloatArray) -> None:
    if image.shape[:2] != first.shape[:2]:
        raise CaptureError(
            f"{path}: expected {_size(first)} pixels as in {first_path.name}, got {_size(image)}"
        )
    if image.ndim != first.ndim:
        kinds = {2: "gray", 3: "colour"}
        raise CaptureError(
            f"{path}: expected {kinds[first.ndim]} as in {first_path.name}, got {kinds[image.ndim]}"
        )


def _size(image: FloatArray | BoolArray) -> str:
    return f"{image.shape[1]} x {image.shape[0]}"


def _read_folder_mask(
    folder: Path, description: Description, *, files: FolderFiles | None, shape: tuple[int, ...]
) -> BoolArray:
    path = _mask_file(folder, description, files)
    if path is None:
        return np.ones(shape, dtype=bool)
    try:
        mask = read_mask(path)
    except ImageError as error:
        raise CaptureError(f"mask {error}") from error
    if mask.shape != shape:
        raise CaptureError(f"{path}: expected a mask of {shape[1]} x {shape[0]} pixels, got {_size(mask)}")
    if not mask.any():
        raise CaptureError(f"{path}: expected a mask with white where the object is, it is black all over")
    return mask


def _mask_file(folder: Path, description: Description, files: FolderFiles | None) -> Path | None:
    if description.mask is not None:
        mask = _find_named(folder, description.mask, files)
        if mask is None:
            raise CaptureError(
                f"{folder / _DESCRIPTION}: expected the mask {description.mask}, there is no such file",
                zh=f"{_DESCRIPTION} 所指的遮罩 {description.mask} 不在這組照片裡；請一併放入。",
            )
        return mask
    plain = _image_by_stem(folder, "mask")
    if plain is not None:
        return plain
    named = [p for p in _image_files(folder) if p.stem.lower().endswith(".mask")]
    if len(named) > 1:
        raise CaptureError(f"{folder}: expected one mask, found {', '.join(p.name for p in named)}")
    if named:
        return named[0]
    above = _mask_above(folder.resolve().parent)
    return None if above is None or not (files is None or files.holds(above)) else above


def _mask_above(folder: Path) -> Path | None:
    """The mask that several captures share, one folder up; not one that belongs to photographs beside it."""
    try:
        return None if _photographs(folder) else _image_by_stem(folder, "mask")
    except CaptureError:  # the folder above need not be readable, nor in order
        return None
