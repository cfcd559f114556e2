"""Every error as {"error": {"code", "zh", "en"}} with its status."""

from __future__ import annotations

import logging
from typing import Any

from fastapi import FastAPI, Request
from fastapi.exceptions import RequestValidationError
from fastapi.responses import JSONResponse
from starlette.exceptions import HTTPException

from rumu.errors import RumuError
from rumu.studio.errors import Busy, Clash, Missing, NotAllowed, StudioError, Unusable
from rumu.web.rate_limits import TooManyRequests

_log = logging.getLogger(__name__)


class LoginNeededError(StudioError):
    """Nobody is logged in."""

    def __init__(self) -> None:
        super().__init__("login", zh="請先登入。", en="Log in first.")


class WrongLoginError(StudioError):
    """Name and password do not belong together."""

    def __init__(self) -> None:
        super().__init__("wrong_login", zh="名字或密碼不對。", en="The name or the password is wrong.")


_STATUS: tuple[tuple[type[StudioError], int], ...] = (
    (LoginNeededError, 401),
    (WrongLoginError, 401),
    (Missing, 404),
    (NotAllowed, 403),
    (Clash, 409),
    (TooManyRequests, 429),
    (Busy, 503),
    (Unusable, 422),
)
_HTTP_ERRORS = {
    400: ("bad_request", "請求的格式不對。", "The request is malformed."),
    401: ("login", "請先登入。", "Log in first."),
    403: ("not_allowed", "您沒有這個權限。", "You may not do this."),
    404: ("not_found", "沒有這個頁面或項目。", "There is no such page or thing."),
    405: ("method", "這裡不接受這種請求。", "This cannot be asked here."),
    413: ("too_large", "送來的資料太大。", "More was sent than is taken here."),
}


def register(app: FastAPI) -> None:
    """Add the handlers of all errors to the application."""
    app.add_exception_handler(StudioError, _studio_error)
    app.add_exception_handler(RumuError, _rumu_error)
    app.add_exception_handler(RequestValidationError, _validation_error)
    app.add_exception_handler(HTTPException, _http_error)
    app.add_exception_handler(Exception, _unexpected_error)


def error_response(
    status: int, code: str, zh: str, en: str, headers: dict[str, str] | None = None
) -> JSONResponse:
    """The response of an error. code: for programs. zh, en: one sentence each."""
    return JSONResponse({"error": {"code": code, "zh": zh, "en": en}}, status, headers=headers)


def studio_response(error: StudioError, headers: dict[str, str] | None = None) -> JSONResponse:
    """The response of an error that has a code and both sentences."""
    status = next((status for kind, status in _STATUS if isinstance(error, kind)), 400)
    if isinstance(error, TooManyRequests):
        headers = {"Retry-After": str(error.seconds)} | (headers or {})
    if isinstance(error, Busy):
        headers = {"Retry-After": "3"} | (headers or {})
    return error_response(status, error.code, error.zh, error.en, headers)


async def _studio_error(request: Request, error: Any) -> JSONResponse:
    return studio_response(error)


async def _rumu_error(request: Request, error: Any) -> JSONResponse:
    """The packages below write errors in English alone; pages choose their own words by the code."""
    code = getattr(error, "reason", None) or "unusable"
    return error_response(422, code, f"無法使用：{error}", " ".join(str(error).split()))


async def _validation_error(request: Request, error: Any) -> JSONResponse:
    first = error.errors()[0] if error.errors() else {"loc": (), "msg": "invalid"}
    field = ".".join(str(part) for part in first["loc"])
    return error_response(422, "invalid", f"填寫的內容不對：{field}", f"{field}: {first['msg']}")


async def _http_error(request: Request, error: Any) -> JSONResponse:
    code, zh, en = _HTTP_ERRORS.get(error.status_code, ("error", "無法完成。", "It cannot be done."))
    return error_response(error.status_code, code, zh, en, dict(error.headers or {}) or None)


async def _unexpected_error(request: Request, error: Exception) -> JSONResponse:
    _log.exception("%s %s", request.method, request.url.path, exc_info=error)
    return error_response(
        500, "unexpected", "伺服器出了意外。", "Something unexpected happened on the server."
    )
