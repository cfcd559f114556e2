"""Photographs of practice sheets through the service: marks of all cells, kept in the right practice."""

from __future__ import annotations

import csv
import io
import time
import zipfile

import numpy as np
import pytest
from tests.written_sheets import encoded, photograph, written_sheet

from rumu.studio.sheet_cells import MASTERS
from rumu.web.settings import RateLimitSettings


@pytest.fixture(scope="module", autouse=True)
def home(tmp_path_factory):
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("RUMU_HOME", str(tmp_path_factory.mktemp("home")))
        yield


@pytest.fixture(scope="module")
def sheet(home) -> bytes:
    """人 and 水 of the starter works in regular script, for 李小華, upside down."""
    return encoded(photograph(written_sheet(sources=("regular",), pupil="李小華"), turn=180))


def sent(browser, picture: bytes):
    return browser("POST", "/api/sheets", files={"picture": ("sheet.jpg", picture)})


def test_all_cells_with_writing_are_marked_and_kept_by_whoever_sends_them(world, sheet):
    pupil = world.browser("吳")
    answer = sent(pupil, sheet)
    assert answer.status_code == 201, answer.text
    upload = answer.json()
    (photo,) = upload["photos"]
    assert [(c["row"], c["column"], c["character"]) for c in photo["cells"]] == [(0, 1, "人"), (1, 0, "水")]
    assert photo["empty"] == 4 and photo["refused"] is None and photo["count"] == 1
    assert photo["pupil"] == "李小華" and photo["person"]["name"] == "吳" and photo["is_of_another"]
    for cell in photo["cells"]:
        assert cell["score"] > 70 and cell["is_fault"] and cell["told"]["zh"] and cell["told"]["en"]
        attempt = pupil("GET", f"/api/attempts/{cell['attempt']}").json()
        assert attempt["person"]["name"] == "吳" and attempt["work"]["script"] == "regular"
        assert attempt["work"]["id"] in ("regular-ren", "regular-shui")
        assert attempt["mark"]["score"] == cell["score"]
        assert "lean" in [remark["kind"] for remark in attempt["mark"]["remarks"]]
        assert pupil("GET", cell["picture"].removeprefix("http://testserver")).status_code == 200
    assert pupil("GET", f"/api/sheets/{upload['id']}").json() == upload
    listed = pupil("GET", "/api/sheets").json()
    assert listed["items"][0]["characters"] == "人水" and listed["items"][0]["cells"] == 2
    deleted = photo["cells"][0]["attempt"]
    assert pupil("DELETE", f"/api/attempts/{deleted}").status_code == 204
    again = pupil("GET", f"/api/sheets/{upload['id']}").json()["photos"][0]["cells"]
    assert [cell["attempt"] is None for cell in again] == [True, False]


def test_strokes_of_copybooks_become_works_once(world):
    pupil = world.browser("吳")
    picture = encoded(written_sheet("永", cells=((0, 0), (0, 1))))
    ids = set()
    for _ in range(2):
        for cell in sent(pupil, picture).json()["photos"][0]["cells"]:
            ids.add(pupil("GET", f"/api/attempts/{cell['attempt']}").json()["work"]["id"])
    assert len(ids) == 1
    work = pupil("GET", f"/api/works/{ids.pop()}").json()
    assert (work["character"], work["script"], work["collection"]) == ("永", "regular", MASTERS)


@pytest.mark.parametrize(
    ("spoil", "code"),
    [
        (lambda p: np.full_like(p, 200), "no_sheet"),
        (lambda p: np.hstack([p, p]), "two_sheets"),
        (lambda p: p[: round(0.55 * len(p))], "cut_off"),
        (lambda p: (p * 0.1).astype(np.uint8), "dark"),
    ],
)
def test_the_true_reason_of_a_refusal_is_told(world, code_of, spoil, code):
    answer = sent(world.browser("吳"), encoded(spoil(written_sheet()), "PNG"))
    assert (answer.status_code, code_of(answer)) == (422, code)


def test_what_is_no_picture_is_refused(world, code_of):
    answer = sent(world.browser("吳"), b"no picture at all, only a text of some length")
    assert (answer.status_code, code_of(answer)) == (422, "no_picture")


def test_a_sheet_without_writing_is_read(world):
    (photo,) = sent(world.browser("吳"), encoded(written_sheet(cells=()))).json()["photos"]
    assert photo["cells"] == [] and photo["empty"] == 6 and photo["refused"] is None


def test_nobody_else_sees_what_somebody_sent(world, sheet):
    upload = sent(world.browser("吳"), sheet).json()["id"]
    statuses = [
        world.browser(name)("GET", f"/api/sheets/{upload}").status_code for name in (None, "周", "陳")
    ]
    assert statuses == [401, 404, 404]
    assert world.browser("館主")("GET", f"/api/sheets/{upload}").status_code == 200
    assert sent(world.browser(), sheet).status_code == 401


def test_a_person_may_send_so_many_and_no_more(new_world, code_of):
    world = new_world(rate_limits=RateLimitSettings(photos="1/hour"))
    pupil = world.browser("吳")
    answers = [sent(pupil, b"no picture") for _ in range(2)]
    assert [answer.status_code for answer in answers] == [422, 429] and code_of(answers[1]) == "too_often"


# --- of a class --------------------------------------------------------------------------------------


def finished(browser, job_id: str) -> dict:
    """A job once it has ended."""
    for _ in range(1200):
        job = browser("GET", f"/api/jobs/{job_id}").json()
        if job["state"] in ("done", "failed", "cancelled"):
            return job
        time.sleep(0.1)
    raise AssertionError(job)


