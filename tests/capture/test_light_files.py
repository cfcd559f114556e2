"""Lamp files as other programs and people write them: each is read, or refused for the true reason."""

from __future__ import annotations

import shutil
import unicodedata
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from rumu.capture.folder import read_capture
from rumu.capture.lights import direction
from rumu.errors import CaptureError
from rumu.values import Capture

LIGHTS = np.array([direction(tilt=60 * i, slant=45) for i in range(6)])
NAMES = tuple(f"p{i}.png" for i in range(6))


def write(folder: Path, names: tuple[str, ...] = NAMES) -> Path:
    """Images of gray 10, 20, 30 ... under these names."""
    for i, name in enumerate(names, start=1):
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        Image.new("L", (20, 16), 10 * i).save(path)
    return folder


def lines(*, names: tuple[str, ...] = NAMES, form: str = "{name} {x:.6f} {y:.6f} {z:.6f}") -> str:
    told = (form.format(name=name, x=x, y=y, z=z) for name, (x, y, z) in zip(names, LIGHTS, strict=False))
    return "\n".join([str(len(names)), *told]) + "\n"


def read(folder: Path, text: str | bytes) -> Capture:
    data = text if isinstance(text, bytes) else text.encode()
    (folder / "lights.lp").write_bytes(data)
    return read_capture(folder)


def check(capture: Capture, names: tuple[str, ...] = NAMES) -> None:
    """These images, in this order, each with its own pixels and lamp."""
    assert [unicodedata.normalize("NFC", name) for name in capture.names] == list(names)
    np.testing.assert_allclose(
        capture.images[:, 0, 0] * 255, [10 * (i + 1) for i in range(len(names))], rtol=1e-5
    )
    np.testing.assert_allclose(capture.lights, LIGHTS[: len(names)], atol=2e-6)


def told(capture: Capture) -> str:
    return "\n".join(note.en for note in capture.notes)


# --- the same lamps, written otherwise --------------------------------------------------------------


@pytest.mark.parametrize("case", ["lp-commadec", "lp-extra", "lp-jpgname", "lp-quoted", "lp-utf16"])
def test_lamp_files_that_went_wrong(cases: Path, case: str) -> None:
    capture = read_capture(cases / case)
    assert capture.names == NAMES and capture.strengths is None
    np.testing.assert_allclose(capture.lights, LIGHTS, atol=2e-6)
    expected = "lights.lp line 2: p0.tif is not there, p0.png was read instead; likewise for 5 more"
    assert told(capture) == (expected if case == "lp-jpgname" else "")


def comma(text: str) -> str:
    return text.replace(".", ",").replace(",png", ".png")


@pytest.mark.parametrize(
    "text",
    [
        lines(form="{name}\t{x:.6f}\t{y:.6f}\t{z:.6f}"),
        lines(form="{name}; {x:.6f} ;{y:.6f};{z:.6f};"),
        lines(form="{name},{x:.6f},{y:.6f},{z:.6f}"),
        lines(form="{name}, {x:.6f}, {y:.6f}, {z:.6f}"),
        lines(form="   {name}    {x:.6f}  {y:.6f}\u00a0{z:.6f}\u00a0"),
        lines(form="{name}\u3000{x:.6f}\u3000{y:.6f}\u3000{z:.6f}"),
        lines(form='"{name}","{x:.6f}","{y:.6f}","{z:.6f}"'),
        lines(form="'{name}' {x:.6f} {y:.6f} {z:.6f}"),
        lines(form="\u201c{name}\u201d {x:.6f} {y:.6f} {z:.6f}"),
        lines(form="{name} {x:.6e} {y:+.6f} {z:.6f} # from rig.txt, 2 m away"),
        comma(lines()),
        comma(lines(form="{name};{x:.6f};{y:.6f};{z:.6f}")),
        comma(lines()).replace("p2.png -0,353553 0,612372", "p2.png -0.353553 0.612372"),
        lines().replace("-", "\u2212"),
        "# the rig\n// of 2021\n\n" + lines().replace("p3", "; not this one\n\n% nor this\np3") + "\n\x1a",
        lines().replace("6\n", "6\nfilename lx ly lz\n", 1),
        lines().replace("6\n", "6;;;\n", 1),
        lines().replace("\n", "\r\n"),
        lines().replace("\n", "\r"),
        lines().replace("p1", "C:\\cap\\shots\\p1").replace("p2", "/home/me/p2").replace("p3", ".\\p3"),
    ],
)  # fmt: skip
def test_lamps_written_otherwise_are_the_same_lamps(tmp_path: Path, text: str) -> None:
    check(read(write(tmp_path), text))


