"""Simulated sheets whose truth is known: `python benchmarks/known_sheets.py`.

A sheet of ink and shallow relief is photographed under twelve lamps, and one thing at a time is made worse:
slant of the lamps, noise, light of the room, frames that do not lie on each other, lamps that stand near.
Printed are the mean error of the normals in degrees and the correlation of the height, through
`rumu.reconstruct` as it is by default and with the option that is meant for the case. Then colours against a
chart, ink under gloss, and fibres of paper against noise. The tables are written to out/known_sheets.csv and
drawn in out/known_sheets.png.
"""

from __future__ import annotations

import csv
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy import ndimage

from rumu.capture.dome import without_fall_off
from rumu.capture.illumination import rectify_capture
from rumu.outputs import whole_file
from rumu.pipeline import reconstruct
from rumu.surface.alignment import align_photographs
from rumu.values import Capture, Surface
from rumu_lab.simulation.lamps import DistantLamp, Gloss, NearLamp, Sensor, normals_of, render

OUT = Path(__file__).parents[1] / "out"
SIDE = 160
TILTS = np.arange(12) * 360 / 12

# sRGB of the 24 patches of a colour chart as its maker published them before 2014
CHART = (
    "735244 c29682 627a9d 576c43 8580b1 67bdaa d67e2c 505ba6 c15a63 5e3c6c 9dbc40 e0a32e "
    "383d96 469449 af363c e7c71f bb5695 0885a1 f3f3f2 c8c8c8 a0a0a0 7a7a79 555555 343434"
)


@dataclass(frozen=True)
class Condition:
    """How a sheet is photographed; `shift` in pixels, `away` of near lamps in sheet sides, 0 for far ones."""

    slant: float = 45.0
    noise: float = 0.005
    ambient: float = 0.0
    shift: float = 0.0
    away: float = 0.0
    gloss: Gloss | None = None


def sheet() -> tuple[np.ndarray, np.ndarray]:
    """(SIDE, SIDE) height in pixels, of soft waves and engraved strokes; albedo, of paper and ink."""
    rng = np.random.default_rng(5)
    waves = ndimage.gaussian_filter(rng.normal(size=(SIDE, SIDE)), 6)
    y, x = np.mgrid[:SIDE, :SIDE] / SIDE
    strokes = np.maximum.reduce(
        [np.exp(-(((y - 0.25 * k - 0.1 * np.sin(5 * x)) / 0.02) ** 2)) for k in (1, 2, 3)]
    )
    ink = (np.abs(x - 0.3) < 0.04) | (np.hypot(x - 0.7, y - 0.6) < 0.09)
    grain = ndimage.gaussian_filter(rng.normal(size=(SIDE, SIDE)), 1)
    albedo = np.where(ink, 0.06, 0.75) * (1 + 0.03 * grain / grain.std())
    return 0.8 * waves / waves.std() - 2.0 * strokes, albedo


def photographed(height: np.ndarray, albedo: np.ndarray, at: Condition) -> Capture:
    """Twelve lamps at the slant, every third 20 degrees above it; checks are off, so that all go through."""
    slants = np.where(np.arange(12) % 3 == 2, max(at.slant - 20.0, 8.0), at.slant)
    far = [DistantLamp(t, s, 0.9) for t, s in zip(TILTS, slants, strict=True)]
    lights = np.array([one.direction for one in far])
    lamps = [NearLamp(tuple(at.away * SIDE * one), 0.45) for one in lights] if at.away else far
    rng = np.random.default_rng(9)
    turns = rng.uniform(0, 2 * np.pi, len(lamps))
    moves = at.shift * np.stack([np.sin(turns), np.cos(turns)], axis=1)
    moves -= np.median(moves, axis=0)  # --align lays frames where most lie, and the truth lies there, too
    frames = []
    for k, lamp in enumerate(lamps):
        sensor = Sensor(noise=0.0 if at.shift else at.noise, seed=k)
        frame = render(height, albedo, lamp=lamp, ambient=at.ambient, gloss=at.gloss, sensor=sensor)
        if at.shift:
            frame = ndimage.shift(frame, (*moves[k], 0.0)[: frame.ndim], order=1, mode="nearest")
            frame = np.clip(frame + rng.normal(0, at.noise, frame.shape), 0, 1)
        frames.append(np.round(frame * 255) / 255)
    images = np.array(frames, np.float32)
    return Capture(images, lights, np.ones(height.shape, bool), lamps_as_given=True)


def near_model(at: Condition) -> Callable[[Capture], Capture]:
    """The capture with the positions of its lamps."""

    def place(capture: Capture) -> Capture:
        positions = at.away * SIDE * capture.lights
        return capture.changed(images=without_fall_off(capture.photographs, positions), positions=positions)

    return place


