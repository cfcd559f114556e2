import io
import struct
import zlib

import numpy as np
import pytest
from PIL import Image

from rumu.capture.exif import PhotographFacts, read_facts


def write(path, *, main=(), details=()):
    exif = Image.Exif()
    for key, value in main:
        exif[key] = value
    part = exif.get_ifd(0x8769)
    for key, value in details:
        part[key] = value
    Image.fromarray(np.zeros((16, 16), np.uint8)).save(path, exif=exif)
    return path


def test_what_a_camera_writes(tmp_path):
    main = [(0x010F, "Canon"), (0x0110, "Canon EOS R5"), (0x013B, "A. Writer"), (0x010E, "永\0rest".encode())]
    details = [
        *((0x829A, 1 / 125), (0x829D, 8.0), (0x8827, 100), (0x920A, 100.0), (0xA405, 100)),
        *((0x9003, "2026:05:04 20:15:00"), (0xA434, "RF100mm F2.8 L")),
    ]
    found = read_facts(write(tmp_path / "a.jpg", main=main, details=details))
    assert found.camera == "Canon EOS R5" and found.lens == "RF100mm F2.8 L"
    assert found.exposure == pytest.approx(1 / 125) and found.f_number == 8 and found.iso == 100
    assert found.focal_mm == 100 and found.focal_35_mm == 100
    assert found.taken == "2026:05:04 20:15:00" and found.caption == "永"


def test_iptc_says_who_made_it(tmp_path):
    def entry(number, text):
        data = text.encode()
        return bytes([0x1C, 2, number]) + len(data).to_bytes(2, "big") + data

    block = entry(5, "Orchid Pavilion") + entry(80, "A. Photographer") + entry(116, "CC0")
    resource = b"8BIM\x04\x04\x00\x00" + len(block).to_bytes(4, "big") + block + b"\0" * (len(block) % 2)
    stream = io.BytesIO()
    Image.new("L", (16, 16)).save(stream, "JPEG")
    marker = b"Photoshop 3.0\0" + resource
    data = stream.getvalue()
    app13 = b"\xff\xed" + (len(marker) + 2).to_bytes(2, "big") + marker
    (tmp_path / "a.jpg").write_bytes(data[:2] + app13 + data[2:])
    found = read_facts(tmp_path / "a.jpg")
    assert (found.title, found.author, found.rights) == ("Orchid Pavilion", "A. Photographer", "CC0")


@pytest.mark.parametrize("content", [b"", b"words", b"\xff\xd8\xff\xe1\x00\x10Exif\0\0junk"])
def test_what_cannot_be_read_says_nothing(tmp_path, content):
    (tmp_path / "a.jpg").write_bytes(content)
    assert read_facts(tmp_path / "a.jpg") == PhotographFacts()


def test_what_stands_behind_the_picture_of_a_png_is_read_and_the_picture_is_not(tmp_path):
    stream, exif = io.BytesIO(), Image.Exif()
    exif[0x010F] = "Canon"
    Image.new("L", (16, 16)).save(stream, "PNG")
    head, picture = stream.getvalue().split(b"IDAT")
    broken = picture[:1] + bytes(len(picture) - 17) + picture[-16:]
    told = exif.tobytes().removeprefix(b"Exif\0\0")
    part = struct.pack(">I", len(told)) + b"eXIf" + told + struct.pack(">I", zlib.crc32(b"eXIf" + told))
    (tmp_path / "a.png").write_bytes(head + b"IDAT" + broken[:-12] + part + broken[-12:])
    with pytest.raises((OSError, SyntaxError)), Image.open(tmp_path / "a.png") as opened:
        opened.load()
    assert read_facts(tmp_path / "a.png").camera == "Canon"


def test_nonsense_is_none(tmp_path):
    path = write(tmp_path / "a.jpg", details=[(0x829A, 0.0), (0x9003, " \0")])
    assert read_facts(path) == PhotographFacts()
