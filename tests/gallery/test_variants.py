"""Traditional and simplified characters are one to a search."""

from __future__ import annotations

import pytest

from rumu.gallery.variants import folded, forms


@pytest.mark.parametrize(
    ("one", "other"), [("書", "书"), ("蘭亭序", "兰亭序"), ("ＴＡＮＧ", "tang"), ("顏真卿", "颜真卿")]
)
def test_both_forms_are_one(one, other):
    assert folded(one) == folded(other)


def test_different_characters_stay_different():
    assert len({folded(character) for character in "天人水書日月永"}) == 7


def test_the_forms_of_a_character():
    assert forms("书") == ("书", "書")
    assert forms("書") == ("書", "书")
    assert forms("水") == ("水",)
    assert set(forms("后")) == {"后", "後"}
