"""Capture folders: the real ones, each kind of lamp file, and one clear error for each that is wrong."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import numpy as np
import pytest
import tifffile
from PIL import Image

import rumu
from rumu.capture.folder import read_capture
from rumu.capture.image import read_image, to_linear
from rumu.capture.lights import direction, paper_tilts
from rumu.errors import CaptureError, ImageError

UW = ("buddha", "cat", "chrome", "gray", "horse", "owl", "rock")
LEVELS = {"a": 100, "b": 150, "c": 200}
LP = "3\na.png 1 0 1\nb.png 0 2 2\nc.png -0.7 0 0.7\n"


def write(
    folder: Path, *, suffix: str = "png", size: tuple[int, int] = (20, 16), levels: dict[str, int] = LEVELS
) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    for stem, level in levels.items():
        Image.new("L", size, level).save(folder / f"{stem}.{suffix}")


def paper_folder(folder: Path, **description: object) -> Path:
    write(folder)
    (folder / "capture.json").write_text(json.dumps({"slant": 45, **description}))
    return folder


def lp_folder(folder: Path, text: str = LP) -> Path:
    write(folder)
    (folder / "lights.lp").write_text(text)
    return folder


# --- real captures ---------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("folder", "shape", "masked"),
    [
        *[(f"uw-psm/{name}", (12, 340, 512, 3), True) for name in UW],
        ("bunny/bunny_lambert", (50, 256, 256), True),
        ("bunny/bunny_lambert_noshadow", (50, 256, 256), True),
        ("psbox-cat", (12, 550, 430), False),
        ("synthrti-relief/train49", (49, 320, 320, 3), True),
        ("synthrti-relief/test20", (20, 320, 320, 3), False),
        ("lion-rti", (240, 43, 64, 3), False),
    ],
)  # fmt: skip
def test_real_captures(data: Path, folder: str, shape: tuple[int, ...], masked: bool) -> None:
    capture = rumu.read_capture(data / "photometric" / folder)
    assert capture.images.shape == shape and capture.images.dtype == np.float32
    assert capture.images.min() >= 0 and 0.5 < capture.images.max() <= 1
    assert len(capture.names) == shape[0] and capture.mask.all() != masked
    np.testing.assert_allclose(np.linalg.norm(capture.lights, axis=1), 1)
    assert (capture.lights[:, 2] > 0).all()


def test_bunny_takes_the_mask_one_folder_up(data: Path) -> None:
    bunny = data / "photometric" / "bunny"
    mask = read_image(bunny / "mask.png") > 0.5
    np.testing.assert_array_equal(read_capture(bunny / "bunny_lambert").mask, mask)


def test_text_and_lp_of_one_folder_tell_the_same(data: Path) -> None:
    cat = data / "photometric" / "psbox-cat"
    by_lp, by_text = read_capture(cat), read_capture(cat / "light_directions_3x12.txt")
    assert by_lp.names == by_text.names
    np.testing.assert_allclose(by_lp.lights, by_text.lights, atol=1e-5)
    np.testing.assert_array_equal(by_lp.images, by_text.images)


def test_real_light_comes_from_where_the_lamp_file_says(data: Path) -> None:
    capture = read_capture(data / "photometric" / "uw-psm" / "gray")
    rows, columns = np.nonzero(capture.mask)
    for image, light in zip(capture.gray, capture.lights, strict=True):
        values = image[capture.mask]
        right = np.corrcoef(columns, values)[0, 1]
        up = np.corrcoef(-rows, values)[0, 1]
        assert right * light[0] + up * light[1] > 0.3 * np.hypot(light[0], light[1])


# --- the kinds of folders --------------------------------------------------------------------------


def test_three_lamps_of_the_paper(tmp_path: Path) -> None:
    capture = read_capture(paper_folder(tmp_path, slant=30, spacing_mm=0.05))
    lamps = paper_tilts(capture.lights)
    assert lamps is not None and lamps.order == (0, 1, 2) and lamps.slant == pytest.approx(30)
    assert capture.lights[1] @ [0, 1, 0] == pytest.approx(0.5)  # tilt 90 is at the top
    assert capture.names == ("a.png", "b.png", "c.png") and capture.spacing == 0.05
    np.testing.assert_allclose(capture.images[:, 0, 0], np.array([100, 150, 200]) / 255, rtol=1e-6)
    assert capture.images.shape == (3, 16, 20) and capture.mask.all()


def test_a_fourth_lamp_at_the_bottom(tmp_path: Path) -> None:
    paper_folder(tmp_path)
    Image.new("L", (20, 16), 50).save(tmp_path / "D.PNG")
    capture = read_capture(tmp_path)
    assert capture.names[3] == "D.PNG"
    np.testing.assert_allclose(capture.lights[3], direction(tilt=270, slant=45))


def test_tilts_of_ones_own(tmp_path: Path) -> None:
    tilts = {"c": 10, "a": 130, "b": -110}
    capture = read_capture(paper_folder(tmp_path, tilts=tilts))
    assert capture.names == ("c.png", "a.png", "b.png")
    np.testing.assert_allclose(capture.lights[2], direction(tilt=250, slant=45))


def test_lp_vectors_are_normalised(tmp_path: Path) -> None:
    capture = read_capture(lp_folder(tmp_path))
    np.testing.assert_allclose(capture.lights[1], [0, 0.5**0.5, 0.5**0.5])


def test_lp_names_with_spaces_folders_and_another_machine(tmp_path: Path) -> None:
    write(tmp_path / "shots", levels={"one 入木": 10, "two": 20})
    Image.new("L", (20, 16), 30).save(tmp_path / "three.png")
    lines = ["3", "shots/one 入木.png 1 0 1", "shots\\two.png\t0 1 1", r"C:\Users\me\three.png -1 0 1"]
    (tmp_path / "my lamps.LP").write_text("\ufeff" + "\r\n".join(lines) + "\r\n\r\n", encoding="utf-8")
    capture = read_capture(tmp_path)
    assert capture.names == ("shots/one 入木.png", "shots/two.png", "three.png")
    np.testing.assert_allclose(capture.images[:, 0, 0] * 255, [10, 20, 30], rtol=1e-5)


def test_lp_of_images_in_another_folder(tmp_path: Path) -> None:
    write(tmp_path / "jpg")
    (tmp_path / "lamps").mkdir()
    text = (
        LP.replace("a.png", "../jpg/a.png").replace("b.png", "../jpg/b.png").replace("c.png", "../jpg/c.png")
    )
    (tmp_path / "lamps" / "x.lp").write_text(text)
    assert read_capture(tmp_path / "lamps" / "x.lp").images.shape == (3, 16, 20)


def project(folder: Path, *, lp: str) -> Path:
    """A project as RTIBuilder keeps it: photographs in one folder, lamps in another beside it."""
    write(folder / "jpeg-exports", suffix="jpg")
    write(folder / "original-captures", suffix="tif")
    (folder / "assembly-files").mkdir()
    (folder / "assembly-files" / "vase.lp").write_text(lp)
    (folder / "finished-files").mkdir()
    return folder


@pytest.mark.parametrize("place", ["/Users/lab/vase/jpeg-exports/", "D:\\RTI\\vase\\jpeg-exports\\", ""])
def test_a_project_of_rtibuilder(tmp_path: Path, place: str) -> None:
    text = "\n".join(["3", *(f"{place}{line}" for line in LP.replace(".png", ".jpg").split("\n")[1:4])])
    folder = project(tmp_path / "vase", lp=text)
    whole = read_capture(folder)
    assert whole.names == ("jpeg-exports/a.jpg", "jpeg-exports/b.jpg", "jpeg-exports/c.jpg")
    assert read_capture(folder, within=folder).names == whole.names
    by_file = read_capture(folder / "assembly-files" / "vase.lp")
    assert [Path(name).name for name in by_file.names] == ["a.jpg", "b.jpg", "c.jpg"]
    np.testing.assert_array_equal(by_file.lights, whole.lights)


def test_lamps_in_several_folders_and_images_in_several(tmp_path: Path) -> None:
    folder = project(tmp_path / "vase", lp=LP)
    write(folder / "cropped-files", suffix="png")
    assert read_capture(folder).names[0] == "cropped-files/a.png", "the only one of this name"
    write(folder / "again", suffix="png")
    with pytest.raises(CaptureError, match=r"found again/a\.png, cropped-files/a\.png"):
        read_capture(folder)
    (folder / "again" / "other.lp").write_text(LP)
    with pytest.raises(CaptureError, match=r"found again/other\.lp, assembly-files/vase\.lp"):
        read_capture(folder)


def test_the_lamps_of_a_result_are_not_those_of_the_capture_around_it(tmp_path: Path) -> None:
    write(tmp_path)
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "lamps.lp").write_text(LP)
    (tmp_path / "out" / "surface.json").write_text("{}")
    with pytest.raises(CaptureError, match=r"expected an \.lp file"):
        read_capture(tmp_path)


def test_the_folders_beside_an_upload_are_not_looked_into(tmp_path: Path) -> None:
    folder = project(tmp_path / "vase", lp=LP.replace(".png", ".jpg"))
    sent = folder / "assembly-files"
    with pytest.raises(CaptureError, match="there is no such file"):
        read_capture(sent, within=sent)
    (sent / "in").symlink_to(folder / "jpeg-exports")
    with pytest.raises(CaptureError, match=r"there is no such file|leads out"):
        read_capture(sent, within=sent)


def test_lp_written_on_a_chinese_windows(tmp_path: Path) -> None:
    write(tmp_path, levels={"永": 10, "b": 20, "c": 30})
    (tmp_path / "x.lp").write_bytes(LP.replace("a.png", "永.png").encode("gb18030"))
    assert read_capture(tmp_path).names[0] == "永.png"


@pytest.mark.parametrize("layout", ["rows", "columns", "commas", "3 x 3 by rows", "3 x 3 by columns"])
def test_light_directions(tmp_path: Path, layout: str) -> None:
    count = 3 if "3 x 3" in layout else 11
    write(tmp_path, levels={f"shot{i}": 20 * i for i in range(1, count + 1)})
    write(tmp_path, levels={"mask": 255, "x.mask": 255, "ambient": 0, "normals": 9})
    (tmp_path / "x.mask.png").unlink()
    lights = np.array([direction(tilt=40 * i, slant=20 + 4 * i) for i in range(count)])
    table = lights if layout in ("rows", "commas", "3 x 3 by rows") else lights.T
    np.savetxt(tmp_path / "light_directions.txt", table, delimiter=", " if layout == "commas" else "  ")
    capture = read_capture(tmp_path)
    np.testing.assert_allclose(capture.lights, lights, atol=1e-12)
    expected = np.arange(1, count + 1) * 20 / 255  # shot10 after shot9, not after shot1
    np.testing.assert_allclose(capture.images[:, 0, 0], expected, rtol=1e-6)


# --- light, masks, ambient -------------------------------------------------------------------------


def test_encodings(tmp_path: Path) -> None:
    write(tmp_path, suffix="jpg")
    (tmp_path / "capture.json").write_text('{"slant": 45}')
    stored = np.float32(100 / 255)
    assert read_capture(tmp_path).images[0, 8, 8] == pytest.approx(float(to_linear(stored)), abs=1e-5)
    assert read_capture(tmp_path, encoding="linear").images[0, 8, 8] == pytest.approx(stored, abs=1e-5)
    (tmp_path / "capture.json").write_text('{"slant": 45, "encoding": "linear"}')
    assert read_capture(tmp_path).images[0, 8, 8] == pytest.approx(stored, abs=1e-5)
    assert read_capture(tmp_path, encoding="srgb").images[0, 8, 8] == pytest.approx(
        float(to_linear(stored)), abs=1e-5
    )


def test_ambient_frame_is_subtracted(tmp_path: Path) -> None:
    paper_folder(tmp_path)
    Image.new("L", (20, 16), 90).save(tmp_path / "ambient.png")
    expected = np.array([10, 60, 110]) / 255
    np.testing.assert_allclose(read_capture(tmp_path).images[:, 0, 0], expected, atol=1e-6)


def test_noise_below_the_ambient_frame_becomes_black(tmp_path: Path) -> None:
    paper_folder(tmp_path)
    Image.new("L", (20, 16), 101).save(tmp_path / "ambient.png")
    assert read_capture(tmp_path).images[0].max() == 0


def test_bright_float_frames_share_one_scale(tmp_path: Path) -> None:
    for stem, level in (("a", 2.0), ("b", 8.0), ("c", 4.0)):
        tifffile.imwrite(tmp_path / f"{stem}.tif", np.full((16, 20), level, np.float32))
    (tmp_path / "capture.json").write_text('{"slant": 45}')
    np.testing.assert_allclose(read_capture(tmp_path).images[:, 0, 0], [0.25, 1, 0.5])


@pytest.mark.parametrize("name", ["mask.png", "sheet.mask.png", "../mask.png", "other/m.png"])
def test_masks(tmp_path: Path, name: str) -> None:
    folder = tmp_path / "sheet"
    paper_folder(folder, **({"mask": name} if "other" in name else {}))
    half = Image.new("L", (20, 16), 0)
    half.paste(255, (0, 0, 10, 16))
    (folder / name).parent.mkdir(exist_ok=True)
    half.save(folder / name)
    mask = read_capture(folder).mask
    assert mask[:, :10].all() and not mask[:, 10:].any()


def test_mask_of_other_photographs_one_folder_up_is_not_ours(tmp_path: Path) -> None:
    paper_folder(tmp_path / "sheet")
    write(tmp_path, levels={"mask": 0, "another sheet": 9})
    assert read_capture(tmp_path / "sheet").mask.all()


# --- what is refused -------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", r"lights\.lp line 1: expected the number of images, got an empty file"),
        ("hello\n", r"lights\.lp line 1: expected 'name x y z', got 'hello': 0 numbers follow the name"),
        (LP.replace("3\n", "5\n"), r"lights\.lp: line 1 promises 5 images, 3 lines follow"),
        (
            LP.replace("b.png 0 2 2", "b.png 0 2"),
            r"lights\.lp line 3: expected 'name x y z', got 'b\.png 0 2'",
        ),
        (LP.replace("0 2 2", "0 up 2"), r"lights\.lp line 3: expected 'name x y z'"),
        (LP.replace("0 2 2", "0 nan 2"), r"lights\.lp line 3: expected 'name x y z'"),
        (
            LP.replace("0 2 2", "0 0 0"),
            r"lights\.lp line 3: expected a direction toward the lamp, got a zero vec",
        ),
        (LP.replace("0 2 2", "0 2 -2"), r"lights\.lp line 3: expected a lamp on the camera's side"),
        (
            LP.replace("b.png", "gone.png"),
            r"lights\.lp line 3: expected the image gone\.png, there is no such",
        ),
        (LP.replace("b.png", "a.png"), r"lights\.lp line 3: a\.png was named before, in .*lights\.lp line 2"),
        (
            LP.replace("0 2 2", "0.5 0 2"),
            r"lights\.lp: expected lamps from at least three sides, got 3 that lie in",
        ),
        ("2\na.png 1 0 1\nb.png 0 1 1\n", r"lights\.lp: expected at least 3 images, got 2"),
    ],
)
def test_bad_lp(tmp_path: Path, text: str, message: str) -> None:
    with pytest.raises(CaptureError, match=message):
        read_capture(lp_folder(tmp_path, text))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (
            "1 2\n3 4\n",
            r"light_directions\.txt: expected a table of 3 x N or N x 3 finite numbers, got \(2, 2\)",
        ),
        ("1 0 one\n", r"light_directions\.txt line 1: expected a table of 3 x N .* got 'one'"),
        ("1 0 1\n0 1\n", r"light_directions\.txt line 2: expected a table .* 2 of them after lines of 3"),
        ("1 0 1\na.png 0 1 1\n", r"light_directions\.txt line 2: .* must end in \.lp"),
        ("0 0 1\n1 0 1\n0 1 1\n0 2 1\n", r"light_directions\.txt: holds 4 lamps, but 3 images lie beside it"),
        ("9 0 1\n0 9 1\n1 1 9\n", r"light_directions\.txt: 3 x 3 numbers may be read by rows or by columns"),
        ("0 0 0\n1 0 1\n0 1 1\n0 2 1\n", r"light_directions\.txt lamp 1: .* got a zero vector"),
    ],
)
def test_bad_light_directions(tmp_path: Path, text: str, message: str) -> None:
    write(tmp_path)
    (tmp_path / "light_directions.txt").write_text(text)
    with pytest.raises(CaptureError, match=message):
        read_capture(tmp_path)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("{slant: 45}", r"capture\.json line 1: expected JSON"),
        ("[45]", r"capture\.json: expected an object"),
        ('{"slant": 45, "tilt": 3}', r"capture\.json: expected only slant, .* found 'tilt'"),
        (
            '{"slant": "45"}',
            r"capture\.json: expected \"slant\" to be a number above 0 and below 90, got '45'",
        ),
        ('{"slant": 90}', r"expected \"slant\" to be a number above 0 and below 90, got 90"),
        ('{"slant": 45, "spacing_mm": -1}', r"expected \"spacing_mm\" to be a number above 0 .* got -1"),
        (
            '{"slant": 45, "encoding": "gamma"}',
            r"capture\.json: expected \"encoding\" among auto, linear, srgb",
        ),
        (
            '{"slant": 45, "tilts": {"a": 0, "b": 90, "x": 1}}',
            r"capture\.json: expected an image named x .*none",
        ),
        ('{"slant": 45, "tilts": [0, 90]}', r"expected \"tilts\" like"),
        ('{"slant": 45, "tilts": {"a": 0, "b": 0, "c": 180}}', r"got 3 that lie in one plane"),
        (
            '{"spacing_mm": 1}',
            r"expected an \.lp file, light_directions\.txt, a \.csv of lamps, or capture\.json with a slant",
        ),
    ],
)
def test_bad_descriptions(tmp_path: Path, text: str, message: str) -> None:
    write(tmp_path)
    (tmp_path / "capture.json").write_text(text)
    with pytest.raises(CaptureError, match=message):
        read_capture(tmp_path)


def test_missing_image_of_the_three(tmp_path: Path) -> None:
    paper_folder(tmp_path)
    (tmp_path / "b.png").unlink()
    with pytest.raises(CaptureError, match=r"capture\.json: expected an image named b .* found none"):
        read_capture(tmp_path)


def test_two_images_of_one_name(tmp_path: Path) -> None:
    paper_folder(tmp_path)
    shutil.copy(tmp_path / "a.png", tmp_path / "a.tif")
    with pytest.raises(CaptureError, match=r"expected one image named a, found a\.png, a\.tif"):
        read_capture(tmp_path)


def test_two_lamp_files(tmp_path: Path) -> None:
    lp_folder(tmp_path)
    (tmp_path / "other.lp").write_text(LP)
    with pytest.raises(
        CaptureError, match=r"found lights\.lp, other\.lp; expected one, or the path of the one"
    ):
        read_capture(tmp_path)
    assert read_capture(tmp_path / "other.lp").images.shape[0] == 3


def test_lamps_told_twice(tmp_path: Path) -> None:
    paper_folder(lp_folder(tmp_path))
    with pytest.raises(CaptureError, match=r"lights\.lp says where the lamps stood and so does \"slant\""):
        read_capture(tmp_path)


def test_images_of_different_sizes(tmp_path: Path) -> None:
    lp_folder(tmp_path)
    Image.new("L", (20, 17)).save(tmp_path / "b.png")
    with pytest.raises(CaptureError, match=r"b\.png: expected 20 x 16 pixels as in a\.png, got 20 x 17"):
        read_capture(tmp_path)


def test_gray_among_colour(tmp_path: Path) -> None:
    lp_folder(tmp_path)
    Image.new("RGB", (20, 16)).save(tmp_path / "c.png")
    with pytest.raises(CaptureError, match=r"c\.png: expected gray as in a\.png, got colour"):
        read_capture(tmp_path)


def test_ambient_of_another_size(tmp_path: Path) -> None:
    lp_folder(tmp_path)
    Image.new("L", (21, 16)).save(tmp_path / "ambient.png")
    with pytest.raises(
        CaptureError, match=r"ambient\.png: expected 20 x 16 pixels as in a\.png, got 21 x 16"
    ):
        read_capture(tmp_path)


def test_mask_of_another_size(tmp_path: Path) -> None:
    lp_folder(tmp_path)
    Image.new("L", (21, 16), 255).save(tmp_path / "mask.png")
    with pytest.raises(CaptureError, match=r"mask\.png: expected a mask of 20 x 16 pixels, got 21 x 16"):
        read_capture(tmp_path)


def test_black_mask(tmp_path: Path) -> None:
    lp_folder(tmp_path)
    Image.new("L", (20, 16)).save(tmp_path / "mask.png")
    with pytest.raises(CaptureError, match=r"mask\.png: .* it is black all over"):
        read_capture(tmp_path)


def test_named_mask_that_is_not_there(tmp_path: Path) -> None:
    with pytest.raises(CaptureError, match=r"capture\.json: expected the mask gone\.png"):
        read_capture(paper_folder(tmp_path, mask="gone.png"))


def test_broken_image_is_named(tmp_path: Path) -> None:
    lp_folder(tmp_path)
    (tmp_path / "b.png").write_text("no image")
    with pytest.raises(ImageError, match=r"b\.png: expected an image"):
        read_capture(tmp_path)


def test_no_such_folder(tmp_path: Path) -> None:
    with pytest.raises(
        CaptureError, match=r"gone: expected a capture folder or its \.lp file, there is no such"
    ):
        read_capture(tmp_path / "gone")


def test_an_image_is_no_capture(tmp_path: Path) -> None:
    write(tmp_path)
    with pytest.raises(CaptureError, match=r"a\.png: expected a capture folder .* got another kind of file"):
        read_capture(tmp_path / "a.png")


def test_empty_folder_and_wrong_encoding(tmp_path: Path) -> None:
    with pytest.raises(
        CaptureError,
        match=r"expected an \.lp file, light_directions\.txt, a \.csv of lamps, or capture\.json",
    ):
        read_capture(tmp_path)
    with pytest.raises(CaptureError, match="encoding: expected one of auto, linear, srgb, got 'raw'"):
        read_capture(tmp_path, encoding="raw")  # type: ignore[arg-type]


# --- captures of others: nothing outside them is read ----------------------------------------------


@pytest.fixture
def outside(tmp_path: Path) -> Path:
    """Readable pictures beside the folder `sent`, a mask one folder up among them."""
    write(tmp_path / "other")
    Image.new("L", (20, 16), 255).save(tmp_path / "mask.png")
    return tmp_path / "other"


def names_of(outside: Path, image: str) -> tuple[str, ...]:
    return (
        str(outside / image),
        f"../{outside.name}/{image}",
        f"..\\{outside.name}\\{image}",
        f"sub/../../{outside.name}/{image}",
        f"~/{image}",
        (outside / image).as_uri(),
    )


@pytest.mark.parametrize("kind", range(6))
def test_an_lp_of_an_upload_reads_its_own_photographs_only(tmp_path: Path, outside: Path, kind: int) -> None:
    sent = lp_folder(tmp_path / "sent", LP.replace("b.png", names_of(outside, "b.png")[kind]))
    Image.new("L", (20, 16), 7).save(sent / "b.png")
    capture = read_capture(sent, within=sent)
    assert capture.names[1] == "b.png" and capture.images[1].max() < 0.1, "the one of this name in the upload"
    assert capture.mask.all()
    (sent / "b.png").unlink()
    with pytest.raises(CaptureError, match="there is no such file") as refused:
        read_capture(sent, within=sent)
    assert refused.value.zh is not None


def test_a_photograph_that_is_gone_is_left_out_by_name(tmp_path: Path) -> None:
    folder = lp_folder(tmp_path / "gone", LP.replace("3\n", "4\nC:\\dome\\lost.png 0 -1 1\n"))
    with pytest.raises(CaptureError, match=r"there is no such file.*--leave-out lost\.png"):
        read_capture(folder)
    for name in ("lost.png", "lost"):
        capture = read_capture(folder, leave_out=[name])
        assert capture.names == ("a.png", "b.png", "c.png") and capture.lights[0, 0] > 0.7
    with pytest.raises(CaptureError, match="to leave out, got other"):
        read_capture(folder, leave_out=["lost", "other"])


@pytest.mark.parametrize("kind", range(6))
def test_a_mask_of_an_upload_lies_in_it(tmp_path: Path, outside: Path, kind: int) -> None:
    mask = names_of(outside, "a.png")[kind].replace("a.png", "secret.png")
    (outside / "a.png").rename(outside / "secret.png")
    sent = paper_folder(tmp_path / "sent", mask=mask)
    with pytest.raises(CaptureError, match="expected the mask"):
        read_capture(sent, within=sent)


def test_the_mask_one_folder_up_is_read_only_where_that_belongs_to_the_upload(tmp_path: Path) -> None:
    sent = paper_folder(tmp_path / "sent" / "one")
    mask = np.zeros((16, 20), np.uint8)
    mask[4:9] = 255
    Image.fromarray(mask).save(tmp_path / "sent" / "mask.png")
    assert not read_capture(sent, within=tmp_path / "sent").mask.all()
    assert read_capture(sent, within=sent).mask.all()


@pytest.mark.parametrize("name", ["a.png", "mask.png", "ambient.png", "lights.lp", "capture.json"])
def test_a_link_that_leads_out_of_an_upload_is_refused(tmp_path: Path, outside: Path, name: str) -> None:
    (outside / "secret").write_text("top secret")
    sent = lp_folder(tmp_path / "sent")
    (sent / name).unlink(missing_ok=True)
    (sent / name).symlink_to(outside / ("secret" if name in ("lights.lp", "capture.json") else "a.png"))
    with pytest.raises(CaptureError, match="leads out") as refused:
        read_capture(sent, within=sent)
    assert "top secret" not in str(refused.value)


def test_on_the_command_line_an_lp_may_name_images_anywhere(tmp_path: Path, outside: Path) -> None:
    mine = lp_folder(tmp_path / "mine", LP.replace("b.png", str(outside / "b.png")))
    (mine / "b.png").unlink()
    assert read_capture(mine).names[1] == str(outside / "b.png")
