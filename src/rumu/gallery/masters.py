"""Masters for a search: a folder of pictures, or a labels.csv with what they show."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from rumu.csv_tables import Table, read_table
from rumu.errors import GalleryError

LABELS = "labels.csv"
NAMES = {
    "file": ("filename", "檔案", "檔名", "圖檔", "文件", "文件名", "圖片", "图片"),
    "character": ("字", "單字", "单字", "字符", "漢字", "汉字"),
    "script": ("書體", "书体", "字體", "字体"),
    "calligrapher_zh": ("書家", "书家", "書法家", "书法家", "作者"),
    "calligrapher": (),
    "hand": (),
    "hand_zh": (),
    "hand_en": (),
    "work": ("作品", "帖名", "作品名", "碑帖"),
    "title": ("題名", "题名", "標題", "标题", "名稱", "名称"),
    "title_zh": (),
    "title_en": (),
    "dynasty": ("朝代",),
    "period": ("時代", "时代", "年代"),
    "medium": ("媒材", "媒介"),
    "material": ("材質", "材质", "質地", "质地"),
    "polarity_guess": (),
    "source": ("來源", "来源", "出處", "出处"),
    "licence": ("license", "授權", "授权", "許可", "许可"),
    "attribution": ("credit", "署名", "標示", "标示"),
    "text": ("釋文", "释文"),
}
"""Column of a labels.csv -> its other names."""
PICTURES = frozenset({".png", ".jpg", ".jpeg", ".webp", ".tif", ".tiff", ".bmp"})

MasterPaths = str | Path | Sequence[str | Path]


@dataclass(frozen=True, slots=True)
class Master:
    """A picture of a character. character, hand, work: None where the labels do not give them."""

    path: Path
    character: str | None = None
    hand: str | None = None
    work: str | None = None


def read_masters(paths: MasterPaths) -> tuple[Master, ...]:
    """The masters of one path or of several, in the order of the labels or file names.

    paths: a labels.csv with the columns file and, where known, character, calligrapher_zh (or calligrapher)
        and work; or a folder, with a labels.csv or with pictures only.
    Raises GalleryError when there is no such file or folder, no picture in it, or no column `file`.
    """
    several = (paths,) if isinstance(paths, str | Path) else tuple(paths)
    masters = [master for path in several for master in _read_path(Path(path))]
    if not masters:
        raise GalleryError(f"expected pictures of masters in {', '.join(map(str, several)) or 'nothing'}")
    return tuple(dict.fromkeys(masters))


def _read_path(path: Path) -> Iterator[Master]:
    if path.is_dir():
        if (path / LABELS).is_file():
            yield from _read_labels(path / LABELS)
            return
        pictures = (Path(folder) / name for folder, _, names in os.walk(path) for name in names)
        yield from (Master(one) for one in sorted(pictures) if one.suffix.lower() in PICTURES)
    elif path.suffix.lower() == ".csv" and path.is_file():
        yield from _read_labels(path)
    else:
        raise GalleryError(f"{path}: expected a folder of pictures or a {LABELS}, found neither")


def read_label_table(path: Path) -> Table:
    """A labels.csv. Raises GalleryError if it is no table with a column `file`."""
    return read_table(path, NAMES, required=("file",), error_type=GalleryError)


def _read_labels(path: Path) -> Iterator[Master]:
    for row in read_label_table(path).rows():
        if file := row.get("file"):
            hand = row.get("calligrapher_zh", "hand_zh", "calligrapher", "hand")
            words = (row.get("character"), hand, row.get("work", "title_zh", "title"))
            yield Master(path.parent / file, *(word or None for word in words))
