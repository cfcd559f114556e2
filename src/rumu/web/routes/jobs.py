"""Routes of jobs, and the events that tell their progress."""

from __future__ import annotations

import asyncio
import json
import time
from collections.abc import AsyncIterator
from typing import Any

from anyio.to_thread import run_sync
from fastapi import APIRouter, Request
from fastapi.responses import StreamingResponse

from rumu.database.tables import Job
from rumu.studio import job_queue
from rumu.studio.people import Identity
from rumu.web.dependencies import CurrentUser, PathId, ServiceDep
from rumu.web.service import Service
from rumu.web.studio_schemas import JobRead

router = APIRouter(tags=["jobs"])
_FIRST_POLL, _POLL = 0.03, 0.25  # seconds between two queries of the job, at first and when it takes longer
_HEARTBEAT = 15.0  # seconds of silence after which a comment is sent, so that no proxy closes the stream


@router.get("/api/jobs/{job_id}", response_model=JobRead)
def get_job(service: ServiceDep, user: CurrentUser, job_id: PathId) -> Job:
    """The job and its progress."""
    with service.gallery.database.reading() as session:
        return job_queue.find_job(session, job_id, user=user)


@router.post("/api/jobs/{job_id}/cancel", response_model=JobRead)
def cancel_job(service: ServiceDep, user: CurrentUser, job_id: PathId) -> Job:
    """Stop a job; what it has done stays."""
    with service.gallery.database.writing() as session:
        return job_queue.cancel(session, job_id, user=user)


@router.get("/api/jobs/{job_id}/events", response_class=StreamingResponse)
def stream_job(request: Request, service: ServiceDep, user: CurrentUser, job_id: PathId) -> StreamingResponse:
    """Server-sent events: the job at each change, until it has ended."""
    get_job(service, user, job_id)
    headers = {"Cache-Control": "no-store", "X-Accel-Buffering": "no"}
    stream = _events(request, service, user, job_id)
    return StreamingResponse(stream, media_type="text/event-stream", headers=headers)


async def _events(request: Request, service: Service, user: Identity, job_id: str) -> AsyncIterator[str]:
    last: dict[str, Any] = {}
    sent, pause = time.monotonic(), _FIRST_POLL
    while not await request.is_disconnected() and not service.stopping:
        row = await run_sync(get_job, service, user, job_id)
        job = JobRead.model_validate(row).model_dump(mode="json")
        if job != last:
            last, sent = job, time.monotonic()
            yield f"data: {json.dumps(job, ensure_ascii=False)}\n\n"
        if row.state in job_queue.FINISHED:
            return
        if time.monotonic() - sent > _HEARTBEAT:
            sent = time.monotonic()
            yield ": still running\n\n"
        await asyncio.sleep(pause)
        pause = min(1.5 * pause, _POLL)
