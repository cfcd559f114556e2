"""The photographs of a capture as one stack: of one size, one way round, linear, less the ambient light."""

from __future__ import annotations

import warnings
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal, get_args

import numpy as np

from rumu.capture.decoded_size import Header
from rumu.capture.description import DESCRIPTION
from rumu.capture.formats import DISPLAY_FORMATS, Encoding, read_header
from rumu.capture.image import read_photograph
from rumu.capture.memory_plan import MemoryPlan, plan_memory
from rumu.capture.photographs import capture_error, place
from rumu.capture.stored import turn
from rumu.errors import ImageError
from rumu.image_stack import ImageStack, Photograph, Progress, ScratchFile
from rumu.values import Bilingual, BoolArray, FloatArray

_AMBIENT_MARGIN = 0.01  # of white, by which the picture without lamps may be brighter: noise, JPEG
_LOOKED_AT = 500_000  # about how many pixels of a photograph its median is taken of

Orientation = Literal["auto", "stored", "exif"]
ORIENTATIONS: tuple[Orientation, ...] = get_args(Orientation)


@dataclass(frozen=True, slots=True, eq=False)
class Frames:
    """The photographs of a capture.

    stack: N photographs in their own bits. upright: whether they were turned as EXIF says. orientation: the
    same in words, None where EXIF says nothing. notes: what a person should know. opaque: (H, W), where no
    photograph is transparent; None where none is anywhere.
    """

    stack: ImageStack
    upright: bool
    orientation: Literal["stored", "exif"] | None
    notes: tuple[Bilingual, ...]
    opaque: BoolArray | None = None


def read_frames(
    paths: tuple[Path, ...],
    *,
    as_shown: bool,
    ambient: Path | None,
    encoding: Encoding,
    orientation: Orientation,
    progress: Progress | None = None,
) -> Frames:
    """The photographs as one stack, less the ambient frame, all turned the same way or none.

    as_shown: whether the lamps are told by how the pictures look on a screen; then 'auto' turns them.
    Raises CaptureError where they differ in size, and before anything is decoded where there is too little
    memory for them; ImageError where one cannot be read.
    """
    upright = orientation == "exif" or (orientation == "auto" and as_shown)
    files = paths if ambient is None else (*paths, ambient)
    headers = [_header_of(path) for path in files]
    plan = plan_memory(headers, paths[0].parent)
    reader = _Reader(plan, encoding, progress)
    read = reader.read(files, upright=upright, alike=orientation == "auto")
    if read is None:  # they say different things
        upright = False
        read = reader.read(files, upright=False, alike=False)
    assert read is not None
    photographs, told = [one for one, _ in read], [orientation for _, orientation in read][: len(paths)]
    for path, one in zip(files, photographs, strict=True):
        _check_same_size(path, one, paths[0], photographs[0])
    dark = None if ambient is None else photographs.pop()
    if ambient is not None and dark is not None:
        _check_ambient(ambient, dark, paths, photographs)
    _check_alike(paths, photographs)
    turned = _orientation_notes(paths, told, upright=upright)
    kinds = [one.format for one in headers[: len(paths)]]
    by_profile = _encoding_notes(paths, photographs, kinds) if encoding == "auto" else ()
    opaque, seen_through = _opaque(paths, photographs)
    stack = ImageStack(photographs, dark=dark, peak=max(1.0, _peak(photographs, dark)))
    shown: Literal["exif", "stored"] = "exif" if upright else "stored"
    notes = (*turned, *by_profile, *seen_through)
    return Frames(stack, upright, shown if turned else None, notes, opaque)


def _opaque(
    paths: tuple[Path, ...], photographs: list[Photograph]
) -> tuple[BoolArray | None, tuple[Bilingual, ...]]:
    """(H, W) where no photograph is transparent, None where none is anywhere, and a note of it.

    Raises CaptureError where nothing is opaque in all.
    """
    cut = [(path, one.opaque) for path, one in zip(paths, photographs, strict=True) if one.opaque is not None]
    if not cut:
        return None, ()
    opaque = np.logical_and.reduce([each for _, each in cut])
    where = place(cut[0][0])
    if not opaque.any():
        raise capture_error(
            where,
            en="transparent, as are perhaps others: no place is opaque in all photographs; save them without "
            "transparency (alpha)",
            zh="是透明的，別張或許也是：沒有一處在所有照片裡都不透明；請存成不帶透明度（alpha）的照片",
        )
    share = f"{100 * (1 - opaque.mean()):.0f}%"
    note = Bilingual(
        f"{where.zh} 等 {len(cut)} 張照片有透明的地方（佔 {share}），當作不在遮罩內。",
        f"{len(cut)} photographs ({where.en}...) are transparent in places ({share}), which are taken to be "
        "outside the mask",
    )
    return opaque, (note,)


def _header_of(path: Path) -> Header:
    try:
        return read_header(path)
    except ImageError as error:
        raise with_file_name(error, path) from error


