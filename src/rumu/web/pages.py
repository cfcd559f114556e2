"""The pages that the front end's build left in the package, read once; and a plain one where there are
none."""

from __future__ import annotations

import gzip
import hashlib
import mimetypes
from pathlib import Path

from fastapi import FastAPI, Request, Response

from rumu.studio.errors import Missing
from rumu.web.caching import IMMUTABLE, file_response
from rumu.web.files import FileContent

_TYPES = {
    ".js": "text/javascript; charset=utf-8",
    ".css": "text/css; charset=utf-8",
    ".html": "text/html; charset=utf-8",
    ".svg": "image/svg+xml",
    ".woff2": "font/woff2",
    ".webmanifest": "application/manifest+json",
}
_PACKED_ALREADY = (".woff2", ".png", ".webp", ".jpg", ".gz", ".br")

NOT_BUILT = """<!doctype html>
<html lang="zh-Hant"><head><meta charset="utf-8"><title>rumu 入木</title></head><body>
<h1>rumu 入木</h1>
<p>網頁尚未建置。請在原始碼資料夾執行 <code>scripts/install</code>，再重新啟動。</p>
<p>The pages are not built. Run <code>scripts/install</code> in the source folder and start again.</p>
<p><a href="/api/docs">API</a></p>
</body></html>
"""


def read_pages(folder: Path) -> dict[str, FileContent]:
    """Every file by its address; empty where nothing was built."""
    if not (folder / "index.html").is_file():
        return {}
    files = (path for path in sorted(folder.rglob("*")) if path.is_file())
    return {f"/{path.relative_to(folder).as_posix()}": _page(path) for path in files}


def register(app: FastAPI, folder: Path) -> None:
    """Serve them: what an address names is looked up, never opened."""
    pages = read_pages(folder)

    @app.get("/", include_in_schema=False)
    def index(request: Request) -> Response:
        page = pages.get("/index.html")
        if page is None:
            return Response(
                NOT_BUILT, media_type="text/html; charset=utf-8", headers={"Cache-Control": "no-store"}
            )
        return file_response(request, page)

    @app.get("/{address:path}", include_in_schema=False)
    def page(request: Request, address: str) -> Response:
        found = pages.get(f"/{address}")
        if found is None or address.startswith("api/"):
            raise Missing
        answer = file_response(request, found)
        if address.startswith("assets/"):  # their names change with their content
            answer.headers["Cache-Control"] = IMMUTABLE
        return answer


def _page(path: Path) -> FileContent:
    data = path.read_bytes()
    kind = _TYPES.get(path.suffix) or mimetypes.guess_type(path.name)[0] or "application/octet-stream"
    packed = None if path.suffix in _PACKED_ALREADY or len(data) < 1000 else gzip.compress(data, 9)
    return FileContent(data, packed, kind, hashlib.sha256(data).hexdigest()[:20])
