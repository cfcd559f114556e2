"""A local server that behaves as those of museums do, well and badly, and counts what it is asked."""

from __future__ import annotations

import io
import json
import re
import threading
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any

import numpy as np
from PIL import Image

WIDTH, HEIGHT, TILE = 300, 200, 128

BEHAVIOURS = (
    "level 2",
    "level 0 with tiles",
    "smaller than asked for",
    "level 0 with sizes",
    "no service",
    "429",
    "version 1",
    "version 2",
    "500 once",
    "redirect",
)
"""What the server does with the picture of each canvas, in turn."""


def picture_of(number: int, *, size: tuple[int, int] = (WIDTH, HEIGHT)) -> Image.Image:
    """A picture that no other canvas has: two slow waves."""
    y, x = np.mgrid[: size[1], : size[0]]
    waves = [np.sin((x * (1 + number % 7) + y * k) / 40 + number) for k in (1, 2, 3)]
    return Image.fromarray((128 + 100 * np.dstack(waves)).astype(np.uint8))


def jpeg(picture: Image.Image) -> bytes:
    """The picture as a JPEG."""
    packed = io.BytesIO()
    picture.save(packed, "JPEG", quality=95)
    return packed.getvalue()


class Museum:
    """canvases: how many the manifest has. asked: how often each path was asked for."""

    def __init__(self, canvases: int) -> None:
        self.canvases, self.asked, self.base = canvases, Counter[str](), ""
        self.changed = threading.Condition()

    def behaviour(self, number: int) -> str:
        """What is done with the picture of a canvas, from 0."""
        return BEHAVIOURS[number % len(BEHAVIOURS)]

    def note(self, path: str) -> int:
        """Count a request; how many there were for this path."""
        with self.changed:
            self.asked[path] += 1
            self.changed.notify_all()
            return self.asked[path]

    def wait_for(self, requests: int) -> None:
        """Wait until so many requests have come, 400 seconds at most."""
        with self.changed:
            assert self.changed.wait_for(lambda: self.asked.total() >= requests, timeout=400)

    # --- documents ---------------------------------------------------------------------------------

    def canvas_id(self, number: int) -> str:
        """The id of a canvas, which is no address that answers."""
        return f"{self.base}/canvas/{number}"

    def manifest(self) -> dict[str, Any]:
        """A manifest of version 3 in several languages."""
        return {
            "@context": "http://iiif.io/api/presentation/3/context.json",
            "id": f"{self.base}/manifest.json",
            "type": "Manifest",
            "label": {"zh-Hant": ["蘭亭帖"], "en": ["Lanting <i>album</i>"], "fr": ["Album"]},
            "metadata": [{"label": {"en": ["Date"]}, "value": {"en": ["Tang"], "zh": ["唐"]}}],
            "requiredStatement": {"label": {"en": ["Credit"]}, "value": {"en": ["Gift of &amp; A. Donor"]}},
            "rights": "http://creativecommons.org/publicdomain/zero/1.0/",
            "provider": [{"id": f"{self.base}/about", "type": "Agent", "label": {"en": ["A Museum"]}}],
            "homepage": [{"id": f"{self.base}/objects/1", "type": "Text", "label": {"en": ["Object"]}}],
            "items": [self._canvas(number) for number in range(self.canvases)],
        }

    def _canvas(self, number: int) -> dict[str, Any]:
        service = f"{self.base}/image/{number}"
        body: dict[str, Any] = {"id": f"{service}.jpg", "type": "Image", "format": "image/jpeg"}
        if self.behaviour(number) != "no service":
            body["service"] = [{"id": service, "type": "ImageService3", "profile": "level0"}]
        annotation = {"id": "a", "type": "Annotation", "motivation": "painting", "body": body}
        return {
            "id": self.canvas_id(number),
            "type": "Canvas",
            "label": {"none": [f"leaf {number + 1}"]},
            "width": WIDTH,
            "height": HEIGHT,
            "items": [{"id": "p", "type": "AnnotationPage", "items": [annotation]}],
        }

    def manifest_2(self) -> dict[str, Any]:
        """The same in version 2, as many museums still have it: a list of languages, attribution, license."""
        canvases = [
            {
                "@id": self.canvas_id(number),
                "@type": "sc:Canvas",
                "label": f"{number + 1}r",
                "images": [
                    {
                        "@type": "oa:Annotation",
                        "motivation": "sc:painting",
                        "resource": {
                            "@id": f"{self.base}/image/{number}.jpg",
                            "@type": "dctypes:Image",
                            "service": {"@id": f"{self.base}/image/{number}", "profile": "level2"},
                        },
                    }
                ],
            }
            for number in range(self.canvases)
        ]
        return {
            "@context": "http://iiif.io/api/presentation/2/context.json",
            "@id": f"{self.base}/v2.json",
            "@type": "sc:Manifest",
            "label": [{"@value": "Calligraphie", "@language": "fr"}, {"@value": "書帖", "@language": "zh"}],
            "attribution": "A Library",
            "license": "https://creativecommons.org/licenses/by/4.0/",
            "metadata": [{"label": "Creator", "value": ["Wang", "Yan"]}],
            "sequences": [{"@type": "sc:Sequence", "canvases": canvases}],
        }

    def info(self, number: int) -> dict[str, Any]:
        """The info.json of a picture."""
        base = f"{self.base}/image/{number}"
        kind = self.behaviour(number)
        three = {"@context": "http://iiif.io/api/image/3/context.json", "id": base, "type": "ImageService3"}
        size = {"width": WIDTH, "height": HEIGHT}
        if kind == "level 0 with tiles":
            tiles = [{"width": TILE, "scaleFactors": [1, 2]}]
            return {**three, **size, "profile": "level0", "tiles": tiles}
        if kind == "smaller than asked for":
            return {**three, **size, "profile": "level1"}
        if kind == "level 0 with sizes":
            sizes = [
                {"width": WIDTH // 2, "height": HEIGHT // 2},
                {"width": WIDTH // 4, "height": HEIGHT // 4},
            ]
            return {**three, **size, "profile": "level0", "sizes": sizes}
        if kind == "version 1":
            return {
                "@context": "http://library.stanford.edu/iiif/image-api/1.1/context.json",
                "@id": base,
                **size,
            }
        if kind == "version 2":
            profile = ["http://iiif.io/api/image/2/level1.json", {"maxWidth": 200}]
            tiles = [{"width": TILE, "scaleFactors": [1, 2]}]
            two = {"@context": "http://iiif.io/api/image/2/context.json", "@id": base, "tiles": tiles}
            return {**two, **size, "profile": profile}
        return {**three, **size, "profile": "level2"}

    def part(self, number: int, path: str) -> bytes | None:  # noqa: PLR0911
        """A picture as a request names it; None where this server has none."""
        kind, whole = self.behaviour(number), picture_of(number)
        if path == ".jpg":
            return jpeg(whole)
        match = re.fullmatch(r"/(full|[\d,]+)/(full|max|[\d]+,\d*)/0/(native|default)\.jpg", path)
        if match is None or (match[3] == "native") != (kind == "version 1"):
            return None
        region, size, _ = match.groups()
        if region == "full":
            if kind == "level 0 with tiles":
                return None
            if kind in ("smaller than asked for", "version 2"):
                return jpeg(whole.resize((WIDTH // 2, HEIGHT // 2)))
            if kind == "level 0 with sizes" and size != f"{WIDTH // 2},{HEIGHT // 2}":
                return None
            return jpeg(whole if "," not in size else whole.resize((WIDTH // 2, HEIGHT // 2)))
        return self._region(whole, region, size, kind)

    def _region(self, whole: Image.Image, region: str, size: str, kind: str) -> bytes | None:
        """A part of a picture; None for one that this server has not."""
        x, y, w, h = map(int, region.split(","))
        wide, _, high = size.partition(",")
        if (high == "") != kind.startswith("version") or x + w > WIDTH or y + h > HEIGHT:
            return None  # only what is canonical lies there
        scaled = int(wide), int(high or round(h * int(wide) / w))
        if kind == "level 0 with sizes":
            return None
        if kind == "level 0 with tiles":
            factor = -(-w // scaled[0])
            step = TILE * factor
            if factor > 2 or x % step or y % step or w > step or h > step:
                return None
        return jpeg(whole.crop((x, y, x + w, y + h)).resize(scaled))


@contextmanager
def open_museum(canvases: int) -> Iterator[Museum]:
    """A museum at an address of this machine."""
    museum = Museum(canvases)

    class Handler(BaseHTTPRequestHandler):
        def do_GET(self) -> None:
            _answer(self, museum)

        def log_message(self, *_: Any) -> None:
            pass

    server = ThreadingHTTPServer(("127.0.0.1", 0), Handler)
    museum.base = f"http://127.0.0.1:{server.server_port}"
    thread = threading.Thread(target=server.serve_forever, daemon=True)
    thread.start()
    try:
        yield museum
    finally:
        server.shutdown()
        server.server_close()


def _answer(request: BaseHTTPRequestHandler, museum: Museum) -> None:
    path, times = request.path, museum.note(request.path)
    documents = {"/manifest.json": museum.manifest, "/v2.json": museum.manifest_2}
    if path in documents:
        _send(request, 200, json.dumps(documents[path]()).encode())
        return
    if path == "/collection.json":
        members = [
            {"id": f"{museum.base}/{name}", "type": "Manifest"} for name in ("manifest.json", "gone.json")
        ]
        members.append({"id": f"{museum.base}/collection.json", "type": "Collection"})  # a circle
        facts = {"type": "Collection", "id": f"{museum.base}/collection.json", "items": members}
        _send(request, 200, json.dumps(facts | {"label": {"en": ["All"]}}).encode())
        return
    if path == "/elsewhere":
        _send(request, 302, b"", Location="http://10.0.0.1/manifest.json")
        return
    match = re.fullmatch(r"(?:/moved)?/image/(\d+)(/info\.json|/.*|\.jpg)", path)
    if match is None:
        _send(request, 404, b"not here")
        return
    number, rest = int(match[1]), match[2]
    kind = museum.behaviour(number)
    if kind == "429" and rest == "/info.json" and times == 1:
        _send(request, 429, b"slowly", **{"Retry-After": "7"})
    elif kind == "500 once" and times == 1:
        _send(request, 500, b"oh")
    elif kind == "redirect" and not path.startswith("/moved"):
        _send(request, 301, b"", Location=f"/moved{path}")
    elif rest == "/info.json":
        _send(request, 200, json.dumps(museum.info(number)).encode())
    else:
        data = museum.part(number, rest)
        _send(request, *((404, b"no such part") if data is None else (200, data)))


def _send(request: BaseHTTPRequestHandler, status: int, data: bytes, **headers: str) -> None:
    try:
        request.send_response(status)
        for name, value in {"Content-Length": str(len(data)), **headers}.items():
            request.send_header(name, value)
        request.end_headers()
        request.wfile.write(data)
    except OSError:
        pass  # the client was killed