@dataclass(frozen=True, slots=True)
class _Reader:
    """Decodes photographs, several at a time."""

    plan: MemoryPlan
    encoding: Encoding
    progress: Progress | None

    def read(
        self, paths: tuple[Path, ...], *, upright: bool, alike: bool
    ) -> list[tuple[Photograph, int]] | None:
        """Each photograph, and its EXIF orientation, by which it was turned if `upright`.

        None where all were to be turned `alike` and their orientations differ.
        """
        read: list[tuple[Photograph, int]] = []
        # A decoder sets the filters of warnings for its own time, which threads do for each other, too.
        with warnings.catch_warnings(), ThreadPoolExecutor(self.plan.threads) as pool:
            waiting = [pool.submit(self._read_one, path, upright=upright) for path in paths]
            try:
                for job in waiting:
                    read.append(job.result())
                    if self.progress is not None:
                        self.progress("Reading photographs", len(read), len(paths))
                    if upright and alike and read[-1][1] != read[0][1]:
                        return None
            finally:
                pool.shutdown(wait=True, cancel_futures=True)
        return read

    def _read_one(self, path: Path, *, upright: bool) -> tuple[Photograph, int]:
        photograph, told = read_named(path, encoding=self.encoding, upright=upright)
        return kept(photograph, on_disk=self.plan.on_disk), told


def read_named(path: Path, *, encoding: Encoding, upright: bool) -> tuple[Photograph, int]:
    """A photograph in memory, and its EXIF orientation, by which it is turned if `upright`.

    Raises ImageError that names the file alone.
    """
    try:
        photograph, told = read_photograph(path, encoding=encoding)
    except ImageError as error:
        raise with_file_name(error, path) from error
    assert isinstance(photograph.samples, np.ndarray)
    if not upright:
        return replace(photograph, samples=np.ascontiguousarray(photograph.samples)), told
    opaque = None if photograph.opaque is None else turn(photograph.opaque, told)
    samples = np.ascontiguousarray(turn(photograph.samples, told))
    return replace(photograph, samples=samples, opaque=opaque), told


def kept(photograph: Photograph, *, on_disk: bool) -> Photograph:
    """The photograph, in a scratch file where memory is short."""
    if not on_disk or isinstance(photograph.samples, ScratchFile):
        return photograph
    return replace(photograph, samples=ScratchFile(photograph.samples))


