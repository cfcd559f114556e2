"""Pixels that contradict Lambert's law, solved again under the few materials that a capture shows.

What a material is, and how a normal is searched for, stands in `rumu.surface.reflectance`. Here its materials
are voted for, and each pixel takes the one that explains it clearly better than Lambert's law did. Where
nothing contradicts that law, as on paper and stone, nothing is changed. What contradicts it may also be wrong
lamps, light that is reflected twice, or shadow: materials that explain those bend normals from pixel to
pixel. The slopes of a surface have no curl, so materials are taken only when they leave no more of it than
Lambert's law did.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
import numpy.typing as npt

from rumu.image_stack import ImageStack
from rumu.surface.compiled import doubt_finder, material_fitter, tile_solver
from rumu.surface.lobe import learn_lobe, lobe_of, part_ground_and_gloss
from rumu.surface.reflectance import (
    LAMBERT,
    MATERIALS,
    Lamps,
    Material,
    MaterialFit,
    MaterialSettings,
    PixelValues,
    choose_materials,
    reflected,
    trusts,
    usual_error,
)
from rumu.surface.robust import RobustSettings, TileSolution, brightness_rows, span_of_lamps
from rumu.surface.stereo import gradients_from_normals
from rumu.values import BoolArray, FloatArray, IntArray


def find_materials(
    images: FloatArray | ImageStack,
    lights: FloatArray,
    *,
    mask: BoolArray,
    black_level: float = 0.0,
    settings: MaterialSettings | None = None,
) -> tuple[Material, ...]:
    """The materials that explain a capture clearly better than Lambert's law alone; none for most.

    images: (N, H, W[, 3]), linear; lights: (N, 3), times strength; mask: (H, W), where there is a surface.
    """
    settings = settings or MaterialSettings()
    stack = images if isinstance(images, ImageStack) else ImageStack.of_arrays(images)
    if len(lights) < settings.least_lamps:
        return ()
    options: dict[str, Any] = {"mask": mask, "black_level": black_level, "settings": settings}
    rows = _some_rows(stack, settings.pixels, seed=0, **options)
    if not len(rows):
        return ()
    usual = np.median(rows, axis=1)  # over the lamps, so that no highlight counts
    is_ink = usual < settings.ink * np.median(usual)  # too few to be heard among paper
    groups = [rows[which] for which in (~is_ink, is_ink) if np.count_nonzero(which) >= settings.fewest]
    chosen = tuple(dict.fromkeys(one for group in groups for one in _vote(group, lights, settings)))
    while chosen and _bends(stack, lights, chosen, **options):
        chosen = chosen[:-1]
    return _with_lobes(stack, lights, chosen, **options)


def _with_lobes(
    stack: ImageStack,
    lights: FloatArray,
    materials: tuple[Material, ...],
    *,
    mask: BoolArray,
    black_level: float,
    settings: MaterialSettings,
) -> tuple[Material, ...]:
    """The materials, those of gloss with the lobe that the pixels show which they explain best."""
    roughnesses = {one.roughness for one in materials if one.kind == "gloss"}
    if not roughnesses:
        return materials
    most = settings.lobe_values // len(lights)
    rows = _some_rows(stack, most, seed=1, mask=mask, black_level=black_level, settings=settings)
    seen, lamps, fit = _fitter_of(rows, lights, settings)
    tried = (LAMBERT, *materials)
    fits = [fit(one) for one in tried]
    which = np.stack([one.contradicted for one in fits]).argmin(axis=0)
    lobes = {}
    for roughness in roughnesses:
        parts = [
            (np.flatnonzero(which == k), fits[k].normals)
            for k, one in enumerate(tried)
            if one.kind == "gloss" and one.roughness == roughness
        ]
        pixels = np.concatenate([won for won, _ in parts])
        normals = np.concatenate([found[won] for won, found in parts])
        lobes[roughness] = learn_lobe(seen.chosen(pixels), lamps, normals, roughness, material=settings)
    return tuple(replace(one, lobe=lobes[one.roughness]) if one.kind == "gloss" else one for one in materials)


def _some_rows(
    stack: ImageStack,
    most: int,
    *,
    seed: int,
    mask: BoolArray,
    black_level: float,
    settings: MaterialSettings,
) -> FloatArray:
    """(P, N) the brightness of some pixels of a mask that are not all dark, at most so many."""
    # by chance: equal steps would fall on a few columns only
    count = int(np.count_nonzero(mask))
    some = _numbers(mask, np.unique(np.random.default_rng(seed).integers(0, count, most)))
    rows = brightness_rows(stack.at(some), black_level=black_level)
    return np.asarray(rows[rows.max(axis=1) > settings.seen * settings.step])


def _fitter_of(
    rows: FloatArray, lights: FloatArray, settings: MaterialSettings
) -> tuple[PixelValues, Lamps, Callable[[Material], MaterialFit]]:
    """Pixels (P, N) and lamps as materials are fitted to them, and what fits one."""
    lamps = Lamps(lights)
    seen = lamps.relative(rows, settings)
    starts = lamps.starts(seen, _unit(rows @ np.linalg.pinv(lights).T))
    return seen, lamps, partial(material_fitter(), seen, lamps, starts=starts, settings=settings)


def _numbers(mask: BoolArray, which: IntArray) -> IntArray:
    """The numbers of some pixels, told by their places among those of a mask."""
    return which if mask.all() else np.flatnonzero(mask)[which]


def _vote(rows: FloatArray, lights: FloatArray, settings: MaterialSettings) -> tuple[Material, ...]:
    """The materials that explain some pixels, rows (P, N), which Lambert's law does not."""
    seen, lamps, fit = _fitter_of(rows, lights, settings)
    plain = fit(LAMBERT)
    lambert = plain.contradicted
    # Where half of the lamps agree exactly, Lambert's law stands, and no material is looked at.
    doubtful = usual_error(seen, lamps, plain, settings) > settings.exact
    if lambert[doubtful].sum() <= settings.drop * len(lambert):
        return ()
    found = [fit(one).contradicted for one in MATERIALS[1:]]
    chosen = choose_materials(np.stack([lambert, *found], axis=1), settings=settings)
    return tuple(MATERIALS[one] for one in chosen)


