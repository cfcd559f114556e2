"""The location of a gallery, which can be pickled so that a worker process opens it too."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from rumu.homes import database_place, files_place


@dataclass(frozen=True, slots=True)
class Storage:
    """Addresses of a gallery's database and files.

    database: an SQLite file or a URL. files: a folder or an fsspec URL. calibration: a file that
    `rumu calibrate` wrote, None for the calibration that ships with rumu.
    """

    database: str
    files: str
    calibration: Path | None = None

    @staticmethod
    def chosen(
        *,
        database: str | Path | None = None,
        files: str | Path | None = None,
        calibration: Path | None = None,
    ) -> Storage:
        """Return the storage as given, else as RUMU_DATABASE and RUMU_FILES say, else in RUMU_HOME."""
        return Storage(
            database=database_place(database),
            files=files_place(files),
            calibration=calibration,
        )