@pytest.mark.parametrize("encoding", ["utf-8-sig", "utf-16", "utf-16-le", "utf-16-be", "utf-32"])
def test_unicode(tmp_path: Path, encoding: str) -> None:
    check(read(write(tmp_path), lines().encode(encoding)))


@pytest.mark.parametrize(
    ("name", "encoding"),
    [
        ("燈右 01.png", "big5"),
        ("灯右 01.png", "gb18030"),
        ("燈右 01.png", "gb18030"),
        ("ランプ右.png", "cp932"),
        ("lumière à droite.png", "cp1252"),
        ("燈右 01.png", "utf-16"),
    ],
)
def test_encodings_of_other_systems(tmp_path: Path, name: str, encoding: str) -> None:
    names = (name, *NAMES[1:])
    check(read(write(tmp_path, names), lines(names=names).encode(encoding)), names)


@pytest.mark.parametrize(("written", "called"), [("NFC", "NFD"), ("NFD", "NFC")])
def test_accents_composed_otherwise(tmp_path: Path, written: str, called: str) -> None:
    names = ("lumière が.png", *NAMES[1:])
    write(tmp_path, tuple(unicodedata.normalize(written, name) for name in names))  # type: ignore[arg-type]
    text = lines(names=names)
    check(read(tmp_path, unicodedata.normalize(called, text)), names)  # type: ignore[arg-type]


def test_names_with_spaces_numbers_and_signs(tmp_path: Path) -> None:
    names = ("shot 1 2 3.png", "a,b;c.png", "7#left.png", "right lamp 3.png", "v1.5 x.png", "IMG (1).png")
    text = lines(names=names).replace("a,b;c.png", '"a,b;c.png"')
    check(read(write(tmp_path, names), text), names)


def test_names_without_a_suffix(tmp_path: Path) -> None:
    names = ("right lamp 3", "shot.1", "12")
    write(tmp_path, tuple(f"{name}.png" for name in names))
    check(read(tmp_path, lines(names=names)), tuple(f"{name}.png" for name in names))


# --- names that are not those on the disk -----------------------------------------------------------


def test_another_case_and_another_suffix(tmp_path: Path) -> None:
    write(tmp_path, ("P0.PNG", "p1.png", "p2.png"))
    capture = read(tmp_path, lines(names=("p0.png", "P1.CR2", "p2.png")))
    check(capture, ("P0.PNG", "p1.png", "p2.png"))
    assert told(capture).startswith(
        "lights.lp line 2: p0.png is not there, P0.PNG was read instead; likewise for 1"
    )
    assert "找不到 p0.png" in capture.notes[0].zh


def test_the_longest_end_of_a_path_from_another_machine(tmp_path: Path) -> None:
    write(tmp_path, ("p0.png", "shots/p0.png", "p1.png", "p2.png"))
    capture = read(tmp_path, lines(names=("D:\\work\\shots\\p0.png", "p1.png", "p2.png")))
    assert capture.names[0] == "shots/p0.png"


def test_a_stem_that_two_images_bear(tmp_path: Path) -> None:
    write(tmp_path, ("p0.png", "p0.jpg", "p1.png", "p2.png"))
    with pytest.raises(CaptureError, match=r"expected one image named p0\.tif, found p0\.jpg, p0\.png"):
        read(tmp_path, lines(names=("p0.tif", "p1.png", "p2.png")))


def test_two_names_of_one_image(tmp_path: Path) -> None:
    with pytest.raises(
        CaptureError, match=r"lights\.lp line 3: p0\.png was named before, in lights\.lp line 2"
    ):
        read(write(tmp_path), lines(names=("p0.png", "P0.tif", "p2.png")))


