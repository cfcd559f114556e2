"""Responses with files: conditional requests (RFC 9110), compression, and names to save them by."""

from __future__ import annotations

from fastapi import Request, Response
from starlette.datastructures import Headers

from rumu.web.files import FileContent

IMMUTABLE = "public, max-age=31536000, immutable"
REVALIDATE = "no-cache"


def requested_etags(headers: Headers) -> list[str]:
    """The ETags that a client has already, from If-None-Match."""
    header = headers.get("if-none-match", "")
    return [etag.strip().removeprefix("W/").strip('"') for etag in header.split(",")]


def file_response(
    request: Request,
    content: FileContent,
    *,
    filename: str | None = None,
    private: bool = False,
    immutable: bool = False,
) -> Response:
    """A file, compressed if the client accepts gzip; 304 if the client has it.

    filename: what the browser is to save it as. private: shared caches must not store it. immutable: its
    address names its version, so that clients need never ask again.
    """
    headers = {
        "ETag": f'"{content.etag}"',
        "Cache-Control": IMMUTABLE if immutable else f"private, {REVALIDATE}" if private else REVALIDATE,
        "Vary": "Accept-Encoding",
    }
    if content.etag in requested_etags(request.headers):
        return Response(status_code=304, headers=headers)
    if filename is not None:
        headers["Content-Disposition"] = f'attachment; filename="{filename}"'
    body = content.data
    if content.gzipped is not None and "gzip" in request.headers.get("accept-encoding", ""):
        body, headers["Content-Encoding"] = content.gzipped, "gzip"
    return Response(body, media_type=content.media_type, headers=headers)


def download_response(
    data: bytes | str, *, media_type: str, filename: str, disposition: str = "attachment"
) -> Response:
    """A file made for this request alone, which no cache may store. disposition: or 'inline'."""
    headers = {
        "Content-Disposition": f'{disposition}; filename="{filename}"',
        "Cache-Control": "no-store",
    }
    return Response(data, media_type=media_type, headers=headers)


def csv_response(text: str, filename: str) -> Response:
    """A table to download, with the byte order mark that makes spreadsheets read UTF-8."""
    return download_response(f"\ufeff{text}", media_type="text/csv; charset=utf-8", filename=filename)
