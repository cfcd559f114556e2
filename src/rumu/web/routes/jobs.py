"""Long work: how far it is, as it goes."""

from __future__ import annotations

import asyncio
import json
import time
from collections.abc import AsyncIterator
from typing import Any

from anyio.to_thread import run_sync
from fastapi import APIRouter, Request
from fastapi.responses import StreamingResponse

from rumu.studio import jobs
from rumu.studio.people import Identity
from rumu.web.cards import job_facts
from rumu.web.dependencies import CurrentUser, PathId, ServiceDep
from rumu.web.service import Service
from rumu.web.studio_schemas import JobRead

router = APIRouter(tags=["jobs"])
_LOOK = 0.25  # seconds between two looks at the job
_SIGN_OF_LIFE = 15.0  # seconds of silence after which a comment is sent, so that nothing in between hangs up


@router.get("/api/jobs/{job_id}", response_model=JobRead)
def job(service: ServiceDep, user: CurrentUser, job_id: PathId) -> dict[str, Any]:
    """How far it is."""
    with service.gallery.database.reading() as session:
        return job_facts(jobs.found(session, job_id, who=user))


@router.post("/api/jobs/{job_id}/cancel", response_model=JobRead)
def cancel(service: ServiceDep, user: CurrentUser, job_id: PathId) -> dict[str, Any]:
    """Stop it; what it has done stays."""
    with service.gallery.database.writing() as session:
        return job_facts(jobs.cancel(session, job_id, who=user))


@router.get("/api/jobs/{job_id}/events", response_class=StreamingResponse)
def events(request: Request, service: ServiceDep, user: CurrentUser, job_id: PathId) -> StreamingResponse:
    """Server-sent events: the job at each change, until it has ended."""
    with service.gallery.database.reading() as session:
        jobs.found(session, job_id, who=user)
    headers = {"Cache-Control": "no-store", "X-Accel-Buffering": "no"}
    stream = _told(request, service, user, job_id)
    return StreamingResponse(stream, media_type="text/event-stream", headers=headers)


async def _told(request: Request, service: Service, user: Identity, job_id: str) -> AsyncIterator[str]:
    last, silent = None, time.monotonic()
    while not await request.is_disconnected() and not service.stopping:
        facts = await run_sync(_facts, service, user, job_id)
        if facts != last:
            last, silent = facts, time.monotonic()
            yield f"data: {json.dumps(facts, ensure_ascii=False)}\n\n"
        if facts is None or facts["state"] in jobs.FINISHED:
            return
        if time.monotonic() - silent > _SIGN_OF_LIFE:
            silent = time.monotonic()
            yield ": still at it\n\n"
        await asyncio.sleep(_LOOK)


def _facts(service: Service, user: Identity, job_id: str) -> dict[str, Any]:
    with service.gallery.database.reading() as session:
        return job_facts(jobs.found(session, job_id, who=user))