def test_an_image_that_is_not_there(tmp_path: Path) -> None:
    with pytest.raises(
        CaptureError, match=r"line 3: expected the image gone\.png.* here are p0\.png, p1"
    ) as no:
        read(write(tmp_path), lines(names=("p0.png", "gone.png", "p2.png")))
    zh = "lights.lp 第 3 行：這裡應是照片檔 gone.png，卻沒有這個檔案；這裡有 p0.png, p1.png, p2.png..."
    assert no.value.zh == f"{zh}（--leave-out gone.png 可略過它）。"


# --- strengths and lengths --------------------------------------------------------------------------


@pytest.mark.parametrize("columns", ["{s}", "{s} {s} {s}"])
def test_a_column_of_strengths(tmp_path: Path, columns: str) -> None:
    text = lines(form="{name} {x:.6f} {y:.6f} {z:.6f} " + columns.replace("{s}", "@"))
    rows = text.splitlines()
    given = [1.0, 2.0, 1.0, 0.5, 1.0, 0.5]
    rows[1:] = [row.replace("@", str(one)) for row, one in zip(rows[1:], given, strict=True)]
    capture = read(write(tmp_path), "\n".join(rows))
    check(capture)
    np.testing.assert_allclose(capture.strengths, given)
    assert "taken for the strength of the lamp (0.5 to 2)" in told(capture)


def test_positions_give_their_directions(tmp_path: Path) -> None:
    rows = [f"{n} {300 * (i + 1) * x:.3f} {300 * (i + 1) * y:.3f} {300 * (i + 1) * z:.3f}"
            for i, (n, (x, y, z)) in enumerate(zip(NAMES, LIGHTS, strict=True))]  # fmt: skip
    capture = read(write(tmp_path), "\n".join(["6", *rows]))
    check(capture)
    assert "lengths from 300 to 1.8e+03; they are taken for positions" in told(capture)


def test_no_count_is_read_and_said(tmp_path: Path) -> None:
    capture = read(write(tmp_path), lines().split("\n", 1)[1])
    check(capture)
    assert (
        told(capture) == "lights.lp: the first line does not hold the number of images; all 6 lines were read"
    )


def test_two_images_with_one_lamp(tmp_path: Path) -> None:
    text = lines().replace("p5.png 0.353553 -0.612372", "p5.png 0.353553 0.612372")
    assert told(read(write(tmp_path), text)) == "lights.lp line 7: p5.png has the same lamp as p1.png"


