"""Every error as {"error": {"code", "zh", "en"}} with its status."""

from __future__ import annotations

import logging
from collections.abc import Callable, Coroutine
from typing import Any

from fastapi import Request, Response
from fastapi.exceptions import RequestValidationError
from fastapi.responses import JSONResponse
from starlette.exceptions import HTTPException

from rumu.errors import DatabaseBusy, RumuError
from rumu.outputs import is_full
from rumu.studio.errors import (
    Busy,
    Clash,
    Missing,
    NotAllowed,
    StudioError,
    Unusable,
    without_folders,
)
from rumu.web.rate_limits import TooManyRequests

_log = logging.getLogger(__name__)

_TEXTS = {
    "bad_request": ("請求的格式不對。", "The request is malformed."),
    "csrf": ("頁面已過期，請重新載入。", "The page is out of date; load it again."),
    "origin": (
        "這個請求來自別的網站，沒有執行。若是經由反向代理，代理要傳送 Host 標頭。",
        "The request comes from another site and was not carried out. A reverse proxy must pass on Host.",
    ),
    "login": ("請先登入。", "Log in first."),
    "wrong_login": ("名字或密碼不對。", "The name or the password is wrong."),
    "not_allowed": ("您沒有這個權限。", "You may not do this."),
    "not_found": ("沒有這個頁面或項目。", "There is no such page or thing."),
    "method": ("這裡不接受這種請求。", "This method is not allowed here."),
    "too_large": ("送來的資料太大。", "The request is too large."),
    "error": ("無法完成。", "It cannot be done."),
}
"""What an HTTPException says, by its code: its detail if that is one of these, else its status's."""

_CODES = {
    400: "bad_request",
    401: "login",
    403: "not_allowed",
    404: "not_found",
    405: "method",
    413: "too_large",
}
_STATUS: tuple[tuple[type[StudioError], int], ...] = (
    (Missing, 404),
    (NotAllowed, 403),
    (Clash, 409),
    (TooManyRequests, 429),
    (Busy, 503),
    (Unusable, 422),
)
_BUSY_SECONDS = 3  # after which a client is to try again


def error_response(error: Exception) -> JSONResponse:
    """The response to an error. Of those without a sentence in Chinese, pages choose words by the code."""
    headers: dict[str, str] = {}
    match error:
        case _ if is_full(error):
            status, code = 507, "disk_full"
            needed = getattr(error, "needed", "")
            zh = f"伺服器的磁碟或配額已滿，什麼都沒有存下。請管理的人清出{needed or '一些'}空間，然後再試。"
            en = (
                "The disk or quota of the server is full; nothing was stored. "
                f"Whoever runs it must free {needed or 'some space'}; then try again."
            )
        case DatabaseBusy():
            status, code, zh = 503, "database_busy", str(error.zh)
            en = f"{error.en[0].upper()}{error.en[1:]}."
            headers["Retry-After"] = str(_BUSY_SECONDS)
        case StudioError():
            status = next((status for kind, status in _STATUS if isinstance(error, kind)), 400)
            code, zh, en = error.code, error.zh, error.en
            if isinstance(error, TooManyRequests | Busy):
                headers["Retry-After"] = str(getattr(error, "seconds", _BUSY_SECONDS))
        case RumuError():
            status, code = 422, getattr(error, "reason", None) or "unusable"
            en = without_folders(" ".join(error.en.split()))
            zh = without_folders(error.zh or f"無法使用：{en}")
        case RequestValidationError():
            first = error.errors()[0] if error.errors() else {"loc": (), "msg": "invalid"}
            field = ".".join(str(part) for part in first["loc"])
            status, code, zh, en = 422, "invalid", f"填寫的內容不對：{field}", f"{field}: {first['msg']}"
        case HTTPException():
            status, headers = error.status_code, dict(error.headers or {})
            code = error.detail if error.detail in _TEXTS else _CODES.get(status, "error")
            zh, en = _TEXTS[code]
        case _:
            status, code, zh = 500, "unexpected", "伺服器出了意外。"
            en = "Something unexpected happened on the server."
    return JSONResponse({"error": {"code": code, "zh": zh, "en": en}}, status, headers=headers or None)


async def _handle(request: Request, error: Exception) -> JSONResponse:
    response = error_response(error)
    if response.status_code in (500, 507):
        _log.exception("%s %s", request.method, request.url.path, exc_info=error)
    return response


EXCEPTION_HANDLERS: dict[int | type[Exception], Callable[..., Coroutine[Any, Any, Response]]] = {
    kind: _handle for kind in (StudioError, RumuError, RequestValidationError, HTTPException, Exception)
}
"""For FastAPI: every error is answered by `error_response`."""
