"""What a file is, what is said of files that are not read, and formats beyond the usual ones."""

from __future__ import annotations

import io
import pickle
import struct
import sys
import zlib
from pathlib import Path

import cv2
import numpy as np
import pytest
import tifffile
from PIL import Image

from rumu.capture.decoded_size import MEMORY_VARIABLE, Reduction
from rumu.capture.formats import decode, read_header
from rumu.capture.image import read_image
from rumu.errors import ImageError, RumuError

RNG = np.random.default_rng(3)
SMOOTH = np.add.outer(np.arange(90), np.arange(120))[:, :, None] * np.array([0.6, 0.9, 1.1]) % 256


def picture(width: int = 120, height: int = 90) -> Image.Image:
    return Image.fromarray(SMOOTH.astype(np.uint8)).resize((width, height))


needs_proc = pytest.mark.skipif(not Path("/proc/self/status").exists(), reason="only Linux tells the peak")


def peak_memory_of(code: str) -> tuple[int, str]:
    """Kilobytes that a fresh process takes at most to run the code, and what it prints."""
    import subprocess

    # ru_maxrss of a child begins with what its parent had
    measured = f"{code}\nprint(open('/proc/self/status').read().split('VmHWM:')[1].split()[0])"
    done = subprocess.run([sys.executable, "-c", measured], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    *printed, peak = done.stdout.splitlines()
    return int(peak), "\n".join(printed)


def refused_memory(path: Path) -> tuple[int, str]:
    return peak_memory_of(
        "from rumu.capture.image import read_image\nfrom rumu.errors import ImageError\n"
        f"try:\n    read_image({str(path)!r})\nexcept ImageError as error:\n    print(error)\n"
        "else:\n    print('read')"
    )


# --- formats of phones -----------------------------------------------------------------------------


def test_mpo_is_read_as_its_first_picture(tmp_path: Path, cases: Path) -> None:
    first, second = picture(), picture().transpose(Image.Transpose.FLIP_TOP_BOTTOM)
    first.save(tmp_path / "a.mpo", save_all=True, append_images=[second])
    first.save(tmp_path / "a.jpg")
    assert read_header(tmp_path / "a.mpo").format == "MPO"
    np.testing.assert_array_equal(read_image(tmp_path / "a.mpo"), read_image(tmp_path / "a.jpg"))
    assert read_image(cases / "images/mpo.jpg").shape == (400, 400, 3)


def test_avif(tmp_path: Path) -> None:
    picture().save(tmp_path / "a.avif", quality=95)
    image = read_image(tmp_path / "a.avif")
    assert decode(tmp_path / "a.avif").display
    assert np.abs(image - SMOOTH.astype(np.uint8) / 255).mean() < 0.02


def test_heic_is_read_with_pillow_heif(tmp_path: Path) -> None:
    heif = pytest.importorskip("pillow_heif")
    heif.from_pillow(picture()).save(tmp_path / "a.heic", quality=95)
    image = read_image(tmp_path / "a.heic")
    assert image.shape == (90, 120, 3) and decode(tmp_path / "a.heic").display
    assert np.abs(image - SMOOTH.astype(np.uint8) / 255).mean() < 0.02


def test_heic_without_pillow_heif_says_what_to_do(cases: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "pillow_heif", None)
    with pytest.raises(ImageError, match=r"x\.heic: this is an HEIC picture.*rumu\[heif\].*JPEG") as caught:
        read_image(cases / "images/x.heic")
    assert caught.value.zh is not None and "rumu[heif]" in caught.value.zh and "HEIC" in caught.value.zh
    assert str(cases) not in caught.value.en + caught.value.zh


def test_broken_heic_is_named(cases: Path) -> None:
    pytest.importorskip("pillow_heif")
    with pytest.raises(ImageError, match="the HEIC image is cut short or broken"):
        read_image(cases / "images/x.heic")


def test_avif_without_support_says_what_to_do(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from PIL import features

    picture().save(tmp_path / "a.avif")
    monkeypatch.setattr(features, "check", lambda name: False)
    with pytest.raises(ImageError, match="this is an AVIF picture, which needs Pillow"):
        read_image(tmp_path / "a.avif")


@pytest.mark.parametrize(
    ("head", "kind"),
    [
        (b"%PDF-1.7", "a PDF"),
        (b"\0\0\0\x0cjP  \r\n\x87\n", "a JPEG 2000 picture"),
        (b"8BPS\0\1", "a Photoshop file"),
    ],
)
def test_other_kinds_are_named(tmp_path: Path, head: bytes, kind: str) -> None:
    (tmp_path / "a.jpg").write_bytes(head + bytes(500))
    with pytest.raises(ImageError, match=f"found {kind}"):
        read_image(tmp_path / "a.jpg")


def test_errors_keep_their_words_between_processes(tmp_path: Path) -> None:
    (tmp_path / "a.png").write_bytes(b"GIF89a no more")
    with pytest.raises(ImageError) as caught:
        read_image(tmp_path / "a.png")
    back = pickle.loads(pickle.dumps(caught.value))
    assert (str(back), back.en, back.zh) == (str(caught.value), caught.value.en, caught.value.zh)
    assert str(tmp_path) in str(back) and str(tmp_path) not in back.en


# --- reduced while they are read -------------------------------------------------------------------


@pytest.mark.parametrize("suffix", ["jpg", "png", "tif"])
def test_a_large_picture_is_reduced(tmp_path: Path, suffix: str) -> None:
    path = tmp_path / f"a.{suffix}"
    picture(1200, 900).save(path)
    whole = decode(path)
    assert whole.values.shape == (900, 1200, 3) and whole.whole == (1200, 900)
    by_side = decode(path, reduction=Reduction(side=300))
    assert by_side.values.shape == (225, 300, 3) and by_side.whole == (1200, 900)
    by_pixels = decode(path, reduction=Reduction(pixels=270_000))
    assert by_pixels.values.shape == (450, 600, 3)
    wanted = np.asarray(picture(1200, 900).resize((300, 225), Image.Resampling.BOX), np.float32)
    assert np.abs(by_side.values - wanted).mean() < 2


def test_a_reduced_picture_is_turned_with_its_whole_size(tmp_path: Path) -> None:
    exif = Image.Exif()
    exif[0x0112] = 6
    picture(1200, 900).save(tmp_path / "a.jpg", exif=exif)
    stored = decode(tmp_path / "a.jpg", reduction=Reduction(side=400))
    assert stored.values.shape == (400, 300, 3) and stored.whole == (900, 1200)


def test_a_small_picture_is_not_changed(tmp_path: Path) -> None:
    picture().save(tmp_path / "a.jpg")
    reduced = decode(tmp_path / "a.jpg", reduction=Reduction(side=4000, pixels=10**7))
    np.testing.assert_array_equal(reduced.values, decode(tmp_path / "a.jpg").values)


def test_what_is_reduced_lies_on_white(tmp_path: Path) -> None:
    clear = np.zeros((64, 64, 4), np.uint8)
    clear[:, :32] = (255, 0, 0, 255)
    Image.fromarray(clear).save(tmp_path / "a.png")
    stored = decode(tmp_path / "a.png", reduction=Reduction(side=32))
    assert stored.alpha is None
    np.testing.assert_array_equal(stored.values[5, [2, 30]], [[255, 0, 0], [255, 255, 255]])


# --- memory ----------------------------------------------------------------------------------------


def tiff_bomb(path: Path, **tags: int) -> Path:
    """A TIFF of a hundred bytes that says that it is as large as the tags say."""
    of = {"width": 100, "length": 100, "bits": 8, "samples": 1, "depth": 1} | tags
    entries = [
        (256, 4, of["width"]), (257, 4, of["length"]), (258, 3, of["bits"]), (259, 3, 8), (262, 3, 1),
        (277, 3, of["samples"]), (32997, 4, of["depth"]),
    ]  # fmt: skip
    if "tile" in of:
        entries += [(322, 4, of["tile"]), (323, 4, of["tile"]), (324, 4, 8), (325, 4, 8)]
    else:
        entries += [(273, 4, 8), (278, 4, of["length"]), (279, 4, 8)]
    entries.sort()
    body = struct.pack("<2sHI", b"II", 42, 8) + struct.pack("<H", len(entries))
    body += b"".join(struct.pack("<HHII", tag, kind, 1, value) for tag, kind, value in entries)
    path.write_bytes(body + bytes(4))
    return path


@needs_proc
@pytest.mark.parametrize(
    ("tags", "reason"),
    [
        ({"width": 10000, "length": 10000, "bits": 16, "depth": 64}, "volume of 64 slices"),
        ({"width": 10000, "length": 10000, "samples": 60}, "MB once decoded"),
        ({"width": 8000, "length": 8000, "bits": 32, "samples": 4}, "MB once decoded"),
        ({"tile": 60000, "bits": 16}, "MB once decoded"),
        ({"tile": 60000}, "MB once decoded"),
        ({"width": 100_000, "length": 100_000}, "megapixels"),
    ],
)
def test_tiff_that_would_fill_the_memory(tmp_path: Path, tags: dict[str, int], reason: str) -> None:
    peak, printed = refused_memory(tiff_bomb(tmp_path / "a.tif", **tags))
    assert reason in printed
    assert peak < 150_000


def test_two_widths_in_a_header_are_a_broken_file(tmp_path: Path) -> None:
    path = tiff_bomb(tmp_path / "a.tif")
    data = bytearray(path.read_bytes())
    struct.pack_into("<HHI", data, 10, 256, 3, 2)  # width: two of 16 bits
    path.write_bytes(data)
    for read in (read_header, read_image):
        with pytest.raises(ImageError, match=r"a\.tif: the image is cut short or broken"):
            read(path)


@needs_proc
def test_small_files_with_large_pictures(cases: Path) -> None:
    peak, printed = refused_memory(cases / "hostile/bomb-depth.tif")
    assert "volume of 64 slices" in printed and peak < 150_000


@needs_proc
@pytest.mark.parametrize("compression", ["zlib", "lzma"])
def test_strips_that_hold_more_than_the_picture(tmp_path: Path, compression: str) -> None:
    import lzma

    path = tmp_path / "a.tif"
    tifffile.imwrite(path, np.zeros((64, 64), np.float32), compression=compression, rowsperstrip=64)
    with tifffile.TiffFile(path) as tiff:
        (start,), counts = tiff.pages[0].dataoffsets, tiff.pages[0].tags[279]
    bomb = (zlib if compression == "zlib" else lzma).compress(bytes(400_000_000))
    data = bytearray(path.read_bytes()[:start] + bomb)
    struct.pack_into("<I" if counts.dtype == 4 else "<H", data, counts.valueoffset, min(len(bomb), 65535))
    path.write_bytes(data)
    peak, printed = refused_memory(path)
    assert "cut short or broken" in printed and peak < 300_000


def test_every_channel_and_part_of_an_exr_counts(tmp_path: Path) -> None:
    import OpenEXR

    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    plane = np.zeros((200, 300), np.float32)
    OpenEXR.File(header, {"Y": plane}).write(str(tmp_path / "one.exr"))
    OpenEXR.File(header, {"Y": plane, **{f"n{i}": plane for i in range(9)}}).write(str(tmp_path / "ten.exr"))
    parts = [
        OpenEXR.Part(header | {"name": name}, {"Y": plane.astype(np.float16), "Z": plane}) for name in "abc"
    ]
    OpenEXR.File(parts).write(str(tmp_path / "parts.exr"))
    pixels = 200 * 300
    image = read_header(tmp_path / "one.exr").image_memory()
    assert read_header(tmp_path / "one.exr").memory() - image == 4 * pixels
    assert read_header(tmp_path / "ten.exr").memory() - image == 40 * pixels
    assert read_header(tmp_path / "parts.exr").memory() - image == 3 * 6 * pixels


def test_progressive_jpeg_counts_its_coefficients(tmp_path: Path) -> None:
    picture().save(tmp_path / "plain.jpg")
    picture().save(tmp_path / "progressive.jpg", progressive=True)
    more = read_header(tmp_path / "progressive.jpg").memory() - read_header(tmp_path / "plain.jpg").memory()
    assert more == 2 * 3 * 120 * 90


def test_jpeg_of_very_many_scans(tmp_path: Path) -> None:
    stream = io.BytesIO()
    picture().save(stream, "JPEG", progressive=True)
    data = stream.getvalue()
    scan = data[data.rindex(b"\xff\xda") : -2]
    (tmp_path / "a.jpg").write_bytes(data[:-2] + scan * 200 + b"\xff\xd9")
    with pytest.raises(ImageError, match="at most 100 scans, got 2"):
        read_image(tmp_path / "a.jpg")


@pytest.mark.parametrize("suffix", ["png", "jpg", "webp", "bmp", "gif", "ppm", "tif", "avif"])
def test_the_operator_sets_the_memory(tmp_path: Path, suffix: str, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / f"a.{suffix}"
    picture(400, 400).save(path)
    monkeypatch.setenv(MEMORY_VARIABLE, "1")
    with pytest.raises(ImageError, match=r"at most 1 MB once decoded, 1 picture would take \d MB") as caught:
        read_image(path)
    assert caught.value.zh is not None and MEMORY_VARIABLE in caught.value.zh
    monkeypatch.setenv(MEMORY_VARIABLE, "5")
    assert read_image(path).shape[:2] == (400, 400)


@pytest.mark.parametrize("text", ["many", "0", "-5", "1.5"])
def test_memory_that_is_no_number(tmp_path: Path, text: str, monkeypatch: pytest.MonkeyPatch) -> None:
    picture().save(tmp_path / "a.png")
    monkeypatch.setenv(MEMORY_VARIABLE, text)
    with pytest.raises(RumuError, match=f"{MEMORY_VARIABLE}: expected a whole number of megabytes"):
        read_image(tmp_path / "a.png")


@needs_proc
@pytest.mark.parametrize(("mode", "channels"), [("L", 1), ("RGB", 3), ("RGBA", 4)])
def test_what_is_read_takes_what_was_counted(tmp_path: Path, mode: str, channels: int) -> None:
    path = tmp_path / "a.png"
    pixels = 4000 * 3000
    noise = RNG.integers(0, 255, (30, 40, channels), dtype=np.uint8)
    small = Image.fromarray(noise.squeeze(), mode)
    small.resize((4000, 3000), Image.Resampling.NEAREST).save(path, compress_level=1)
    counted = read_header(path).memory()
    assert counted == pixels * channels * 5
    empty, _ = peak_memory_of("import rumu.capture.image, numpy, cv2, PIL.Image")
    peak, printed = refused_memory(path)
    assert printed == "read"
    assert (peak - empty) * 1024 < 1.4 * counted + 30_000_000


def write_lzw_after_preview(path: Path, whole: np.ndarray, *, within: bool) -> None:
    """A TIFF packed by LZW, which tifffile cannot write, with a preview of 15 x 10 before or around it."""
    data = bytearray(cv2.imencode(".tif", whole, [cv2.IMWRITE_TIFF_COMPRESSION, 5])[1].tobytes())
    preview, (first,) = bytes(150), struct.unpack_from("<I", data, 4)
    entries = [(254, 1), (256, 15), (257, 10), (258, 8), (259, 1), (262, 1), (273, len(data))]
    entries += [(277, 1), (278, 10), (279, 150), *([(330, first)] if within else [])]
    data += preview
    struct.pack_into("<I", data, 4, len(data))
    data += struct.pack("<H", len(entries))
    data += b"".join(struct.pack("<HHII", tag, 4, 1, value) for tag, value in entries)
    path.write_bytes(data + struct.pack("<I", 0 if within else first))


@pytest.mark.parametrize("within", [False, True])
@pytest.mark.parametrize(
    ("depth", "packing"), [("uint16", None), ("uint16", "deflate"), ("uint8", None), ("uint16", "lzw")]
)
def test_a_tiff_that_begins_with_its_preview(tmp_path: Path, depth: str, packing: str, within: bool) -> None:
    """As some cameras and developers of raw files write them: before the picture, or around it (SubIFD)."""
    whole = (np.arange(40 * 60).reshape(40, 60) * (np.iinfo(depth).max // 2400)).astype(depth)
    path = tmp_path / "a.tif"
    if packing == "lzw":
        write_lzw_after_preview(path, whole, within=within)
    else:
        with tifffile.TiffWriter(path) as file:
            file.write(np.zeros((10, 15), np.uint8), subfiletype=1, subifds=int(within))
            file.write(whole, subfiletype=0, compression=packing)
    assert read_header(path).width == 60
    np.testing.assert_array_equal(decode(path, encoding="linear").values, whole)
