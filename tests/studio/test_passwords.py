"""Passwords: those that are easily guessed are refused with advice, and hashes are Argon2id."""

from __future__ import annotations

import inspect
import re
import time

import pytest

from rumu.studio import passwords
from rumu.studio.errors import Unusable
from rumu.studio.passwords import ADVICE, MAX_PASSWORD, check_new_password, hash_password, verify_password


@pytest.mark.parametrize(
    "password",
    ["12345678", "password", "qwertyuiop", "aaaaaaaaaa", "abcabcabc", "19900101", "iloveyou", "Passw0rd!"],
)
@pytest.mark.parametrize("role", ["pupil", "teacher", "owner"])
def test_what_is_guessed_first_is_refused_in_both_languages(password, role):
    with pytest.raises(Unusable) as refused:
        check_new_password(password, role=role)
    error = refused.value
    assert error.code == "weak_password" and "too easy to guess" in error.en
    assert "太容易猜" in error.zh and error.zh.count("。") >= 2  # and what to do


@pytest.mark.parametrize("password", ["tiger bamboo", "a long password", "四個詞連起來就很好記"])
@pytest.mark.parametrize("role", ["pupil", "teacher", "owner"])
def test_a_few_words_will_do(password, role):
    check_new_password(password, role=role)


def test_more_is_asked_of_those_who_see_what_others_wrote():
    check_new_password("Summer2026", role="pupil")
    for role in ("teacher", "owner"):
        with pytest.raises(Unusable, match="at least 3"):
            check_new_password("Summer2026", role=role)


def test_one_s_own_name_is_guessed_first():
    check_new_password("xqzvbkwtr", role="pupil")
    with pytest.raises(Unusable):
        check_new_password("xqzvbkwtr", role="pupil", known=["Xqzvbkwtr Lin"])


@pytest.mark.parametrize("password", ["1234567", "", "x" * (MAX_PASSWORD + 1)])
def test_length(password):
    with pytest.raises(Unusable, match="8 to 200"):
        check_new_password(password, role="pupil")


@pytest.mark.parametrize("unit", ["a1b2c3d4e5", "p4ssw0rd@!", "lololo", "20261129"])
def test_a_long_password_costs_little_time(unit):
    start = time.process_time()
    try:
        check_new_password((unit * MAX_PASSWORD)[:MAX_PASSWORD], role="pupil")
    except Unusable as error:
        assert error.code == "weak_password"
    assert time.process_time() - start < 2


def test_all_advice_is_translated():
    from zxcvbn import feedback

    source = re.sub(r"' \\\n\s+'|\"\n\s+\"", "", inspect.getsource(feedback))
    given = {text for _, text in re.findall(r"_\((['\"])(.+?)\1\)", source)}
    assert len(given) > 20 and given <= set(ADVICE), given - set(ADVICE)
    assert all(re.search("[一-鿿]", zh) for zh in ADVICE.values())


def test_a_service_hashes_as_rfc_9106_says(service_hasher):
    """Its second choice, for where memory is short: 64 MiB, three passes, four lanes."""
    assert service_hasher.hash("a long password").startswith("$argon2id$v=19$m=65536,t=3,p=4$")


def test_a_hash_verifies_its_password_alone(service_hasher, monkeypatch):
    monkeypatch.setattr(passwords, "HASHER", service_hasher)
    hashed = hash_password("a long password")
    assert hashed.startswith("$argon2id$v=19$m=65536,")
    assert verify_password("a long password", hashed)
    assert not verify_password("another password", hashed) and not verify_password("a long password", None)
    assert not verify_password("a long password", "no hash")
