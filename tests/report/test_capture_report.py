import io

import numpy as np
import pytest
from pypdf import PdfReader

from rumu.capture.exif import PhotographFacts
from rumu.capture.lights import direction
from rumu.report.capture_report import CaptureReport, capture_pdf
from rumu.surface.folder import Processing
from rumu.surface.photograph_table import PhotographRow
from rumu.values import Bilingual, Surface


def report(
    count: int = 6, *, title: str = "蘭亭 1", facts: PhotographFacts | None = None, rows: int = 60
) -> CaptureReport:
    down, across = np.indices((rows, 90))
    height = (np.sin(across / 9) * np.cos(down / 7)).astype(np.float32)
    mask = np.ones(height.shape, bool)
    mask[:8] = False
    surface = Surface(
        height=height,
        normals_from=np.broadcast_to(np.array([0, 0, 1], np.float32), (*height.shape, 3)),
        albedo_from=np.full(height.shape, 0.7, np.float32),
        mask=mask,
        confidence=mask.astype(np.float32),
        spacing=0.1,
        unit="mm",
        source="photometric",
        quality={"residual": 0.0123, "lamps": float(count)},
    )
    names = [f"photograph-{k}.jpg" for k in range(count)]
    bad = (Bilingual("不清晰", "it is blurred"),)
    return CaptureReport(
        title=title,
        surface=surface,
        lights=np.array([direction(tilt=360 * k / count, slant=45) for k in range(count)]),
        lamps_from=Bilingual("反光球", "mirror spheres in the photographs"),
        rows=[
            PhotographRow(name, 1.0, 0.02, 0.1, 0, 1, 0.3, faults=bad if k == 1 else ())
            for k, name in enumerate(names)
        ],
        facts=[facts or PhotographFacts()] * count,
        residual=np.where(mask, 0.03, np.nan),
        notes=[Bilingual("房間不暗。", "the room was not dark")],
        processing=Processing(
            {"capture": "/photographs/one", "solver": "robust", "card": True, "leave_out": []},
            {f"/photographs/{name}": f"{k:064x}" for k, name in enumerate(names)},
            {"height": "ab" * 32},
            "0.3.0",
            "2026-05-04T20:15:00+00:00",
            "王小明",
        ),
    )


def text_of(data: bytes) -> str:
    return "\n".join(page.extract_text() for page in PdfReader(io.BytesIO(data)).pages)


FACTS = PhotographFacts(
    camera="Canon EOS R5", lens="RF100mm", exposure=1 / 60, f_number=8.0, iso=100, author="A. Photographer",
    taken="2026:05:04 20:15:00",
)  # fmt: skip


@pytest.mark.parametrize("language", ["zh", "en"])
def test_a_report_tells_lamps_maps_figures_photographs_and_record(language):
    data = capture_pdf(report(facts=FACTS), language=language)
    text = text_of(data)
    words = {
        "zh": ("拍攝報告", "方向取自", "反光球", "剖面", "簽名", "房間不暗", "製作紀錄"),
        "en": (
            "Capture report",
            "directions from mirror spheres",
            "Sections",
            "Signature",
            "not dark",
            "made",
        ),
    }[language]
    assert [word for word in words if word not in text] == []
    assert "蘭亭" in text and "王小明" in text and "Canon EOS R5" in text and "1/60 f/8 ISO 100" in text
    assert "45.0°" in text and "60.0°" in text and "0.0123" in text
    assert f"{3:064x}" in text and "ab" * 32 in text  # digests, whole
    assert "card" in text and "leave_out" not in text
    images = [one for page in PdfReader(io.BytesIO(data)).pages for one in page.images]
    assert len(images) == 5


@pytest.mark.parametrize("rows", range(48, 84, 4))
def test_no_heading_stands_at_the_end_of_a_page_without_what_it_heads(rows):
    """The higher the maps, the lower all else begins."""
    for page in PdfReader(io.BytesIO(capture_pdf(report(11, rows=rows), language="en"))).pages:
        text = page.extract_text()
        for heading, below in (("Maps", "Albedo"), ("Sections", "Across the middle")):
            assert heading not in text.split("\n") or below in text, heading


def test_chinese_is_text_of_an_embedded_font():
    reader = PdfReader(io.BytesIO(capture_pdf(report())))
    fonts = [one.get_object() for one in reader.pages[0]["/Resources"]["/Font"].values()]
    assert any("/FontFile2" in one["/FontDescriptor"] for one in fonts if "rumu" in str(one["/BaseFont"]))


def test_many_lamps_go_on_over_pages_and_the_signature_stays_whole():
    reader = PdfReader(io.BytesIO(capture_pdf(report(100), language="en")))
    last = reader.pages[-1].extract_text()
    assert len(reader.pages) > 3
    assert all(word in last for word in ("I have checked", "Name, institution", "Date", "Signature"))
    text = "\n".join(page.extract_text() for page in reader.pages)
    assert "photograph-99.jpg" in text and "tell neither camera nor exposure" in text
    assert text.count("residual %") >= 2  # the head of a table is set again where it goes on
    assert all(f"/ {len(reader.pages)}" in page.extract_text() for page in reader.pages)
