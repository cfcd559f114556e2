"""Relightable images in and out by the name of the file: .ptm, .rti, or a folder with an info.json."""

from __future__ import annotations

from pathlib import Path

from rumu.errors import ImageError
from rumu.rti.binary_files import read_hsh, read_ptm, write_hsh, write_ptm
from rumu.rti.image import RtiImage
from rumu.rti.planes import INFO, read_planes, write_planes
from rumu.rti.sampled import SampledImage
from rumu.values import Capture


def is_rti(path: str | Path) -> bool:
    """Whether a path names a relightable image: a .ptm, a .rti, an info.json or a folder that holds one."""
    path = Path(path)
    return path.suffix.lower() in (".ptm", ".rti") or path.name == INFO or (path / INFO).is_file()


def read_rti(path: str | Path) -> RtiImage | SampledImage:
    """Read a relightable image.

    Parameters
    ----------
    path
        A .ptm (LRGB or RGB, also as JPEGs), a .rti of hemispherical harmonics, a folder with an info.json and
        its JPEGs, or that info.json.

    Returns
    -------
    RtiImage or SampledImage
        With rows from the top, whatever the file has; `relight_rti` shows it under a lamp. A SampledImage is
        one of RelightLab's 'rbf' and 'bilinear', whose weights are tables.

    Raises
    ------
    ImageError
        Naming the file and what was expected there.
    """
    suffix = Path(path).suffix.lower()
    if suffix == ".ptm":
        return read_ptm(path)
    if suffix == ".rti":
        return read_hsh(path)
    if not is_rti(path):
        raise ImageError(f"expected a .ptm, a .rti, or a folder with {INFO}", name=path)
    return read_planes(path)


def write_rti(image: RtiImage, path: str | Path, *, capture: Capture | None = None) -> None:
    """Write a relightable image: a .ptm, a .rti, or for any other name a folder with an info.json.

    capture: of which it was made; the folder then tells its lamps and its scale.
    Raises ImageError when such a file cannot hold it, OutputError when it cannot be written.
    """
    suffix = Path(path).suffix.lower()
    if suffix == ".ptm":
        write_ptm(image, path)
    elif suffix == ".rti":
        write_hsh(image, path)
    elif capture is None:
        write_planes(image, path)
    else:
        write_planes(image, path, lights=capture.lights, spacing=capture.spacing)
