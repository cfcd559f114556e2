"""Licences by their address and their short name, both ways."""

from __future__ import annotations

import pytest

from rumu.gallery.rights import RIGHTS, is_address, licence_of, rights_address


@pytest.mark.parametrize("name", RIGHTS)
def test_a_licence_comes_back_from_its_address(name):
    address = rights_address(f"{name} (as the font says)")
    assert address == RIGHTS[name] and licence_of(address) == name
    assert licence_of(address.replace("http://", "https://")) == name


def test_other_addresses_stay_as_they_are():
    other = "https://rightsstatements.org/vocab/InC/1.0/"
    assert licence_of(other) == rights_address(other) == other
    assert (licence_of(""), rights_address("none stated"), rights_address("")) == ("", None, None)


@pytest.mark.parametrize(
    "text", ["", "javascript:alert(1)", "https://", "/manifest.json", "https://a b/", "ftp://a/"]
)
def test_what_is_no_address_of_the_web(text):
    assert not is_address(text)


@pytest.mark.parametrize("text", ["https://a.example", "http://localhost:8000/a?b=c#d"])
def test_what_is_one(text):
    assert is_address(text)
