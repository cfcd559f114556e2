"""Slow and silent clients, with real sockets: they stop nobody, and are ended in time."""

from __future__ import annotations

import asyncio
import contextlib
import json
import socket
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import httpx
import pytest
import uvicorn

from rumu.studio.people import create_person
from rumu.studio.storage import Storage
from rumu.web.app import create_app
from rumu.web.connections import GracefulServer
from rumu.web.server import listen, server_config
from rumu.web.settings import ConnectionLimits, ServiceSettings

HEAD = b"GET /api/session HTTP/1.1\r\nHost: x\r\n"
LIMITS = ConnectionLimits(head_seconds=2, body_seconds=2, body_rate=100, write_seconds=2, head_bytes=40_000)
LATE = 30  # seconds after which a limit of two seconds has been noticed, on a busy machine too


@pytest.fixture
def serve(tmp_path) -> Iterator[Callable[..., int]]:
    """Serve in a thread with these limits; the port."""
    running = []

    def start(limits: ConnectionLimits = LIMITS, proxies: str = "10.0.0.1") -> int:
        folder = tmp_path / str(len(running))
        storage = Storage(database=str(folder / "rumu.sqlite"), files=str(folder / "files"))
        app = create_app(ServiceSettings(storage, processes=0, prepare=False, connections=limits))
        with app.state.service.gallery.database.writing() as session:
            create_person(session, name="林", password="a long password", role="teacher")
        listener = listen("127.0.0.1", 0)
        listener.setsockopt(
            socket.SOL_SOCKET, socket.SO_SNDBUF, 16384
        )  # a client that does not read shows soon
        server = uvicorn.Server(server_config(app, limits, proxies=proxies))
        thread = threading.Thread(target=server.run, kwargs={"sockets": [listener]}, daemon=True)
        thread.start()
        running.append((server, thread, listener))
        until = time.monotonic() + 30
        while not server.started:
            assert thread.is_alive() and time.monotonic() < until
            time.sleep(0.01)
        return listener.getsockname()[1]

    yield start
    for server, thread, listener in running:
        server.should_exit = True
        thread.join(30)
        listener.close()


def connect(port: int, data: bytes = b"") -> socket.socket:
    client = socket.create_connection(("127.0.0.1", port), timeout=30)
    client.sendall(data)
    return client


def read_all(client: socket.socket) -> bytes:
    """What comes until the server closes the connection."""
    parts = []
    with contextlib.suppress(ConnectionError):
        while part := client.recv(65536):
            parts.append(part)
    client.close()
    return b"".join(parts)


def refusal(answer: bytes) -> tuple[int, str]:
    head, _, body = answer.partition(b"\r\n\r\n")
    error = json.loads(body)["error"]
    assert error["zh"] and error["en"] and b"server:" not in head.lower()
    return int(head.split()[1]), error["code"]


def test_two_hundred_slow_heads_stop_nobody_and_are_ended(serve):
    port = serve()
    slow = [connect(port, HEAD if k % 2 else b"") for k in range(200)]
    start = time.monotonic()
    with httpx.Client(base_url=f"http://127.0.0.1:{port}", trust_env=False) as client:
        for _ in range(5):
            assert client.get("/api/works?limit=1").status_code == 200
    answers = [read_all(one) for one in slow]
    assert time.monotonic() - start < 3 * LATE  # one after the other here, and all at once there
    assert {refusal(answer) for answer in answers} == {(408, "timeout")}


def test_a_head_that_trickles_in_is_ended(serve):
    client = connect(serve())
    start = time.monotonic()
    with contextlib.suppress(OSError):
        for byte in HEAD * 10:
            client.sendall(bytes([byte]))
            time.sleep(0.1)
            if time.monotonic() - start > LATE:
                break
    assert time.monotonic() - start < LATE
    client.close()


def test_the_second_request_of_a_connection_has_its_own_time(serve):
    client = connect(serve())
    for _ in range(3):
        client.sendall(HEAD + b"\r\n")
        assert b"200 OK" in client.recv(65536)
        time.sleep(1.5)
    client.sendall(HEAD)
    assert refusal(read_all(client)) == (408, "timeout")


