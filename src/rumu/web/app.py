"""The FastAPI application: routes, error handlers and middleware."""

from __future__ import annotations

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

from anyio.to_thread import current_default_thread_limiter, run_sync
from fastapi import FastAPI
from starlette.middleware.gzip import GZipMiddleware

from rumu import __version__
from rumu.database.server_lock import ServerLock
from rumu.web import openapi, pages
from rumu.web.addresses import AddressMiddleware
from rumu.web.caching import ETagMiddleware
from rumu.web.dependencies import ERROR_RESPONSES
from rumu.web.error_handlers import EXCEPTION_HANDLERS
from rumu.web.methods import MethodsMiddleware
from rumu.web.routes import (
    attempts,
    characters,
    classes,
    comparisons,
    home,
    iiif,
    imports,
    jobs,
    marks,
    people,
    photographs,
    practice,
    printing,
    sheets,
    tiles,
    tours,
    works,
)
from rumu.web.security import SecurityMiddleware
from rumu.web.service import Service
from rumu.web.settings import ServiceSettings

THREADS = 12  # for requests; more would only contend, and marks wait in threads of their own

_ABOUT = (
    "Chinese calligraphy as surfaces, and an honest mark for a learner's copy. Reading the gallery is open. "
    "Requests that change something need the header X-CSRF-Token with the token of GET /api/session, and "
    "most of them a login. Texts are in traditional Chinese (zh) and English (en). Errors are "
    "{error: {code, zh, en}}."
)
_ROUTERS = (
    *(people.router, people.people_router, works.router, imports.router, works.annotations_router),
    *(tours.router, marks.router, attempts.router, practice.router, printing.router, classes.router),
    sheets.router,
    photographs.router,
    tiles.router,
    *(comparisons.router, jobs.router, iiif.router, home.router, characters.router, works.slash_router),
)


def create_app(settings: ServiceSettings, *, lock: ServerLock | None = None) -> FastAPI:
    """The application of one service. It opens the gallery at once; workers start with the server.

    lock: by which this is the only server of the database; None where the caller sees to that.
    """
    service = Service(settings, lock=lock)

    @asynccontextmanager
    async def lifespan(app: FastAPI) -> AsyncIterator[None]:
        current_default_thread_limiter().total_tokens = THREADS
        await run_sync(service.start)
        yield
        service.stop()

    app = FastAPI(
        title="rumu 入木",
        version=__version__,
        description=_ABOUT,
        openapi_url="/api/openapi.json",
        docs_url=None,
        redoc_url=None,
        lifespan=lifespan,
        responses=ERROR_RESPONSES,
        exception_handlers=EXCEPTION_HANDLERS,
    )
    app.state.service = service
    for router in _ROUTERS:
        app.include_router(router)
    openapi.register(app)
    pages.register(app, settings.static)
    app.add_middleware(GZipMiddleware, minimum_size=800, compresslevel=5)
    app.add_middleware(ETagMiddleware)  # outside of gzip, so that it keeps compressed responses
    app.add_middleware(MethodsMiddleware)
    app.add_middleware(SecurityMiddleware, service=service)
    app.add_middleware(AddressMiddleware, root_path=settings.root_path, https=settings.https)
    return app
