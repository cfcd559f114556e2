"""Ink on every kind of paper, and refusals where there is none."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest

from rumu.capture.image import read_image, to_linear
from rumu.errors import ImageError, RefusedImage
from rumu.surface.ink import find_ink
from rumu_lab.simulation.photographs import Shade, photograph

SIDE = 256
INK, PAPER = 0.1, 0.9


def strokes(side: int = SIDE) -> np.ndarray:
    """(side, side) bool: 十 with a dot, drawn, well inside the page."""
    page = np.zeros((side, side), np.uint8)
    u = side / 256
    for a, b, width in [
        ((60, 128), (196, 122), 22),
        ((128, 50), (126, 208), 18),
        ((176, 176), (190, 192), 20),
    ]:
        ends = [tuple(round(u * v) for v in p) for p in (a, b)]
        cv2.line(page, ends[0], ends[1], 1, max(2, round(u * width)))
    return page.astype(bool)


def page(ink: np.ndarray, *, dark: float = INK, light: float = PAPER) -> np.ndarray:
    return np.where(ink, dark, light).astype(np.float32)


def noisy(image: np.ndarray, sigma: float, seed: int = 0) -> np.ndarray:
    grain = np.random.default_rng(seed).normal(0, sigma, image.shape)
    return np.clip(image + grain, 0, 1).astype(np.float32)


def lit_from_a_corner(image: np.ndarray, fall: float) -> np.ndarray:
    rows, columns = np.mgrid[: image.shape[0], : image.shape[1]] / image.shape[0]
    gain = 1 - fall * np.hypot(columns - 0.1, rows - 0.2)
    return (image * (gain if image.ndim == 2 else gain[:, :, None])).astype(np.float32)


def jpeg(image: np.ndarray, quality: int) -> np.ndarray:
    encoded = cv2.imencode(".jpg", np.rint(255 * image).astype(np.uint8), [cv2.IMWRITE_JPEG_QUALITY, quality])
    return cv2.imdecode(encoded[1], cv2.IMREAD_UNCHANGED).astype(np.float32) / 255


def iou(a: np.ndarray, b: np.ndarray) -> float:
    return np.count_nonzero(a & b) / np.count_nonzero(a | b)


def red_grid(ink: np.ndarray, *, line: int = 2, colour: tuple[float, ...] = (0.85, 0.2, 0.2)) -> np.ndarray:
    """(side, side, 3): a 米字格 printed under the ink."""
    side = len(ink)
    paper = np.full((side, side, 3), 0.95, np.float32)
    middle, last = side // 2, side - 5
    cv2.rectangle(paper, (4, 4), (last, last), colour, line + 1)
    for a, b in [
        ((4, middle), (last, middle)),
        ((middle, 4), (middle, last)),
        ((4, 4), (last, last)),
        ((last, 4), (4, last)),
    ]:
        cv2.line(paper, a, b, colour, line, cv2.LINE_AA)
    return np.where(ink[:, :, None], 0.12, paper).astype(np.float32)


# --- what is found --------------------------------------------------------------------------------


def test_a_binary_image_is_its_own_ink():
    ink = find_ink(page(strokes(), dark=0, light=1))
    np.testing.assert_array_equal(ink.mask, strokes())
    assert ink.polarity == "dark"
    np.testing.assert_array_equal(ink.density, strokes().astype(np.float32))


@pytest.mark.parametrize("dtype", [np.bool_, np.uint8, np.uint16, np.float64])
def test_any_dtype_of_an_image_will_do(dtype):
    top = {np.bool_: 1, np.uint8: 255, np.uint16: 65535, np.float64: 1}[dtype]
    np.testing.assert_array_equal(find_ink((~strokes() * top).astype(dtype)).mask, strokes())


def test_density_is_how_dark_the_ink_is_relative_to_the_paper():
    ink = find_ink(page(strokes(), dark=0.45, light=0.9))
    assert ink.density[ink.mask] == pytest.approx(0.5, abs=0.01)
    assert not ink.density[~ink.mask].any()
    assert ink.contrast == pytest.approx(0.5, abs=0.01)
    assert ink.paper == pytest.approx(0.9, abs=0.01)


def test_a_rubbing_is_light_on_dark():
    ink = find_ink(noisy(page(strokes(), dark=0.85, light=0.1), 0.03))
    assert ink.polarity == "light"
    assert iou(ink.mask, strokes()) > 0.97
    assert find_ink(page(strokes(), dark=0.85, light=0.1)).paper == pytest.approx(0.1, abs=0.01)


def test_polarity_can_be_said_outright():
    assert find_ink(page(strokes()), polarity="dark").polarity == "dark"


@pytest.mark.parametrize("dark", [0.84, 0.75, 0.5])
def test_faint_ink_is_ink(dark):
    assert iou(find_ink(noisy(page(strokes(), dark=dark, light=0.95), 0.01)).mask, strokes()) > 0.95


def test_thick_ink_over_half_the_page_is_ink():
    rows, columns = np.mgrid[:SIDE, :SIDE]
    ring = (np.hypot(rows - 128, columns - 128) < 118) & (np.hypot(rows - 128, columns - 128) > 55)
    assert 0.45 < ring.mean() < 0.6
    assert iou(find_ink(page(ring)).mask, ring) > 0.99


def test_one_horizontal_stroke_is_ink():
    one = np.zeros((SIDE, SIDE), np.uint8)
    cv2.line(one, (40, 132), (214, 120), 1, 20)
    np.testing.assert_array_equal(find_ink(page(one > 0)).mask, one > 0)


def test_a_tiny_character_on_a_large_page_is_ink():
    large = np.zeros((512, 512), bool)
    large[230:270, 250:290] = cv2.resize(strokes().astype(np.uint8), (64, 64))[12:52, 12:52] > 0
    assert iou(find_ink(noisy(page(large), 0.02)).mask, large) > 0.9


def test_uneven_light_and_jpeg_noise():
    photo = jpeg(noisy(lit_from_a_corner(page(strokes()), 0.7), 0.02), 60)
    assert iou(find_ink(photo).mask, strokes()) > 0.97


def test_a_cast_shadow_across_the_page_is_no_ink():
    rows, columns = np.mgrid[:SIDE, :SIDE]
    shaded = page(strokes()) * np.where(rows > 100 + 0.3 * columns, 0.5, 1.0)
    assert iou(find_ink(noisy(shaded, 0.02)).mask, strokes()) > 0.95


@pytest.mark.parametrize("edge", [1.0, 0.02])
@pytest.mark.parametrize("toward", [0, 45, 90, 180, 270])
def test_a_shade_or_a_shadow_over_half_of_the_page_is_no_edge_of_a_sheet(toward, edge):
    ink = strokes(512)
    photo = photograph(ink, side=512, fill=1.0, shade=Shade(0.5, toward, edge), seed=toward)
    found = find_ink(photo)
    assert found.left_out["frame"] == 0
    assert iou(found.mask, find_ink(photograph(ink, side=512, fill=1.0)).mask) > 0.93


@pytest.mark.parametrize("name", ["shade50", "shade-y50"])
def test_pages_that_went_wrong_under_a_shade(name, cases):
    expected = find_ink(read_image(cases / "copies" / "shui-plain.jpg")).mask
    assert iou(find_ink(read_image(cases / "copies" / f"shui-{name}.jpg")).mask, expected) > 0.97


def test_grainy_brown_silk():
    silk = page(strokes())[:, :, None] * np.array([0.75, 0.6, 0.45], np.float32)
    assert iou(find_ink(noisy(silk, 0.05)).mask, strokes()) > 0.97


@pytest.mark.parametrize("colour", [(0.85, 0.2, 0.2), (0.3, 0.7, 0.35), (0.3, 0.4, 0.85)])
def test_a_printed_grid_is_left_out_and_does_not_cut_the_strokes(colour):
    ink = strokes(512)
    photo = jpeg(noisy(lit_from_a_corner(red_grid(ink, colour=colour[::-1]), 0.4), 0.01), 70)[:, :, ::-1]
    found = find_ink(photo).mask
    assert iou(found, ink) > 0.97
    assert (
        cv2.connectedComponents(found.astype(np.uint8))[0] == cv2.connectedComponents(ink.astype(np.uint8))[0]
    )


def test_black_ruled_lines_from_border_to_border_are_left_out():
    ruled = strokes(512)
    ruled[:, 60:63] = ruled[:, 450:453] = True
    ruled[256:258] = True
    ink = find_ink(page(ruled))
    assert iou(ink.mask, strokes(512)) > 0.97
    assert ink.left_out["grid"] > 1000


def test_a_grid_scanned_in_grey_is_left_out():
    one = np.zeros((512, 512), np.uint8)
    cv2.line(one, (100, 262), (410, 240), 1, 36)
    photo = red_grid(one > 0, colour=(0.6, 0.6, 0.6))[:, :, 0]
    assert iou(find_ink(photo).mask, one > 0) > 0.95


@pytest.mark.parametrize("ruled", [False, True])
def test_a_sheet_photographed_on_a_table(ruled):
    ink = strokes(600)
    sheet = red_grid(ink) if ruled else np.dstack([page(ink)] * 3)
    corners = np.array([[120, 90], [700, 130], [680, 860], [90, 820]], np.float32)
    square = np.array([[0, 0], [600, 0], [600, 600], [0, 600]], np.float32)
    turn = cv2.getPerspectiveTransform(square, corners)
    lying, cover, truth = (
        cv2.warpPerspective(a, turn, (800, 950))
        for a in (sheet, np.ones((600, 600), np.float32), ink.astype(np.float32))
    )
    table = np.array([0.35, 0.25, 0.18], np.float32)
    photo = noisy(lit_from_a_corner(lying + (1 - cover)[:, :, None] * table, 0.3), 0.02)
    found = find_ink(cv2.GaussianBlur(photo, (0, 0), 1.2))
    assert found.polarity == "dark"
    assert iou(found.mask, truth > 0.5) > 0.95


def test_ink_over_a_red_seal_stays_and_the_seal_goes():
    paper = np.full((SIDE, SIDE, 3), (0.75, 0.6, 0.45), np.float32)
    seal = np.zeros((SIDE, SIDE), np.uint8)
    cv2.rectangle(seal, (100, 90), (220, 210), 1, 12)
    cv2.line(seal, (130, 100), (130, 200), 1, 10)
    paper[seal > 0] = (0.62, 0.2, 0.13)
    paper[strokes()] = (0.1, 0.09, 0.08)
    ink = find_ink(noisy(paper, 0.02))
    assert iou(ink.mask, strokes()) > 0.95
    assert ink.left_out["seal"] > 0 or not (ink.mask & (seal > 0) & ~strokes()).any()


def test_the_albedo_of_a_surface_gives_the_same_ink():
    stored = noisy(lit_from_a_corner(page(strokes()), 0.4), 0.02)
    linear = find_ink(to_linear(stored), linear=True)
    assert iou(linear.mask, find_ink(stored).mask) > 0.99


def test_a_quarter_turn_of_the_page_turns_the_ink():
    photo = jpeg(noisy(page(strokes()), 0.02), 80)
    for turns in (1, 2, 3):
        turned = find_ink(np.ascontiguousarray(np.rot90(photo, turns))).mask
        assert iou(np.rot90(turned, -turns), find_ink(photo).mask) > 0.999


def test_the_ink_of_a_page_twice_as_large_is_twice_as_large():
    small, large = find_ink(noisy(page(strokes()), 0.02)), find_ink(noisy(page(strokes(512)), 0.02))
    halved = cv2.resize(large.mask.astype(np.float32), (SIDE, SIDE), interpolation=cv2.INTER_AREA) > 0.5
    assert iou(halved, small.mask) > 0.93


# --- what is left out -----------------------------------------------------------------------------


def test_specks_edges_neighbours_and_captions_are_left_out_and_counted():
    stray = strokes(512)
    stray[300:304, 60:64] = True  # a speck
    stray[:, :6] = True  # the edge of the page
    stray[0:20, 300:340] = True  # a neighbour's foot
    stray[90:140, 470:512] = True  # a neighbour's shoulder
    stray[496:506, 440:452] = True  # a printed caption
    ink = find_ink(page(stray))
    np.testing.assert_array_equal(ink.mask, strokes(512))
    assert all(ink.left_out[kind] > 0 for kind in ("speck", "edge", "neighbour", "caption"))


def test_a_stroke_that_reaches_the_border_stays():
    tall = strokes()
    tall[:60, 120:136] = True
    np.testing.assert_array_equal(find_ink(page(tall)).mask, tall)


def test_a_flat_frame_around_the_paper_is_left_out():
    paper = noisy(page(strokes(160), light=0.7), 0.05)
    framed = np.full((SIDE, SIDE), 0.6, np.float32)
    framed[60:220, 40:200] = paper
    ink = find_ink(framed)
    outside = np.ones((SIDE, SIDE), bool)
    outside[60:220, 40:200] = False
    assert not ink.mask[outside].any()
    assert ink.left_out["frame"] == np.count_nonzero(outside)
    assert iou(ink.mask[60:220, 40:200], strokes(160)) > 0.93


def test_an_outlined_box_on_blank_paper_is_ink_and_no_frame():
    box = np.zeros((SIDE, SIDE), bool)
    box[60:200, 50:210] = True
    box[80:180, 70:190] = False
    np.testing.assert_array_equal(find_ink(page(box, dark=0, light=1)).mask, box)


# --- refusals -------------------------------------------------------------------------------------


def lone_seal() -> np.ndarray:
    paper = np.full((SIDE, SIDE, 3), (0.8, 0.7, 0.55), np.float32)
    cv2.rectangle(paper, (70, 70), (190, 190), (0.65, 0.2, 0.15), 10)
    cv2.line(paper, (130, 80), (130, 180), (0.65, 0.2, 0.15), 8)
    return noisy(paper, 0.02)


FLAT = np.full((SIDE, SIDE), 0.85, np.float32)
GENERATOR = np.random.default_rng(5)
PEPPER = np.where(GENERATOR.random((SIDE, SIDE)) < 0.05, 0, 0.9).astype(np.float32)
BROWN = np.full((SIDE, SIDE, 3), (0.6, 0.5, 0.38), np.float32)


@pytest.mark.parametrize(
    ("image", "reason"),
    [
        pytest.param(np.ones((SIDE, SIDE), np.float32), "blank", id="white"),
        pytest.param(FLAT, "blank", id="grey"),
        pytest.param(noisy(FLAT, 0.03), "blank", id="noisy paper"),
        pytest.param(noisy(lit_from_a_corner(FLAT, 0.7), 0.02), "blank", id="uneven paper"),
        pytest.param(noisy(BROWN, 0.02), "blank", id="brown paper"),
        pytest.param(np.tile(np.linspace(0, 1, SIDE, dtype=np.float32), (SIDE, 1)), "blank", id="ramp"),
        pytest.param(red_grid(np.zeros((512, 512), bool)), "blank", id="empty red grid"),
        pytest.param(lone_seal(), "blank", id="a seal and nothing else"),
        pytest.param(np.zeros((SIDE, SIDE), np.float32), "black", id="black"),
        pytest.param(noisy(FLAT * 0.05, 0.01), "black", id="noisy black"),
        pytest.param(GENERATOR.random((SIDE, SIDE)).astype(np.float32), "noise", id="white noise"),
        pytest.param(GENERATOR.random((SIDE, SIDE, 3)).astype(np.float32), "noise", id="coloured noise"),
        pytest.param(noisy(FLAT * 0.6, 0.2), "noise", id="gaussian noise"),
        pytest.param(PEPPER, "noise", id="pepper"),
    ],
)
def test_what_holds_no_writing_is_refused_with_its_reason(image, reason):
    with pytest.raises(RefusedImage, match=r"expected .*, got") as refused:
        find_ink(image)
    assert refused.value.reason == reason


def test_what_is_no_image_is_an_error_of_another_kind():
    with pytest.raises(ImageError, match="expected an image of shape"):
        find_ink(np.zeros((4, 4, 4, 4), np.float32))


# --- real pictures --------------------------------------------------------------------------------


def lanting(data: Path, version: str, count: int) -> list[np.ndarray]:
    files = sorted((data / "masters" / "running-lantingxu" / version).iterdir())
    return [read_image(files[i]) for i in np.linspace(0, len(files) - 1, count).astype(int)]


@pytest.mark.parametrize("version", ["shenlong", "chu", "yu", "dingwu"])
def test_lanting_versions_have_their_ink_and_polarity(data, version):
    found = [find_ink(image) for image in lanting(data, version, 20)]
    assert {ink.polarity for ink in found} == {"light" if version == "dingwu" else "dark"}
    shares = np.array([ink.mask.mean() for ink in found])
    assert shares.min() > 0.015 and shares.max() < 0.45
    if version != "shenlong":  # padded by a flat frame to 300 x 300
        assert not any(ink.mask[:5].any() or ink.mask[:, :5].any() for ink in found)
    if version in ("chu", "yu"):  # the frame of the rubbing has the colour of its ground
        assert all(ink.left_out["frame"] > 5000 for ink in found)


@pytest.mark.parametrize("name", ["yu/016_*", "chu/001_*", "chu/284_*", "shenlong/032_*"])
def test_seal_coloured_pixels_are_not_ink(data, name):
    (file,) = (data / "masters" / "running-lantingxu").glob(name)
    image = read_image(file)
    ink = find_ink(image)
    red, other = image[:, :, 0], image[:, :, 1:].max(axis=2)
    seal = (red > 1.7 * other) & (red > 0.3)
    assert np.count_nonzero(seal) > 300
    assert np.count_nonzero(ink.mask & seal) < 0.05 * np.count_nonzero(seal)
    assert ink.left_out["seal"] > 0


def test_captions_of_the_shenlong_pictures_are_left_out(data):
    for image in lanting(data, "shenlong", 40):
        if image.shape[0] == 400:
            ink = find_ink(image)
            assert not ink.mask[376:].any(), "printed caption and address at the bottom"


def test_e3c_ink_is_the_binary_image_less_strays(data):
    files = sorted((data / "e3c" / "copies").iterdir())[::6] + sorted((data / "e3c" / "templates").iterdir())
    for file in files:
        image = read_image(file)
        ink = find_ink(image)
        assert not (ink.mask & (image > 0.5)).any(), file.name
        lost = np.count_nonzero((image < 0.5) & ~ink.mask)
        assert lost == sum(ink.left_out.values()), file.name
        assert lost < 0.07 * np.count_nonzero(image < 0.5), file.name


@pytest.mark.parametrize("name", ["10.png", "39.png"])
def test_frame_lines_of_templates_are_left_out(data, name):
    image = read_image(data / "e3c" / "templates" / name)
    ink = find_ink(image)
    rim = np.ones(image.shape, bool)
    rim[12:-12, 12:-12] = False
    assert ((image < 0.5) & rim).any()
    assert not (ink.mask & rim).any()


def test_masters_in_one_bit_lose_nothing(data):
    files = sorted((data / "masters" / "regular").rglob("*.png"))[::110]
    for file in files:
        image = read_image(file)
        ink = find_ink(image)
        assert (
            np.count_nonzero((image < 0.5) ^ ink.mask) <= sum(ink.left_out.values()) < 0.02 * ink.mask.sum()
        )


def test_cursive_masters_have_the_polarity_of_their_label(data):
    folder = data / "masters" / "cursive"
    lines = (folder / "labels.csv").read_text(encoding="utf-8").splitlines()
    names = lines[0].split(",")
    rows = [dict(zip(names, line.split(","), strict=True)) for line in lines[1::28]]
    wrong = refused = 0
    for row in rows:
        try:
            ink = find_ink(read_image(folder / row["file"]))
        except RefusedImage:
            refused += 1
            continue
        wrong += not row["polarity_guess"].startswith(ink.polarity)
    assert len(rows) >= 120
    assert wrong == 0
    assert refused <= 1
