"""Tables of lamps as spreadsheets and programs write them: each is read, or refused for the true reason."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from rumu.capture.folder import read_capture
from rumu.capture.lights import direction
from rumu.errors import CaptureError
from rumu.values import Capture

NAMES = tuple(f"p{i}.png" for i in range(4))
TILTS, SLANT = (0, 90, 180, 270), 35
LIGHTS = np.array([direction(tilt=tilt, slant=SLANT) for tilt in TILTS])
XYZ = "{name},{x:.5f},{y:.5f},{z:.5f}"


def write(folder: Path, names: tuple[str, ...] = NAMES) -> Path:
    for i, name in enumerate(names, start=1):
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        Image.new("L", (12, 10), 10 * i).save(path)
    return folder


def table(form: str, *, header: str = "", names: tuple[str, ...] = NAMES, length: float = 1.0) -> str:
    rows = [header] if header else []
    for i, (name, tilt, light) in enumerate(zip(names, TILTS, LIGHTS, strict=True), start=1):
        x, y, z = light * length
        rows.append(form.format(i=i, name=name, x=x, y=y, z=z, tilt=tilt, up=90 - SLANT))
    return "\n".join(rows) + "\n"


def read(folder: Path, text: str | bytes, *, called: str = "lamps.csv") -> Capture:
    (folder / called).write_bytes(text if isinstance(text, bytes) else text.encode())
    return read_capture(folder)


def check(capture: Capture, names: tuple[str, ...] = NAMES) -> None:
    assert capture.names == names
    np.testing.assert_allclose(capture.images[:, 0, 0] * 255, [10, 20, 30, 40], rtol=1e-5)
    np.testing.assert_allclose(capture.lights, LIGHTS, atol=2e-5)


COMMAS = table(XYZ.replace(",", ";")).replace(".", ",").replace(",png", ".png")


@pytest.mark.parametrize(
    "text",
    [
        table(XYZ),
        table(XYZ, header="Image,X,Y,Z"),
        table(XYZ, header="sep=,\nfile name,light_x,light_y,light_z"),
        table(XYZ.replace(",", "\t"), header="name\tx\ty\tz"),
        table(XYZ.replace(",", ";"), header="檔名;x;y;z"),
        "name;x;y;z\n" + COMMAS,
        COMMAS.replace(";", "\t"),
        table('"{name}", "{x:.5f}", "{y:.5f}", "{z:.5f}"'),
        table("{x:.5f},{y:.5f},{z:.5f}"),
        table("{x:.5f},{y:.5f},{z:.5f}", header="x,y,z"),
        table("{i},{x:.5f},{y:.5f},{z:.5f}"),
        table("{i},{x:.5f},{y:.5f},{z:.5f}", header="image,x,y,z"),
        table("{i},{name},{x:.5f},{y:.5f},{z:.5f}"),
        "4\n" + table(XYZ),
        "# a dome\n" + table(XYZ, header="name,x,y,z") + "\n,,,\n",
        table(XYZ, length=300.0),
        table(XYZ, length=300.0, header="name,x (mm),y (mm),z (mm)"),
        table("{name},{x:.5f},{y:.5f},{z:.5f},,", header="name,x,y,z,,"),
        table("{name},{tilt},{up}", header="name,azimuth,elevation"),
        table("{name},{tilt}°,{up}°", header="Filename,Azimuth (°),Elevation (deg)"),
        table("{up},{tilt}", header="elevation,azimuth"),
        table("{name},{tilt}," + str(SLANT), header="name,azimuth_deg,zenith_deg"),
        table("{name};{tilt},0;{up},0", header="照片;方位角（度）;仰角（度）"),
        table("{tilt},{up},{x:.5f},{y:.5f},{z:.5f}", header="azimuth,elevation,x,y,z"),
        table(r"D:\dome\{name},{x:.5f},{y:.5f},{z:.5f}"),
        table(XYZ.replace("{name}", "other/{name}")),
        table(XYZ).replace(".png", ""),
        table(XYZ).replace("p0", "P0").replace(".png", ".NEF"),
    ],
)
def test_one_table_written_otherwise(tmp_path: Path, text: str) -> None:
    check(read(write(tmp_path), text))


@pytest.mark.parametrize("encoding", ["gb18030", "utf-8-sig", "utf-16", "big5"])
def test_encodings_and_chinese_names(tmp_path: Path, encoding: str) -> None:
    names = ("東燈.png", "北燈.png", "西燈.png", "南燈.png")
    text = table(XYZ, header="照片,x,y,z", names=names)
    check(read(write(tmp_path, names), text.encode(encoding), called="燈位.csv"), names)


def test_radians_that_are_called_so(tmp_path: Path) -> None:
    rows = [
        f"{name},{np.radians(tilt)},{np.radians(90 - SLANT)}" for name, tilt in zip(NAMES, TILTS, strict=True)
    ]
    check(read(write(tmp_path), "\n".join(["name,azimuth (rad),elevation (rad)", *rows])))


def test_strengths_and_columns_of_no_use(tmp_path: Path) -> None:
    text = table(XYZ + ",{i},1/60", header="name,x,y,z,intensity,exposure")
    capture = read(write(tmp_path), text)
    check(capture)
    np.testing.assert_allclose(capture.strengths, np.array([1, 2, 3, 4]) / 2.5)
    notes = "\n".join(note.en for note in capture.notes)
    assert "strength of the lamp" in notes and "not used: exposure" in notes


def test_the_reading_of_angles_is_told(tmp_path: Path) -> None:
    capture = read(write(tmp_path), table("{name},{tilt},{up}", header="name,azimuth,elevation"))
    assert "counter-clockwise from the right" in capture.notes[0].en


def test_which_file_is_taken(tmp_path: Path) -> None:
    folder = write(tmp_path)
    (folder / "prices.csv").write_text("object,price\nscroll,3\n")
    check(read(folder, table(XYZ)))
    check(
        read(folder, table(XYZ.replace(",", "\t")), called="lights.tsv")
        if False
        else read_capture(folder / "lamps.csv")
    )
    (folder / "light_positions.csv").write_text(table(XYZ))
    with pytest.raises(CaptureError, match=r"found lamps.csv, light_positions.csv; expected one"):
        read_capture(folder)


@pytest.mark.parametrize(
    ("text", "message", "zh"),
    [
        ("", "expected a table of lamps, got no row", "沒有內容"),
        ("object,price\nscroll,3\n", "got object, price; name the columns", "卻是 object, price"),
        (table("{name},{tilt},{up}"), "cannot tell what the numbers mean in 'p0.png, 0, 55'", "看不出"),
        (table("{name},{tilt},{up},500"), "cannot tell what the numbers mean", "看不出"),
        (table("{name},{tilt},{up}", header="name,phi,theta"), "got name, phi, theta", "phi"),
        (table("{name},0.{i},1.1", header="name,azimuth,elevation"), "got none above 1.1", "弧度"),
        (table("{tilt},-{up}", header="azimuth,elevation"), "expected elevation from 0 to 90", "0 到 90"),
        ("x,y,z\n" + table("{x:.5f},{y:.5f},?"), r"line 2: expected a number for z, got '\?'", "z 應是數字"),
        ("name,x,y,z\n" + COMMAS.replace(";", ","), "expected 4 cells, as in .*, got 7", "小數用逗號"),
        (table("{name},{x:.5f},{y:.5f},-{z:.5f}", header="name,x,y,z"), "z below 0 for all", "z 都小於 0"),
        (table(XYZ).replace("p1.png", "p0.png"), "p0.png was named before, in lamps.csv", "已經出現過"),
        (table(XYZ).replace("p1.png", "q.png"), "expected the image q.png, there is no such file", "q.png"),
        ("3\n" + table(XYZ), "line 1 promises 3 images, 4 lines follow", "後面卻有 4 行"),
        (table("{x:.5f},{y:.5f},{z:.5f}") * 2, "holds 8 lamps, but 4 images lie beside it", "8 盞燈"),
        (table(XYZ + ",0", header="name,x,y,z,strength"), "strength of the lamp must be above 0", "強度"),
        (table(",{x:.5f},{y:.5f},{z:.5f}", header="name,x,y,z"), "expected the name of an image", "檔名"),
        (b"PK\x03\x04\0\0\x01\x02", "expected a text file", "文字檔"),
    ],
)  # fmt: skip
def test_what_cannot_be_read_says_where_and_why(
    tmp_path: Path, text: str | bytes, message: str, zh: str
) -> None:
    with pytest.raises(CaptureError, match=message) as caught:
        read(write(tmp_path), text)
    assert str(caught.value).startswith("lamps.csv") and zh in (caught.value.zh or "")
