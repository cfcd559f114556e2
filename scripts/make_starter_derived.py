#!/usr/bin/env python3
"""Make what the first pages of a new gallery show: src/rumu/gallery/starter_derived.zip.

    .venv/bin/python scripts/make_starter_derived.py

The thumbnails of the starter works and both maps of the work on the home page, as the service would make
them when they are first asked for, under the names that they have in the store. They come with the package,
since the first visitor of a new gallery would have to wait for them; they are made again wherever they are
missing. Run this when the starter works, or the version of derived files, have changed:
tests/gallery/test_seed.py tells.
"""

from __future__ import annotations

import argparse
import os
import sys
import tempfile
import zipfile
from pathlib import Path

from rumu.gallery.catalog import open_gallery
from rumu.gallery.seed import DERIVED
from rumu.outputs import whole_file
from rumu.studio.job_handlers import make_first_files

ROOT = Path(__file__).resolve().parents[1]
TARGET = ROOT / "src" / "rumu" / "gallery" / DERIVED
_TIME = (1980, 1, 1, 0, 0, 0)  # so that equal files give equal zips


def main(arguments: list[str] | None = None) -> int:
    """Write the zip and say how large it is."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--output", type=Path, default=TARGET)
    options = parser.parse_args(arguments)
    with tempfile.TemporaryDirectory() as home:
        os.environ["RUMU_HOME"] = home
        gallery = open_gallery()
        gallery.store.delete("derived")  # what an earlier zip has brought
        make_first_files(gallery, lambda done, total: None)
        keys = sorted(gallery.store.keys("derived"))
        with whole_file(options.output) as file, zipfile.ZipFile(file, "w") as packed:
            for key in keys:
                packed.writestr(zipfile.ZipInfo(key, _TIME), gallery.store.read(key))
    print(f"{len(keys)} files, {options.output.stat().st_size / 1000:.0f} kB in {options.output}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