# --- what is refused --------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "message", "zh"),
    [
        (
            lines().replace("6\n", "7\n", 1),
            "lights.lp: line 1 promises 7 images, 6 lines follow",
            "第 1 行說有 7 張",
        ),
        (
            lines().replace("0.353553 0.612372", "0.353553 up", 1),
            "lights.lp line 3: expected 'name x y z', "
            "got 'p1.png 0.353553 up 0.707107': 'up' is not a number",
            "lights.lp 第 3 行：這裡應是「檔名 x y z」",
        ),
        (
            lines().replace("0.612372", "NaN", 1),
            "lights.lp line 3: expected 'name x y z', "
            "got 'p1.png 0.353553 NaN 0.707107': 'NaN' is not a finite number",
            "「NaN」不是有限的數",
        ),
        (
            lines().replace("0.612372", "-inf", 1),
            "line 3: expected 'name x y z', got",
            "「-inf」不是有限的數",
        ),
        (
            lines().replace("0.612372", "0,6,1", 1),
            "line 3: expected 'name x y z', got 'p1.png 0.353553 0,6,1 0.707107': '0,6,1' is not a number",
            "「0,6,1」不是數字",
        ),
        (
            lines().replace("0.612372", "", 1),
            "line 3: expected 'name x y z', got 'p1.png 0.353553  0.707107': "
            "2 numbers follow the name, expected 3",
            "檔名後有 2 個數",
        ),
        (
            lines().replace("0.612372", "1 2 0.6", 1),
            "line 3: expected 'name x y z', got 'p1.png 0.353553 1 2 0.6 "
            "0.707107': 5 numbers follow the name",
            "檔名後有 5 個數",
        ),
        (
            lines(form="{name} {x:.6f} {y:.6f} {z:.6f} 0"),
            "the strength of the lamp must be above 0",
            "應大於 0",
        ),
        (
            lines().replace("0.707107\np2", "0.707107 2\np2", 1),
            "line 2: expected the strength of the lamp after x y z, as on other lines, got none",
            "應像別的行一樣有燈的強度",
        ),
        (
            lines(form="{x:.6f} {y:.6f} {z:.6f} {name}"),
            "line 2: expected 'name x y z', got '0.707107 0.000000",
            "檔名後有 0 個數",
        ),
        (
            lines(form="{name} {x:.6f} {y:.6f} -{z:.6f}"),
            "lights.lp: expected lamps on the camera's side (x right, "
            "y up, z to the camera), got z below 0 for all",
            "所有的 z 都小於 0",
        ),
        (
            lines().replace("0.612372 0.707107", "0.612372 -0.1", 1),
            "lights.lp line 3: expected a lamp on the "
            "camera's side (z > 0, z points to the camera), got z = -0.14",
            "lights.lp 第 3 行：燈應在相機這一側",
        ),
        (
            lines().replace("0.353553 0.612372 0.707107", "0 0 0", 1),
            "lights.lp line 3: expected a direction toward the lamp, got a zero vector",
            "卻是零向量",
        ),
        ("", "lights.lp line 1: expected the number of images, got an empty file", "檔案卻是空的"),
        (
            b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR\0\0",
            "lights.lp: expected a text file, found other data",
            "應是文字檔",
        ),
        (
            b"6\n" + b"\xff\x81\x80 \x00\x01" * 9,
            "lights.lp: expected a text file, found other data",
            "應是文字檔",
        ),
        (b"#" * 5_000_000, "lights.lp: expected a text file, found other data", "應是文字檔"),
    ],
)
def test_what_cannot_be_read_says_where_and_why(tmp_path: Path, text: str, message: str, zh: str) -> None:
    with pytest.raises(CaptureError) as refused:
        read(write(tmp_path), text)
    assert message in str(refused.value) and str(tmp_path) not in str(refused.value)
    assert refused.value.zh is not None and zh in refused.value.zh and str(tmp_path) not in refused.value.zh


# --- light_directions.txt ---------------------------------------------------------------------------


@pytest.mark.parametrize("form", ["{:.6f} {:.6f} {:.6f}", "{:.6f};{:.6f};{:.6f}", "{:.6f}, {:.6f}, {:.6f}",
                                  "{:.6f},{:.6f},{:.6f}", "{:.6f}\t{:.6f}\t{:.6f} # a lamp"])  # fmt: skip
@pytest.mark.parametrize("decimal", [".", ","])
def test_tables_written_otherwise(tmp_path: Path, form: str, decimal: str) -> None:
    if decimal == "," and "," in form:
        pytest.skip("nobody writes both commas")
    rows = [form.format(*light).replace(".", decimal) for light in LIGHTS]
    (write(tmp_path) / "light_directions.txt").write_text("# x y z\n\n" + "\n".join(rows), encoding="utf-16")
    check(read_capture(tmp_path))


def test_a_table_in_which_commas_do_both_is_refused(tmp_path: Path) -> None:
    rows = ["{:.6f},{:.6f},{:.6f}".format(*light).replace(".", ",") for light in LIGHTS]
    (write(tmp_path) / "light_directions.txt").write_text("\n".join(rows))
    with pytest.raises(CaptureError, match=r"light_directions\.txt line 1: expected a table"):
        read_capture(tmp_path)


# --- which way round the photographs are ------------------------------------------------------------


def photographs(folder: Path, orientations: list[int], *, lamps: str) -> Path:
    """a, b, c and d of 32 x 16 pixels, bright on the left as they are stored, each a little brighter."""
    stored = np.full((16, 32), 60, np.uint8)
    stored[:, :16] = 200
    for number, (stem, orientation) in enumerate(zip("abcd", orientations, strict=True)):
        image = Image.fromarray(stored + np.uint8(4 * number))
        image.getexif()[0x0112] = orientation
        image.save(folder / f"{stem}.jpg", exif=image.getexif(), quality=95)
    tilts = {"a": 0, "b": 90, "c": 180, "d": 270}
    if lamps == "lp":
        vectors = (direction(tilt=tilt, slant=45) for tilt in tilts.values())
        rows = [f"{n}.jpg {x} {y} {z}" for n, (x, y, z) in zip(tilts, vectors, strict=True)]
        (folder / "lights.lp").write_text("\n".join(["4", *rows]))
    else:
        (folder / "capture.json").write_text('{"slant": 45}')
    return folder


