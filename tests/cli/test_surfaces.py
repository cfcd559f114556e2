"""relief, relight, stl, and what reconstruct writes: whole commands on tiny inputs, and bad ones."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from scipy import ndimage

UNWRITABLE = ["{desk}/file.txt/out", "/proc/out"]


def test_reconstruct_writes_a_surface_and_a_report(rumu, capture, tmp_path):
    ended = rumu("reconstruct", capture, "-o", tmp_path / "out", "--json")
    facts = ended.facts
    assert (ended.code, ended.err, facts["source"], facts["shape"]) == (0, "", "photometric", [40, 40])
    page = (tmp_path / "out" / "report.html").read_text(encoding="utf-8")
    assert "data:image/png;base64," in page and "Height measured from photographs" in page


def test_reconstruct_says_what_came_out(rumu, capture, tmp_path):
    ended = rumu("reconstruct", capture, "-o", tmp_path / "out", "--solver", "least_squares")
    assert ended.code == 0 and "40 x 40 pixels" in ended.out and "report.html" in ended.out


@pytest.mark.parametrize(
    ("wanted", "files"),
    [
        ("report", {"report.html"}),
        ("height, mesh", {"height.tif", "height.png", "surface.glb"}),
        ("normals.png,Albedo.tif", {"normals.png", "albedo.tif"}),
        ("normals-green-down.png", {"normals-green-down.png"}),
        ("pictures", {"height.png", "normals.png", "albedo.png", "confidence.png"}),
    ],
)
def test_reconstruct_writes_what_is_asked_for(rumu, capture, tmp_path, wanted, files):
    ended = rumu("reconstruct", capture, "-o", tmp_path / "out", "--write", wanted, "--json")
    assert {path.name for path in (tmp_path / "out").iterdir()} == {*files, "mask.png", "surface.json"}
    assert (ended.facts["report"] is not None) == ("report.html" in files)


@pytest.mark.parametrize("wanted", ["colour", "", "height,normals.jpg"])
def test_reconstruct_writes_nothing_that_it_does_not_know(rumu, capture, tmp_path, wanted):
    assert rumu("reconstruct", capture, "-o", tmp_path / "out", "--write", wanted).code == 2
    assert not (tmp_path / "out").exists()


def test_a_known_scale_gives_millimetres(rumu, capture, tmp_path):
    facts = rumu("reconstruct", capture, "-o", tmp_path / "out", "--mm-per-pixel", "0.05", "--json").facts
    assert (facts["unit"], facts["spacing"]) == ("mm", 0.05)
    pixels = rumu("reconstruct", capture, "-o", tmp_path / "px", "--json").facts
    rise = facts["height"]["high"] - facts["height"]["low"]
    assert rise == pytest.approx(0.05 * (pixels["height"]["high"] - pixels["height"]["low"]), rel=1e-3)


@pytest.mark.parametrize("scale", ["nan", "inf", "0", "-1", "wide"])
def test_a_scale_that_is_none_is_wrong_usage(rumu, capture, tmp_path, scale):
    assert rumu("reconstruct", capture, "-o", tmp_path / "out", "--mm-per-pixel", scale).code == 2
    assert not (tmp_path / "out").exists()


def test_photographs_are_divided_by_flat_field_frames(rumu, capture, tmp_path):
    Image.fromarray(np.full((40, 40), 40000, np.uint16)).save(tmp_path / "flat.png")
    options = ("--write", "height.tif", "--json")
    plain = rumu("reconstruct", capture, "-o", tmp_path / "plain", *options).facts
    ended = rumu(
        "reconstruct", capture, "-o", tmp_path / "out", "--flat-field", tmp_path / "flat.png", *options
    )
    assert ended.code == 0 and "divided by the mean" in ended.facts["notes"][0]["en"]
    assert ended.facts["height"]["high"] == pytest.approx(plain["height"]["high"], rel=1e-3)
    assert rumu("rti", capture, "-o", tmp_path / "a.ptm", "--flat-field", tmp_path).code == 1
    Image.fromarray(np.full((40, 40), 65535, np.uint16)).save(tmp_path / "flat.png")
    white = ("--flat-field", tmp_path / "flat.png")
    rumu("reconstruct", capture, "-o", tmp_path / "no", *white).failed_with("flat.png", "overexposed")


def test_photographs_that_moved_are_laid_on_each_other(rumu, tmp_path):
    """A shaken folder is refused, and with --align becomes a surface whose table tells by how much."""
    folder, rng = tmp_path / "shaken", np.random.default_rng(3)
    folder.mkdir()
    page = ndimage.gaussian_filter(rng.random((140, 160)), 3)
    page = 0.2 + 0.7 * (page > np.median(page))
    lines = ["6"]
    for number in range(6):
        tilt = np.radians(60 * number)
        light = 0.7 * np.array([np.cos(tilt), np.sin(tilt), 1.02])
        shade = light[2] + 0.2 * light[0] * np.sin(np.arange(160) / 12)
        image = ndimage.gaussian_filter(page * shade, 1)
        image = ndimage.shift(image, (3.25, -1.5) if number == 2 else (0, 0), mode="nearest")
        image += 0.002 * rng.standard_normal(image.shape)
        Image.fromarray(np.round(image.clip(0, 1) * 65535).astype(np.uint16)).save(folder / f"{number}.png")
        lines.append(f"{number}.png {light[0]:.6f} {light[1]:.6f} {light[2]:.6f}")
    (folder / "lights.lp").write_text("\n".join(lines) + "\n")
    rumu("reconstruct", folder, "-o", tmp_path / "no").failed_with("2.png", "moved", "--align")
    options = ("--align", "--write", "normals", "--json")
    facts = rumu("reconstruct", folder, "-o", tmp_path / "out", *options).facts
    told = [row["aligned"] for row in facts["photographs"]]
    assert told == pytest.approx([0, 0, np.hypot(3.25, 1.5), 0, 0, 0], abs=0.15)
    assert any("2.png (3.6)" in note["en"] for note in facts["notes"])
    assert (
        "aligned" in rumu("reconstruct", folder, "-o", tmp_path / "out", "--align", "--write", "normals").out
    )
    assert rumu("rti", folder, "-o", tmp_path / "a.ptm", "--align").code == 0


def test_images_of_different_sizes(rumu, capture, tmp_path):
    Image.new("L", (41, 40), 90).save(capture / "lamp 2.png")
    ended = rumu("reconstruct", capture, "-o", tmp_path / "out")
    ended.failed_with("lamp 2.png", "40")
    assert not (tmp_path / "out").exists()


def test_lamps_with_a_wrong_count(rumu, capture, tmp_path):
    lines = (capture / "lights.lp").read_text().splitlines()
    (capture / "lights.lp").write_text("\n".join(["7", *lines[1:]]))
    rumu("reconstruct", capture, "-o", tmp_path / "out").failed_with("lights.lp", "7", "5")


def test_lamps_that_name_a_missing_file(rumu, capture, tmp_path):
    (capture / "lamp 3.png").unlink()
    rumu("reconstruct", capture, "-o", tmp_path / "out").failed_with("lamp 3.png")


def test_a_capture_that_is_not_there(rumu, tmp_path):
    ended = rumu("reconstruct", tmp_path / "nowhere", "-o", tmp_path / "out", "--json")
    ended.failed_with("nowhere")
    assert "nowhere" in ended.facts["error"]


@pytest.mark.parametrize("place", UNWRITABLE)
def test_reconstruct_into_a_place_that_cannot_be_written(rumu, capture, desk, place):
    place = place.format(desk=desk)
    rumu("reconstruct", capture, "-o", place).failed_with(place, "cannot be written")


def test_reconstruct_leaves_a_stranger_s_folder_alone(rumu, capture, desk):
    before = sorted(path.name for path in desk.iterdir())
    rumu("reconstruct", capture, "-o", desk).failed_with("it holds other things")
    assert sorted(path.name for path in desk.iterdir()) == before


def test_a_result_may_be_made_again(rumu, capture, tmp_path):
    for _ in range(2):
        assert rumu("reconstruct", capture, "-o", tmp_path / "out", "--json").code == 0


def test_relief_says_that_it_measured_nothing(rumu, desk):
    ended = rumu("relief", desk / "master.png", "-o", desk / "out")
    assert ended.code == 0 and "not measured relief" in ended.out
    assert "not measured relief" in (desk / "out" / "report.html").read_text(encoding="utf-8")


@pytest.mark.parametrize(
    "options", [("--method", "density"), ("--mode", "homogeneous"), ("--mode", "hybrid")]
)
def test_relief_has_other_ways(rumu, desk, options):
    facts = rumu("relief", desk / "master.png", "-o", desk / "out", *options, "--json").facts
    assert facts["source"] == ("density" if "density" in options else "inflation")


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("empty.png", ("empty",)),
        ("cut.png", ()),
        ("words.png", ()),
        ("blank.png", ()),
        ("gone.png", ()),
    ],
)
def test_relief_of_what_is_no_picture(rumu, desk, name, words):
    ended = rumu("relief", desk / name, "-o", desk / "out", "--json")
    ended.failed_with(name, *words)
    assert list(ended.facts) == ["error"]
    assert not (desk / "out").exists()


def test_relight_goes_to_the_current_folder(rumu, desk, monkeypatch):
    rumu("relief", desk / "master.png", "-o", desk / "out")
    monkeypatch.chdir(desk)
    facts = rumu("relight", "out", "--tilt", "45", "--slant", "60", "--json").facts
    assert facts["file"] == "out-tilt45-slant60.png"
    picture = Image.open(desk / facts["file"])
    assert picture.size == (160, 160) and np.ptp(np.asarray(picture)) > 100


def test_light_from_the_other_side_is_another_picture(rumu, desk):
    rumu("relief", desk / "master.png", "-o", desk / "out")
    pictures = []
    for tilt in (0, 180):
        target = desk / f"{tilt}.png"
        assert (
            rumu("relight", desk / "out", "--tilt", tilt, "--slant", 50, "-o", target, "--bits", 16).code == 0
        )
        pictures.append(np.asarray(Image.open(target)).astype(int))
    assert pictures[0].max() > 255  # 16 bits
    assert np.abs(pictures[0] - pictures[1]).max() > 1000


@pytest.mark.parametrize(
    "options",
    [
        ("--tilt", "45"),
        ("--tilt", "45", "--slant", "120"),
        ("--tilt", "nan", "--slant", "30"),
        ("--tilt", "45", "--slant", "nan"),
        ("--tilt", "45", "--slant", "30", "--bits", "12"),
        ("--tilt", "45", "--slant", "30", "-o", "x.jpg"),
    ],
)
def test_relight_with_wrong_usage(rumu, desk, options):
    assert rumu("relight", desk, *options).code == 2


def test_relight_of_a_folder_that_holds_no_surface(rumu, desk):
    rumu("relight", desk, "--tilt", 45, "--slant", 30).failed_with(str(desk))


def test_an_stl_of_a_surface_of_an_image_and_of_a_work(rumu, capture, desk, tmp_path, monkeypatch):
    import trimesh

    monkeypatch.setenv("RUMU_HOME", str(tmp_path / "home"))
    assert rumu("reconstruct", capture, "-o", tmp_path / "out").code == 0
    for source, word in (
        (tmp_path / "out", "measured by photometric"),
        (desk / "master.png", "estimated"),
        ("regular-shui", "estimated"),
    ):
        target = tmp_path / "print.stl"
        facts = rumu("stl", source, "-o", target, "--width", 60, "--base", 3, "--json").facts
        mesh = trimesh.load(target)
        assert mesh.is_watertight and mesh.is_winding_consistent and mesh.volume > 0
        assert mesh.extents[0] == pytest.approx(60.0) and mesh.bounds[0, 2] == pytest.approx(-3.0)
        assert facts["size_mm"] == pytest.approx(list(mesh.extents), rel=1e-4)
        assert facts["faces"] == len(mesh.faces) and word.encode() in target.read_bytes()[:80]


def test_an_stl_that_cannot_be_made(rumu, desk, tmp_path, monkeypatch):
    monkeypatch.setenv("RUMU_HOME", str(tmp_path / "home"))
    rumu("stl", "nowhere", "-o", tmp_path / "a.stl").failed_with("nowhere", "no such file")
    for wrong in (("--width", "nan"), ("--width", 0), ("--base", 0), ("--exaggeration", "inf")):
        assert rumu("stl", desk / "master.png", "-o", tmp_path / "a.stl", *wrong).code == 2
    assert rumu("stl", desk / "master.png", "-o", tmp_path / "a.obj").code == 2
    assert not (tmp_path / "a.stl").exists()


def test_a_photograph_is_left_out_and_each_is_told_of(rumu, capture, tmp_path):
    whole = rumu("reconstruct", capture, "-o", tmp_path / "out", "--write", "height", "--json").facts
    assert [row["name"] for row in whole["photographs"]] == [f"lamp {i}.png" for i in range(5)]
    assert max(row["residual"] for row in whole["photographs"]) < 0.02
    fewer = rumu(
        "reconstruct", capture, "-o", tmp_path / "out", "--write", "height", "--leave-out", "lamp 4", "--json"
    ).facts
    assert [row["name"] for row in fewer["photographs"]] == [f"lamp {i}.png" for i in range(4)]
    ended = rumu("reconstruct", capture, "-o", tmp_path / "out", "--leave-out", "lamp 9.png")
    ended.failed_with("lights.lp", "lamp 9.png")


def test_a_mesh_of_each_kind(rumu, capture, desk, tmp_path, monkeypatch):
    import trimesh

    monkeypatch.setenv("RUMU_HOME", str(tmp_path / "home"))
    assert rumu("reconstruct", capture, "-o", tmp_path / "out").code == 0
    for ending, count in (("glb", 1), ("usdz", 1), ("obj", 3), ("ply", 1)):
        target = tmp_path / f"sheet.{ending}"
        facts = rumu("mesh", tmp_path / "out", "-o", target, "--triangles", 400, "--json").facts
        assert len(facts["files"]) == count and facts["source"] == "photometric"
        assert facts["bytes"] == sum(Path(name).stat().st_size for name in facts["files"])
        if ending != "usdz":
            assert 100 < len(trimesh.load(target, force="mesh", process=False).faces) <= 400
    said = rumu("mesh", desk / "master.png", "-o", tmp_path / "ink.glb")
    assert "not measured" in said.out


def test_a_mesh_that_cannot_be_made(rumu, desk, tmp_path):
    wrong = rumu("mesh", desk / "master.png", "-o", tmp_path / "a.stl")
    assert wrong.code == 2 and "rumu stl" in wrong.err
    assert rumu("mesh", desk / "master.png", "-o", tmp_path / "a.fbx").code == 2
    rumu("mesh", "nowhere", "-o", tmp_path / "a.glb").failed_with("nowhere", "no such file")
    assert not list(tmp_path.glob("a.*"))
