"""The built pages of the front end, read once; a plain page where they are not built."""

from __future__ import annotations

import gzip
import hashlib
import mimetypes
from pathlib import Path

from fastapi import FastAPI, Request, Response
from fastapi.responses import HTMLResponse

from rumu.studio.errors import Missing
from rumu.web.files import FileContent
from rumu.web.responses import file_response

_TYPES = {
    ".js": "text/javascript; charset=utf-8",
    ".css": "text/css; charset=utf-8",
    ".html": "text/html; charset=utf-8",
    ".svg": "image/svg+xml",
    ".woff2": "font/woff2",
    ".webmanifest": "application/manifest+json",
}
_COMPRESSED = (".woff2", ".png", ".webp", ".jpg", ".gz", ".br")

NOT_BUILT = """<!doctype html>
<html lang="zh-Hant"><head><meta charset="utf-8"><title>rumu 入木</title></head><body>
<h1>rumu 入木</h1>
<p>網頁尚未建置。請在原始碼資料夾執行 <code>scripts/install</code>，再重新啟動。</p>
<p>The pages are not built. Run <code>scripts/install</code> in the source folder and start again.</p>
<p><a href="api/docs">API</a></p>
</body></html>
"""


def read_pages(folder: Path) -> dict[str, FileContent]:
    """Every file by its URL path; empty if the pages are not built."""
    if not (folder / "index.html").is_file():
        return {}
    files = (path for path in sorted(folder.rglob("*")) if path.is_file())
    return {f"/{path.relative_to(folder).as_posix()}": _read_file(path) for path in files}


def register(app: FastAPI, folder: Path) -> None:
    """Add the routes of the pages. Files are looked up in memory, so no URL can lead out of the folder."""
    pages = read_pages(folder)

    @app.get("/", include_in_schema=False)
    def get_index(request: Request) -> Response:
        index = pages.get("/index.html")
        if index is None:
            return HTMLResponse(NOT_BUILT, headers={"Cache-Control": "no-store"})
        return file_response(request, index)

    @app.get("/{path:path}", include_in_schema=False)
    def get_page(request: Request, path: str) -> Response:
        content = pages.get(f"/{path}")
        if content is None or path.startswith("api/"):
            raise Missing
        # the build names its assets by their content
        return file_response(request, content, immutable=path.startswith("assets/"))


def _read_file(path: Path) -> FileContent:
    data = path.read_bytes()
    kind = _TYPES.get(path.suffix) or mimetypes.guess_type(path.name)[0] or "application/octet-stream"
    gzipped = None if path.suffix in _COMPRESSED or len(data) < 1000 else gzip.compress(data, 9)
    return FileContent(data, gzipped, kind, hashlib.sha256(data).hexdigest()[:20])