@pytest.mark.parametrize("bytes_each", [0, 1])
def test_a_slow_body_is_ended(serve, bytes_each):
    port = serve()
    with httpx.Client(base_url=f"http://127.0.0.1:{port}", trust_env=False) as browser:
        token = browser.get("/api/session").json()["csrf"]
        cookie = "; ".join(f"{name}={value}" for name, value in browser.cookies.items())
    head = (
        f"POST /api/login HTTP/1.1\r\nHost: x\r\nCookie: {cookie}\r\nX-CSRF-Token: {token}\r\n"
        "Content-Type: application/json\r\nContent-Length: 1000\r\n\r\n{"
    )
    client = connect(port, head.encode())
    start = time.monotonic()
    with contextlib.suppress(OSError):
        while time.monotonic() - start < LATE:
            client.sendall(b" " * bytes_each)
            client.settimeout(0.2)
            with contextlib.suppress(TimeoutError):
                answer = client.recv(65536)
                break
    assert time.monotonic() - start < LATE
    assert refusal(answer) == (408, "timeout")


def test_a_body_that_comes_steadily_is_read(serve):
    port = serve()

    def parts():
        for _ in range(8):
            yield b" " * 300
            time.sleep(0.5)
        yield b'{"name": "\xe6\x9e\x97", "password": "a long password"}'

    with httpx.Client(base_url=f"http://127.0.0.1:{port}", trust_env=False, timeout=30) as browser:
        token = browser.get("/api/session").json()["csrf"]
        headers = {"X-CSRF-Token": token, "Content-Type": "application/json"}
        assert browser.post("/api/login", content=parts(), headers=headers).status_code == 200


def test_a_client_that_takes_nothing_of_its_response_is_ended(serve):
    port = serve()
    client = socket.socket()
    client.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
    client.connect(("127.0.0.1", port))
    wanted = b"GET /api/works/regular-shui/files/stl HTTP/1.1\r\nHost: x\r\n\r\n"
    client.sendall(wanted * 6)  # more than the system's buffers hold
    client.settimeout(60)
    time.sleep(1)
    start = time.monotonic()
    while time.monotonic() - start < 20 and _is_connected(client):
        time.sleep(0.2)
    assert not _is_connected(client)
    client.close()


def _is_connected(client: socket.socket) -> bool:
    """Whether the system still counts the connection as established."""
    port, established = client.getsockname()[1], "01"
    lines = [line.split() for line in Path("/proc/net/tcp").read_text().splitlines()[1:]]
    return any(line[1].endswith(f":{port:04X}") and line[3] == established for line in lines)


def test_headers_that_are_too_large_are_refused(serve):
    port = serve()
    client = connect(port, HEAD + b"Cookie: " + b"x" * 50_000 + b"\r\n\r\n")
    assert refusal(read_all(client)) == (431, "head_too_large")
    endless = connect(port, HEAD + b"Cookie: ")
    with contextlib.suppress(OSError):
        for _ in range(100):
            endless.sendall(b"x" * 1000)
            time.sleep(0.001)
    assert b"431" in read_all(endless)
    fine = connect(port, HEAD + b"Connection: close\r\nCookie: " + b"x" * 30_000 + b"\r\n\r\n")
    assert b"200 OK" in read_all(fine)


def test_what_is_no_http_is_refused_in_both_languages(serve):
    assert refusal(read_all(connect(serve(), b"\x16\x03\x01\x02\x00\x01\x00\r\n\r\n"))) == (
        400,
        "bad_request",
    )


def test_an_address_has_so_many_connections_and_the_idlest_makes_room(serve):
    port = serve(ConnectionLimits(head_seconds=20, per_client=5))
    waiting = [connect(port, HEAD) for _ in range(8)]
    time.sleep(0.5)
    assert [read_all(one) for one in waiting[:3]] == [b""] * 3
    newest = connect(port, HEAD + b"Connection: close\r\n\r\n")
    assert b"200 OK" in read_all(newest)
    for one in waiting[4:]:
        one.sendall(b"Connection: close\r\n\r\n")
        assert b"200 OK" in read_all(one)