def _some(photograph: Photograph) -> FloatArray:
    """(P[, 3]) linear light of some pixels of a photograph, all over it."""
    count = photograph.samples.shape[0] * photograph.samples.shape[1]
    return photograph.at(np.arange(0, count, max(1, count // _LOOKED_AT)))


def _check_ambient(
    ambient: Path, dark: Photograph, paths: tuple[Path, ...], photographs: list[Photograph]
) -> None:
    """Raise CaptureError where a frame is no brighter than without its lamp."""
    level = float(np.median(_some(dark)))
    for path, photograph in zip(paths, photographs, strict=True):
        if level > float(np.median(_some(photograph))) + _AMBIENT_MARGIN:
            raise capture_error(
                path,
                en=f"darker than {ambient.name}, which should show the sheet with all lamps off; was this "
                f"lamp off, or one on in {ambient.name}, or the exposure another one?",
                zh=f"比 {ambient.name} 還暗；{ambient.name} 應是關掉所有燈拍的。是這張的燈沒開，"
                f"還是 {ambient.name} 開著燈，或曝光不同",
            )


def _check_alike(paths: tuple[Path, ...], photographs: list[Photograph]) -> None:
    """Raise CaptureError when one picture stands under several names: no two photographs are equal.

    Frames that are black or white all over are told later for what they are.
    """
    seen: dict[bytes, int] = {}
    for i, photograph in enumerate(photographs):
        height, width = photograph.samples.shape[:2]
        row = photograph.range(height // 2 * width, (height // 2 + 1) * width)
        first = seen.setdefault(row.tobytes(), i)  # a row tells most frames apart
        if first != i and _shows_something(photograph) and _equal(photograph, photographs[first]):
            raise capture_error(
                paths[i],
                en=f"the same picture as {paths[first].name}, to the last pixel; each lamp needs a "
                "photograph of its own",
                zh=f"與 {paths[first].name} 完全相同；每盞燈要有自己的一張照片",
            )


def _shows_something(photograph: Photograph) -> bool:
    bounds = [(float(part.min()), float(part.max())) for part in photograph.parts()]
    return max(high for _, high in bounds) > min(low for low, _ in bounds)


def _equal(photograph: Photograph, other: Photograph) -> bool:
    return all(np.array_equal(a, b) for a, b in zip(photograph.parts(), other.parts(), strict=True))


def _peak(photographs: list[Photograph], dark: Photograph | None) -> float:
    """The brightest value of photographs of floats, less the ambient frame; at most 1 of all others."""
    floats = [one for one in photographs if one.samples.dtype.kind == "f"]
    stacks = [ImageStack([one], dark=dark) for one in floats]
    return max((float(stack.frame(0).max()) for stack in stacks), default=1.0)


def with_file_name(error: ImageError, path: Path) -> ImageError:
    """The error with the name of the file alone: the folders above it are those of a server, perhaps."""
    zh = None if error.zh is None else error.zh.replace(str(path), path.name)
    return ImageError(str(error).replace(str(path), path.name), zh=zh)


def _encoding_notes(
    paths: tuple[Path, ...], photographs: list[Photograph], formats: list[str]
) -> tuple[Bilingual, ...]:
    """What is said of how levels became light: by colour profiles, and not alike for all photographs."""
    whole = [
        (path, one) for path, one in zip(paths, photographs, strict=True) if one.samples.dtype.kind == "u"
    ]
    shown = [path.name for path, one in whole if one.curve is not None]
    light = [path.name for path, one in whole if one.curve is None]
    by_profile = _profile_notes(paths, photographs, formats)
    if not shown or not light:
        return by_profile
    return (
        *by_profile,
        Bilingual(
            f"照片不是同一種：{shown[0]} 等 {len(shown)} 張當作螢幕用的值，"
            f"{light[0]} 等 {len(light)} 張當作光的量；"
            "若都由同一台相機、同樣存出，請用 --encoding 說明是哪一種（srgb 或 linear）。",
            f"the photographs are not of one kind: {len(shown)} ({shown[0]}...) were decoded as made for a "
            f"screen, {len(light)} ({light[0]}...) taken for light as it is; if all were saved alike, say "
            "which they are by --encoding (srgb or linear)",
        ),
    )


def _profile_notes(
    paths: tuple[Path, ...], photographs: list[Photograph], formats: list[str]
) -> tuple[Bilingual, ...]:
    """What is said of photographs that a colour profile, and not their format, made values for a screen."""
    decoded = [
        path.name
        for path, one, kind in zip(paths, photographs, formats, strict=True)
        if one.curve is not None and kind not in DISPLAY_FORMATS
    ]
    if not decoded:
        return ()
    names = ", ".join(decoded[:4]) + ("..." if len(decoded) > 4 else "")
    return (
        Bilingual(
            f"{names}：色彩描述檔（ICC）說是螢幕用的值，已照它換成光的量；"
            "若其實就是光的量，請用 --encoding linear。",
            f"{names}: decoded by their colour profiles (ICC), which say that they were made for a screen; "
            "if they hold light as it is, use --encoding linear",
        ),
    )


def _orientation_notes(paths: tuple[Path, ...], told: list[int], *, upright: bool) -> tuple[Bilingual, ...]:
    turned = [(path.name, one) for path, one in zip(paths, told, strict=True) if one != 1]
    if not turned:
        return ()
    names = ", ".join(name for name, _ in turned[:4]) + ("..." if len(turned) > 4 else "")
    values = ", ".join(sorted({str(one) for _, one in turned}))
    if upright:
        note = Bilingual(
            f"{names}：依 EXIF 方向（{values}）轉正了照片，燈的方向以轉正後的畫面為準。若燈是按相機存下的畫面"
            f'量的，請在 {DESCRIPTION} 寫 "orientation": "stored"。',
            f"{names}: turned upright as EXIF says (orientation {values}), with the lamps as in the picture "
            "that is shown. If they were measured in the picture that the camera stored, write "
            f'"orientation": "stored" in {DESCRIPTION}',
        )
    else:
        note = Bilingual(
            f"{names}：照片帶有 EXIF 方向（{values}），這裡不轉動照片：拍攝時相機不動，"
            f'燈的方向是按相機存下的畫面量的。若要轉正，請在 {DESCRIPTION} 寫 "orientation": "exif"。',
            f"{names}: EXIF asks to show them turned (orientation {values}); they are read as the camera "
            "stored them, since it stood still and lamps are measured in that picture. To turn them, write "
            f'"orientation": "exif" in {DESCRIPTION}',
        )
    return (note,)


def _check_same_size(path: Path, image: Photograph, first_path: Path, first: Photograph) -> None:
    shape, wanted = image.samples.shape, first.samples.shape
    if shape[:2] != wanted[:2]:
        raise capture_error(
            path,
            en=f"expected {size_of(wanted)} pixels as in {first_path.name}, got {size_of(shape)}",
            zh=f"應與 {first_path.name} 一樣是 {size_of(wanted)} 像素，卻是 {size_of(shape)}",
        )
    if len(shape) != len(wanted):
        kinds = {2: Bilingual("灰階", "gray"), 3: Bilingual("彩色", "colour")}
        raise capture_error(
            path,
            en=f"expected {kinds[len(wanted)].en} as in {first_path.name}, got {kinds[len(shape)].en}",
            zh=f"應與 {first_path.name} 一樣是{kinds[len(wanted)].zh}，卻是{kinds[len(shape)].zh}",
        )


def size_of(shape: tuple[int, ...]) -> str:
    """Width and height of (H, W, ...) as messages tell them."""
    return f"{shape[1]} x {shape[0]}"