@pytest.fixture(scope="module")
def of_class(world):
    """Photographs of 吳's sheet and of a stranger's, and of a desk: what the teacher's upload tells."""
    teacher = world.browser("林")
    task = teacher("POST", f"/api/classes/{world.ids['林班']}/tasks", json={"work": "regular-shui"}).json()
    mine = encoded(written_sheet(sources=("regular",), pupil="吳"))
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w") as archive:
        archive.writestr("生人.jpg", encoded(written_sheet(sources=("regular",), pupil="生人")))
        archive.writestr("desk.png", encoded(np.full((800, 600, 3), 120, np.uint8), "PNG"))
    files = [("photos", ("一.jpg", mine)), ("photos", ("others.zip", packed.getvalue()))]
    answer = teacher("POST", f"/api/classes/{world.ids['林班']}/sheets", files=files)
    assert answer.status_code == 202, answer.text
    job = finished(teacher, answer.json()["job"]["id"])
    assert job["state"] == "done", job
    assert (job["result"]["photos"], job["result"]["unread"]) == (3, 1)
    return teacher("GET", f"/api/sheets/{job['result']['upload']}").json(), task["id"]


def test_sheets_of_a_class_are_kept_for_the_pupils_whom_they_name(world, of_class):
    upload, task = of_class
    assert upload["school_class"]["name"] == "林班"
    by_name = {photo["photo"]: photo for photo in upload["photos"]}
    mine, stranger, desk = by_name["一.jpg"], by_name["生人.jpg"], by_name["desk.png"]
    assert mine["person"]["name"] == "吳" and not mine["is_of_another"] and len(mine["cells"]) == 2
    assert stranger["person"] is None and [cell["attempt"] for cell in stranger["cells"]] == [None, None]
    assert desk["refused"]["code"] == "no_sheet" and desk["cells"] == [] and desk["refused"]["zh"]
    pupil = world.browser("吳")
    for cell in mine["cells"]:
        attempt = pupil("GET", f"/api/attempts/{cell['attempt']}").json()
        assert attempt["person"]["name"] == "吳" and attempt["mark"]["score"] == cell["score"]
        assert attempt["task"] == (task if cell["character"] == "水" else None)


def test_a_teacher_gets_tables_pdfs_and_pictures(world, of_class):
    upload, _ = of_class
    teacher = world.browser("林")
    table = list(csv.DictReader(io.StringIO(teacher("GET", upload["table"]).content.decode("utf-8-sig"))))
    assert [row["character"] for row in table if row["photo"] == "一.jpg"] == ["人", "水"]
    assert teacher("GET", upload["teacher"]).content.startswith(b"%PDF-")
    with zipfile.ZipFile(io.BytesIO(teacher("GET", upload["archive"]).content)) as archive:
        names = set(archive.namelist())
    assert {"marks.csv", "marks.json", "teacher.pdf", "pupils/吳.pdf", "pupils/生人.pdf"} <= names
    stranger = next(photo for photo in upload["photos"] if photo["photo"] == "生人.jpg")
    picture = teacher("GET", stranger["cells"][0]["picture"])
    assert picture.status_code == 200 and picture.content.startswith(b"\x89PNG")
    for name, status in ((None, 401), ("周", 404), ("吳", 404), ("陳", 404), ("館主", 200)):
        assert world.browser(name)("GET", upload["archive"]).status_code == status
        assert world.browser(name)("GET", stranger["cells"][0]["picture"]).status_code == status
    listed = teacher("GET", f"/api/sheets?school_class={world.ids['林班']}").json()
    assert [one["id"] for one in listed["items"]] == [upload["id"]] and listed["items"][0]["unread"] == 1


def test_marking_the_sheets_again_keeps_nothing_twice(world, of_class):
    from sqlalchemy import func, select

    from rumu.database.tables import Attempt
    from rumu.studio import job_handlers

    def count():
        with world.service.gallery.database.reading() as session:
            return session.scalar(select(func.count()).select_from(Attempt))

    before = count()
    gallery = world.service.gallery
    payload = {
        "class_id": world.ids["林班"],
        "person": world.ids["林"],
        "sheet_upload": "again",
        "names": ["一.jpg"],
    }
    gallery.store.write("uploads/again/0000", encoded(written_sheet(sources=("regular",), pupil="吳")))
    for _ in range(2):
        result = job_handlers.mark_sheets(
            gallery, payload | {"upload": "uploads/again"}, lambda *told: None, world.service.settings.storage
        )
        assert result["upload"] == "again" and count() == before + 2


def test_an_upload_is_deleted_with_its_files_and_the_copies_stay(world, of_class):
    upload, _ = of_class
    owner, kept = world.browser("館主"), upload["photos"][0]["cells"] or upload["photos"][1]["cells"]
    assert world.browser("陳")("DELETE", f"/api/sheets/{upload['id']}").status_code == 404
    assert owner("DELETE", f"/api/sheets/{upload['id']}").status_code == 204
    assert owner("GET", f"/api/sheets/{upload['id']}").status_code == 404
    assert not world.service.gallery.store.exists(f"sheets/{upload['id']}/marks.zip")
    ids = [cell["attempt"] for photo in upload["photos"] for cell in photo["cells"] if cell["attempt"]]
    assert kept and all(owner("GET", f"/api/attempts/{one}").status_code == 200 for one in ids)