def _bends(
    stack: ImageStack,
    lights: FloatArray,
    materials: Sequence[Material],
    *,
    mask: BoolArray,
    black_level: float,
    settings: MaterialSettings,
) -> bool:
    """Whether materials leave more curl in the slopes than Lambert's law, on patches all over the mask."""
    side, (height, width) = settings.patch_side, mask.shape
    count = int(np.count_nonzero(mask))
    middles = _numbers(mask, np.linspace(0, count - 1, settings.patches).astype(np.int64))
    tops = np.clip(middles // width - side // 2, 0, max(0, height - side))
    lefts = np.clip(middles % width - side // 2, 0, max(0, width - side))
    across = np.arange(min(side, height))[:, None] * width + np.arange(min(side, width))
    pixels = (tops * width + lefts)[:, None, None] + across  # (patches, rows, columns)
    values = stack.at(pixels.reshape(-1))
    plain = tile_solver()(values, lights, solver="robust", black_level=black_level, settings=RobustSettings())
    other = solve_materials(values, lights, plain, materials, black_level=black_level, settings=settings)
    usable = mask.reshape(-1)[pixels] & (plain.confidence > 0).reshape(pixels.shape)
    moved = (plain.normals != other.normals).any(axis=1).reshape(pixels.shape)
    before, after = (_curl(one.normals.reshape(*pixels.shape, 3)) for one in (plain, other))
    looked_at = _squares(usable).all(axis=0) & _squares(moved).any(axis=0)
    if not looked_at.any():
        return False
    allowed = max(settings.rougher * float(before[looked_at].mean()), settings.curl)
    return float(after[looked_at].mean()) > allowed


def _curl(normals: FloatArray) -> FloatArray:
    """(K, h - 1, w - 1): how far the slopes around each square of four pixels are from closing, at most 1.

    normals: (K, h, w, 3) of K patches. Times nz squared, by which an angle changes less than its slope:
    else what leans most would decide.
    """
    p, q = gradients_from_normals(normals)
    steep = _squares(np.maximum(normals[..., 2], 0.0) ** 2).mean(axis=0)
    a, b, c, d = _squares(p)  # top left, top right, bottom left, bottom right
    along = 0.5 * ((a + b) - (c + d))  # what p differs by between the rows, y pointing up
    a, b, c, d = _squares(q)
    return np.asarray(np.minimum(steep * np.abs(along - 0.5 * ((b + d) - (a + c))), 1.0))


def _squares(patches: npt.NDArray[np.generic]) -> npt.NDArray[np.generic]:
    """(4, K, h - 1, w - 1): the corners of all squares of neighbours in patches (K, h, w)."""
    top, bottom = patches[:, :-1], patches[:, 1:]
    return np.stack([top[..., :-1], top[..., 1:], bottom[..., :-1], bottom[..., 1:]])


def solve_materials(
    values: FloatArray,
    lights: FloatArray,
    done: TileSolution,
    materials: Sequence[Material],
    *,
    black_level: float = 0.0,
    settings: MaterialSettings | None = None,
) -> TileSolution:
    """A solution by Lambert's law, with other normals where a material is contradicted clearly less.

    values: (N, P) or (N, P, 3), linear, of which `done` is the solution; lights: (N, 3), times strength. The
    albedo of a glossy pixel becomes that of its ground; a metal has none, so what Lambert's law said stays.
    """
    settings = settings or MaterialSettings()
    rows, lamps = brightness_rows(values, black_level=black_level), Lamps(lights)
    seen = lamps.relative(rows, settings)
    contradicted, in_doubt = doubt_finder()(seen, lamps, done.normals, settings)
    doubtful = np.flatnonzero(in_doubt & (done.confidence > 0))
    if not doubtful.size:
        return done
    seen, before = seen.chosen(doubtful), contradicted[doubtful]
    starts = lamps.starts(seen, done.normals[doubtful].astype(np.float64))
    fit = material_fitter()
    tried = (LAMBERT, *materials)
    fits = [fit(seen, lamps, one, starts=starts, settings=settings) for one in tried]
    which = np.stack([one.contradicted for one in fits]).argmin(axis=0)
    normals, albedo, confidence = (one.copy() for one in (done.normals, done.albedo, done.confidence))
    for number, (material, found) in enumerate(zip(tried, fits, strict=True)):
        wins = (which == number) & (found.contradicted < (1.0 - settings.gain) * before)
        wins &= found.contradicted < settings.contradicted
        pixels = doubtful[wins]
        if not pixels.size:
            continue
        won = MaterialFit(found.normals[wins], found.brightness[wins], found.contradicted[wins])
        shape = reflected(won.normals, lamps, material)
        weights = trusts(seen.chosen(wins), won.brightness[:, None] * shape, settings)
        normals[pixels] = won.normals
        if material.kind != "metal":
            albedo[pixels] = _albedo(
                values[:, pixels] - black_level,
                lamps,
                material,
                won,
                weights=weights,
                usual=won.brightness * seen.scale[wins],
                prior=settings.strength_prior,
            )
        confidence[pixels] = (1.0 - won.contradicted) * span_of_lamps(weights, lights)
    return replace(done, normals=normals, albedo=albedo, confidence=confidence)


def _albedo(
    values: FloatArray,
    lamps: Lamps,
    material: Material,
    found: MaterialFit,
    *,
    weights: FloatArray,
    usual: FloatArray,
    prior: float,
) -> FloatArray:
    """(P,), or (P, 3) of values (N, P, 3): brightness of the material; under gloss without the gloss.

    How strong the gloss is each pixel tells by itself, now that its normal is known: the material's share is
    that of some albedo, and gloss as strong over darker ground has a larger one. weights: (P, N), the trust
    in each value. usual: (P,) brightness under the material's own share, which counts for `prior`
    beside that.
    """
    colours = np.moveaxis(values if values.ndim == 3 else values[..., None], 0, 1)
    colours = colours / lamps.strengths[:, None]
    matte = reflected(found.normals, lamps, material if material.kind == "rough" else LAMBERT)
    lobe = lobe_of(material, found.normals, lamps)
    albedo, _ = part_ground_and_gloss(colours, matte, lobe, weights, usual=usual, prior=prior)
    albedo = albedo.astype(np.float32)
    return np.asarray(albedo if values.ndim == 3 else albedo[:, 0])


def _unit(vectors: FloatArray) -> FloatArray:
    return np.asarray(vectors / np.maximum(np.linalg.norm(vectors, axis=1, keepdims=True), 1e-12))
