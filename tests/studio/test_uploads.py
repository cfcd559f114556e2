"""Uploads go into the collection that was named, of whatever kind they are."""

from __future__ import annotations

import zipfile

import pytest

from rumu.errors import CaptureError
from rumu.gallery.archive import export_gallery
from rumu.gallery.catalog import collections, work, works
from rumu.gallery.starter import starter_works
from rumu.studio.errors import Unusable
from rumu.studio.uploads import add_work, import_zip


@pytest.fixture
def zipped(tmp_path):
    def pack(files: dict[str, bytes]):
        path = tmp_path / "sent.zip"
        with zipfile.ZipFile(path, "w") as archive:
            for name, data in files.items():
                archive.writestr(name, data)
        return path

    return pack


@pytest.fixture
def labelled(zipped, copy_of):
    return zipped(
        {"labels.csv": b"file,character,script,work\na.png,\xe5\xa4\xa9,regular,x\n", "a.png": copy_of()}
    )


@pytest.fixture
def exported(zipped, gallery, tmp_path):
    """The starter gallery with one more work that is gone again."""
    data = starter_works(script="seal")[0].path.read_bytes()
    gone = add_work(gallery, data, {"title_zh": "舊"}, spacing=None)
    export_gallery(gallery, tmp_path / "out")
    from rumu.gallery.catalog import delete_work

    delete_work(gallery, gone)
    files = (path for path in (tmp_path / "out").rglob("*") if path.is_file())
    return zipped({str(path.relative_to(tmp_path / "out")): path.read_bytes() for path in files}), gone


def quiet(*_):
    return None


def test_the_names_of_a_table_and_of_the_files_match_however_they_are_written(gallery, zipped, copy_of):
    table = "file,character\ne\u0301\\水:1.png,水\n"
    packed = zipped({"Labels.CSV": table.encode(), "é/水:1.PNG": copy_of()})
    done = import_zip(gallery, packed, {}, progress=quiet)
    assert (done["added"], done["left_out"]) == (1, [])


def test_names_in_gbk_are_read_and_what_was_assumed_is_said(gallery, cases):
    done = import_zip(gallery, cases / "zips" / "gbk-names.zip", {}, progress=quiet)
    assert (done["added"], done["left_out"]) == (2, [])
    assert "GBK" in done["assumed"]["en"] and "GBK" in done["assumed"]["zh"]
    assert import_zip(gallery, cases / "zips" / "nfd.zip", {}, progress=quiet)["added"] == 1


@pytest.mark.parametrize(
    ("names", "code"),
    [
        (["a.png", "b.png"], "no_labels"),
        (["inner.zip"], "zip_nested"),
        (["notes.docx"], "no_works"),
        ([".DS_Store"], "no_works"),
        (["one/lights.lp", "two/lights.lp"], "several"),
        (["one/lights.lp", "two/LAMPS.dome"], "several"),
        (["one/labels.csv", "two/labels.csv"], "several"),
    ],
)
def test_what_is_missing_in_a_zip_is_said(gallery, zipped, names, code):
    with pytest.raises(Unusable) as refused:
        import_zip(gallery, zipped(dict.fromkeys(names, b"1")), {}, progress=quiet)
    assert refused.value.code == code and refused.value.zh != refused.value.en


def test_what_is_imported_may_lie_some_folders_down(gallery, zipped, copy_of):
    files = {
        "readme.txt": b"1",
        "a/b/labels.csv": "file,character\n永.png,永\n".encode(),
        "a/b/永.png": copy_of(),
    }
    done = import_zip(gallery, zipped(files), {}, progress=quiet)
    assert (done["collections"], done["added"]) == (["b"], 1)


def members(gallery, collection):
    return [one.id for one in works(gallery, collection=collection).items]


def test_labels_go_into_the_collection_that_was_named(gallery, labelled):
    done = import_zip(gallery, labelled, {"collection": "課堂"}, progress=quiet)
    (collection,) = done["collections"]
    assert {row.id: row.title_zh for row, _ in collections(gallery)}[collection] == "課堂"
    assert (done["added"], len(members(gallery, collection))) == (1, 1)


def test_without_a_named_collection_labels_go_into_one_named_after_the_zip(gallery, labelled):
    done = import_zip(gallery, labelled, {"collection": ""}, name="Third Class", progress=quiet)
    assert done["collections"] == ["third-class"]


def test_works_go_into_an_existing_collection_of_this_title(gallery, labelled, copy_of):
    starter = next(row for row, _ in collections(gallery) if row.id == "starter")
    before = len(members(gallery, "starter"))
    done = import_zip(gallery, labelled, {"collection": starter.title_zh}, progress=quiet)
    assert done["collections"] == ["starter"] and len(members(gallery, "starter")) == before + 1
    other = add_work(gallery, copy_of(degree="bad"), {"collection": starter.title_en}, spacing=None)
    assert work(gallery, other).collection_id == "starter"


def test_an_export_goes_into_the_collection_that_was_named_and_moves_nothing(gallery, exported):
    packed, gone = exported
    before = members(gallery, "starter")
    done = import_zip(gallery, packed, {"collection": "restored"}, progress=quiet)
    assert (done["collections"], done["added"]) == (["restored"], 1)
    assert members(gallery, "restored") == [gone] and members(gallery, "starter") == before
    assert [one.id for one in works(gallery, query="restored").items] == [gone]


def test_without_a_named_collection_an_export_goes_into_the_one_it_came_from(gallery, exported):
    packed, gone = exported
    done = import_zip(gallery, packed, {}, progress=quiet)
    assert (work(gallery, gone).collection_id, done["added"]) == ("own", 1)


def test_a_capture_that_cannot_be_used_says_why_in_both_languages(gallery, zipped, cases):
    for case, en, zh in (
        ("ps-yflip", "change the sign of every y", "請把每個 y 變號"),
        ("ps-white", "overexposed", "曝光過度"),
    ):
        sent = zipped({path.name: path.read_bytes() for path in (cases / case).iterdir()})
        with pytest.raises(CaptureError, match=en) as refused:
            import_zip(gallery, sent, {}, progress=quiet)
        assert zh in refused.value.zh and "/tmp" not in f"{refused.value}{refused.value.zh}"


def test_what_was_read_otherwise_is_told_with_the_work(gallery, zipped, cases):
    sent = zipped({path.name: path.read_bytes() for path in (cases / "ps-exif180-some").iterdir()})
    done = import_zip(gallery, sent, {}, progress=quiet)
    (note,) = done["notes"]
    assert done["added"] == 1 and "p1.jpg, p4.jpg" in note["en"] and "不轉動照片" in note["zh"]


def test_lamps_of_an_upload_may_be_taken_as_given(gallery, zipped, cases):
    files = {path.name: path.read_bytes() for path in (cases / "ps-yflip").iterdir()}
    sent = zipped(files | {"capture.json": b'{"lamps_as_given": true}'})
    assert import_zip(gallery, sent, {}, progress=quiet)["added"] == 1


def test_how_the_table_was_read_is_told_in_both_languages_and_names_in_other_characters_are_found(
    gallery, zipped, cases
):
    picture = (cases / "tables" / "a.png").read_bytes()
    sent = zipped({"labels.csv": "file;character\n張三.png;水\n".encode("gb18030"), "张三.png": picture})
    done = import_zip(gallery, sent, {}, progress=quiet)
    assert done["added"] == 1
    assert done["read_as"] == {"zh": "GB 18030，以分號分隔", "en": "GB 18030, cells separated by semicolons"}