def aligned(capture: Capture) -> Capture:
    """The photographs laid on each other."""
    return align_photographs(capture).capture


def figures(surface: Surface, height: np.ndarray) -> tuple[float, float]:
    """Mean error of the normals in degrees, correlation of the height; without a rim of four pixels."""
    inner = np.s_[4:-4, 4:-4]
    cosine = (surface.normals * normals_of(height)).sum(axis=2)[inner]
    error = float(np.degrees(np.arccos(np.clip(cosine, -1, 1))).mean())
    return error, float(np.corrcoef(surface.height[inner].ravel(), height[inner].ravel())[0, 1])


def fall_off(away: float) -> float:
    """K': light at the far side of the sheet over that at the near one; of a lamp at a slant of 45."""
    x, z = away * np.sqrt(0.5), away * np.sqrt(0.5)
    return float(((x - 0.5) ** 2 + z * z) / ((x + 0.5) ** 2 + z * z))


def away_for(ratio: float) -> float:
    """Distance in sheet sides at which the fall-off is this much."""
    near, far = 0.6, 200.0
    for _ in range(60):
        middle = np.sqrt(near * far)
        near, far = (near, middle) if fall_off(middle) > ratio else (middle, far)
    return float(near)


Rows = list[tuple[str, float, str, float, float]]


def conditions() -> Rows:
    """Rows of what is made worse, by how much, with which option; error and correlation."""
    height, albedo = sheet()
    cases: list[tuple[str, float, Condition, dict[str, Callable[[Capture], Capture]]]] = []
    cases += [("slant", one, Condition(slant=one), {}) for one in (20.0, 30.0, 45.0, 60.0, 70.0)]
    cases += [("noise", one, Condition(noise=one), {}) for one in (0.0, 0.005, 0.01, 0.02, 0.05)]
    cases += [("ambient", one, Condition(ambient=one), {}) for one in (0.0, 0.05, 0.1, 0.2)]
    cases += [("shift", one, Condition(shift=one), {"--align": aligned}) for one in (0.0, 0.5, 1.0, 2.0, 3.0)]
    for ratio in (1.0, 0.85, 0.7, 0.55, 0.4):
        at = Condition(away=0.0 if ratio == 1.0 else away_for(ratio))
        ways: dict[str, Callable[[Capture], Capture]] = {"--rectify masked": rectify_capture}
        if at.away:
            ways["near lamps"] = near_model(at)
        cases.append(("K'", ratio, at, ways))
    rows: Rows = []
    for what, amount, at, ways in cases:
        capture = photographed(height, albedo, at)
        for option, prepare in {"default": lambda one: one, **ways}.items():
            error, correlation = figures(reconstruct(prepare(capture)), height)
            rows.append((what, amount, option, error, correlation))
    return rows


def colours() -> None:
    """The chart, flat and wavy, its albedo scaled by one factor: CIEDE2000 of each patch."""
    from skimage.color import deltaE_ciede2000, rgb2lab

    values = np.array([[int(one[k : k + 2], 16) / 255 for k in (0, 2, 4)] for one in CHART.split()])
    linear = np.where(values <= 0.04045, values / 12.92, ((values + 0.055) / 1.055) ** 2.4)
    cell = SIDE // 6
    chart = linear.reshape(4, 6, 3).repeat(cell, axis=0).repeat(cell, axis=1)
    waves = sheet()[0][: 4 * cell, : 6 * cell]
    print("\ncolours of a chart of 24 patches: dE00 mean and largest")
    for name, height, gloss in (
        ("flat", 0 * waves, None),
        ("wavy", waves, None),
        ("wavy, under gloss", waves, Gloss(strength=0.2, exponent=40.0)),
        ("flat, under gloss", 0 * waves, Gloss(strength=0.2, exponent=40.0)),
        ("flat, under broad gloss", 0 * waves, Gloss(strength=0.4, exponent=12.0)),
    ):
        surface = reconstruct(photographed(height, chart, Condition(gloss=gloss)))
        found = surface.albedo.reshape(4, cell, 6, cell, 3)[:, 6:-6, :, 6:-6]
        patches = np.median(found, axis=(1, 3)).reshape(24, 3)
        patches = patches * (linear * patches).sum() / (patches * patches).sum()
        lab = [rgb2lab(_srgb(one)[None])[0] for one in (patches, linear)]
        off = deltaE_ciede2000(*lab)
        print(f"  {name:<24}{off.mean():6.2f}{off.max():6.2f}")