@pytest.mark.parametrize("orientations", [[6, 6, 6, 6], [1, 3, 1, 3], [1, 6, 8, 3]])
def test_frames_of_a_fixed_camera_are_not_turned(tmp_path: Path, orientations: list[int]) -> None:
    capture = read_capture(photographs(tmp_path, orientations, lamps="lp"))
    assert capture.images.shape == (4, 16, 32) and capture.orientation == "stored"
    assert (capture.images[:, :, :14] > 0.4).all() and (capture.images[:, :, 18:] < 0.2).all()
    (note,) = capture.notes
    assert "read as the camera stored them" in note.en and "不轉動照片" in note.zh
    assert ("a.jpg" in note.en) == (orientations[0] != 1) and "b.jpg" in note.en


def test_lamps_told_by_the_look_of_the_pictures_go_with_what_is_shown(tmp_path: Path) -> None:
    capture = read_capture(photographs(tmp_path, [6, 6, 6, 6], lamps="json"))
    assert capture.images.shape == (4, 32, 16) and capture.orientation == "exif"
    assert (capture.images[:, :14] > 0.4).all() and "turned upright" in capture.notes[0].en


def test_a_position_sensor_that_changed_its_mind_is_not_believed(tmp_path: Path) -> None:
    capture = read_capture(photographs(tmp_path, [1, 3, 6, 1], lamps="json"))
    assert capture.images.shape == (4, 16, 32) and capture.orientation == "stored"


def test_the_orientation_may_be_said(tmp_path: Path) -> None:
    photographs(tmp_path, [6, 6, 6, 6], lamps="lp")
    assert read_capture(tmp_path, orientation="exif").images.shape == (4, 32, 16)
    (tmp_path / "capture.json").write_text('{"orientation": "exif"}')
    assert read_capture(tmp_path).orientation == "exif"
    (tmp_path / "capture.json").write_text('{"orientation": "sideways"}')
    with pytest.raises(CaptureError, match="\"orientation\" among auto, stored, exif, got 'sideways'"):
        read_capture(tmp_path)


def test_turned_frames_of_different_sizes_are_refused(tmp_path: Path) -> None:
    photographs(tmp_path, [1, 6, 1, 1], lamps="lp")
    with pytest.raises(CaptureError, match=r"b\.jpg: expected 32 x 16 pixels as in a\.jpg, got 16 x 32"):
        read_capture(tmp_path, orientation="exif")


@pytest.mark.parametrize("case", ["ps-exif180-some", "ps-exif6-all"])
def test_turned_frames_give_the_stored_surface(cases: Path, tmp_path: Path, case: str) -> None:
    from rumu.surface.photometric import photometric

    plain = tmp_path / "plain"
    shutil.copytree(cases / case, plain)
    for path in plain.glob("*.jpg"):
        with Image.open(path) as image:
            quantized = image.copy()
        quantized.save(path.with_suffix(".png"))
        path.unlink()
    (plain / "capture.json").write_text('{"encoding": "srgb"}')
    expected, got = (photometric(read_capture(folder)) for folder in (plain, cases / case))
    np.testing.assert_allclose(got.height, expected.height, atol=1e-3)
    assert read_capture(cases / case).notes and got.height.max() > 3


def test_photographs_that_the_lamp_file_does_not_name_are_told(tmp_path: Path) -> None:
    """A mask, an ambient frame and previews of another kind are none of them."""
    for name in ("ambient.png", "p9.jpg"):
        Image.new("L", (20, 16)).save(tmp_path / name)
    Image.new("L", (20, 16), 255).save(tmp_path / "mask.png")
    capture = read(write(tmp_path), lines(names=NAMES[:4]))
    check(capture, NAMES[:4])
    assert told(capture) == "lights.lp does not name 2 of the photographs, which are not used: p4.png, p5.png"