def test_where_all_are_busy_there_is_no_room_but_for_a_proxy(serve):
    limits = ConnectionLimits(per_client=3)
    for proxies, status in (("10.0.0.1", b"503"), ("127.0.0.0/8", b"401")):
        port = serve(limits, proxies)
        with httpx.Client(base_url=f"http://127.0.0.1:{port}", trust_env=False) as browser:
            token = browser.get("/api/session").json()["csrf"]
            cookie = "; ".join(f"{name}={value}" for name, value in browser.cookies.items())
        head = f"Host: x\r\nConnection: close\r\nCookie: {cookie}\r\nX-CSRF-Token: {token}\r\n"
        body = b'{"name": "x", "password": "a wrong password"}'
        head += f"Content-Type: application/json\r\nContent-Length: {len(body)}\r\n\r\n"
        request = b"POST /api/login HTTP/1.1\r\n" + head.encode() + body
        via = [
            request.replace(b"Host: x", f"Host: x\r\nX-Forwarded-For: 192.0.2.{k}".encode()) for k in range(4)
        ]
        busy = [connect(port, one[:-1]) for one in via[:3]]
        time.sleep(0.5)
        over = connect(port, via[3])
        assert read_all(over).split()[1] == status
        for one in busy:
            one.sendall(request[-1:])
            assert read_all(one).split()[1] == b"401"


@pytest.mark.parametrize(("proxies", "believed"), [("127.0.0.0/8", True), ("10.0.0.1", False)])
def test_what_a_trusted_proxy_says_is_believed(serve, proxies, believed):
    port = serve(proxies=proxies)
    said = {"X-Forwarded-Proto": "https", "Host": "shufa.example"}
    with httpx.Client(base_url=f"http://127.0.0.1:{port}", trust_env=False, headers=said) as client:
        headers = client.get("/api/session").headers
        facts = client.get("/iiif/works/regular-shui/manifest.json").json()
    assert "server" not in headers
    assert ("strict-transport-security" in headers) is believed
    assert headers["set-cookie"].startswith("__Host-") is believed
    assert facts["id"].startswith("https://shufa.example/" if believed else "http://shufa.example/")


@pytest.mark.parametrize(
    "path", ["/../../../../etc/passwd", "/assets/../../../../etc/passwd", "/api/works/../../x"]
)
def test_dots_in_a_path_lead_nowhere(serve, path):
    request = f"GET {path} HTTP/1.1\r\nHost: x\r\nConnection: close\r\n\r\n"
    answer = read_all(connect(serve(), request.encode()))
    assert answer.split()[1] == b"404" and b"root:" not in answer


def test_requests_that_wait_for_work_are_answered_before_the_server_ends(caplog):
    begun, ended = threading.Event(), threading.Event()

    async def waiting(scope, receive, send):
        if scope["type"] != "http":
            return
        begun.set()
        while not ended.is_set():
            await asyncio.sleep(0.01)
        await send({"type": "http.response.start", "status": 503, "headers": []})
        await send({"type": "http.response.body", "body": b"ended"})

    listener = listen("127.0.0.1", 0)
    server = GracefulServer(server_config(waiting, LIMITS), end_work=ended.set)
    thread = threading.Thread(target=server.run, kwargs={"sockets": [listener]}, daemon=True)
    thread.start()
    answers = []
    url = f"http://127.0.0.1:{listener.getsockname()[1]}/"
    asking = threading.Thread(target=lambda: answers.append(httpx.get(url, timeout=LATE, trust_env=False)))
    asking.start()
    assert begun.wait(LATE)
    server.should_exit = True
    asking.join(LATE)
    thread.join(LATE)
    listener.close()
    assert [(answer.status_code, answer.content) for answer in answers] == [(503, b"ended")]
    assert not thread.is_alive() and "Cancel" not in caplog.text