def _srgb(linear: np.ndarray) -> np.ndarray:
    one = np.clip(linear, 0, 1)
    return np.where(one <= 0.0031308, 12.92 * one, 1.055 * one ** (1 / 2.4) - 0.055)


def ink_under_gloss() -> None:
    """Ink of albedo .06 under ever stronger gloss: its normals, and its albedo over that without gloss."""
    height, albedo = sheet()
    ink = ndimage.binary_erosion(albedo < 0.2, iterations=2)
    print("\nink under gloss: error of the ink's normals in degrees, and its albedo over the true one")
    for strength, exponent in ((0.0, 40.0), (0.1, 40.0), (0.3, 40.0), (0.3, 12.0), (0.6, 12.0)):
        at = Condition(gloss=Gloss(strength=strength, exponent=exponent))
        surface = reconstruct(photographed(height, albedo, at))
        cosine = (surface.normals * normals_of(height)).sum(axis=2)[ink]
        error = float(np.degrees(np.arccos(np.clip(cosine, -1, 1))).mean())
        share = float(np.median(surface.albedo[ink] * surface.quality["brightness"] / (0.9 * albedo[ink])))
        print(f"  strength {strength:3.1f}, exponent {exponent:2.0f}{error:8.2f}{share:8.2f}")


def fibres() -> None:
    """Fibres .02 mm high at 30 pixels for a millimetre: in the height, against what noise makes of it."""
    rng = np.random.default_rng(2)
    height = np.zeros((SIDE, SIDE))
    y, x = np.mgrid[:SIDE, :SIDE]
    for _ in range(60):
        turn, (cx, cy), long = rng.uniform(0, np.pi), rng.uniform(0, SIDE, 2), rng.uniform(20, 60)
        along = (x - cx) * np.cos(turn) + (y - cy) * np.sin(turn)
        across = (y - cy) * np.cos(turn) - (x - cx) * np.sin(turn)
        fibre = 0.02 * 30 * np.exp(-((across / 1.6) ** 2)) * (np.abs(along) < long / 2)
        height = np.maximum(height, fibre)
    height = ndimage.gaussian_filter(height, 0.7)
    coarse = lambda z: z - ndimage.gaussian_filter(z, 8)  # noqa: E731
    print("\nfibres .02 mm high at 30 px/mm: correlation of the height, fibres over noise (rms)")
    for noise in (0.005, 0.01, 0.02):
        found, empty = (
            coarse(reconstruct(photographed(z, np.full(z.shape, 0.75), Condition(noise=noise))).height)
            for z in (height, 0 * height)
        )
        correlation = np.corrcoef(found.ravel(), coarse(height).ravel())[0, 1]
        print(f"  noise {noise:5.3f}{correlation:8.2f}{found.std() / empty.std():8.1f}")


def show(rows: Rows) -> None:
    print("ink and relief under 12 lamps: error of the normals in degrees, correlation of the height")
    for what, amount, option, error, correlation in rows:
        print(f"  {what:<9}{amount:7.3f}  {option:<18}{error:7.2f}{correlation:8.3f}")


def write(rows: Rows) -> None:
    """Write the table, and a plot of each thing that was made worse."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    OUT.mkdir(exist_ok=True)
    with whole_file(OUT / "known_sheets.csv") as part, part.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(["worse", "amount", "option", "normals_degrees", "height_correlation"])
        writer.writerows(rows)
    kinds = list(dict.fromkeys(row[0] for row in rows))
    labels = {"slant": "slant, degrees", "shift": "shift, pixels", "ambient": "light of the room, share"}
    figure, panes = plt.subplots(2, len(kinds), figsize=(3 * len(kinds), 5.5), squeeze=False, sharex="col")
    for column, kind in enumerate(kinds):
        for option in dict.fromkeys(row[2] for row in rows if row[0] == kind):
            points = [row for row in rows if row[0] == kind and row[2] == option]
            for pane, value in zip(panes[:, column], (3, 4), strict=True):
                pane.plot([p[1] for p in points], [p[value] for p in points], "o-", label=option, ms=3)
        panes[1, column].set_xlabel(labels.get(kind, kind))
        panes[0, column].set_ylim(bottom=0)
        panes[0, column].legend(fontsize=7)
    panes[0, 0].set_ylabel("error of the normals, degrees")
    panes[1, 0].set_ylabel("correlation of the height")
    figure.tight_layout()
    figure.savefig(OUT / "known_sheets.png", dpi=110)
    plt.close(figure)
    print(f"\nwritten: {OUT / 'known_sheets.csv'} and .png")


if __name__ == "__main__":
    found = conditions()
    show(found)
    colours()
    ink_under_gloss()
    fibres()
    write(found)
