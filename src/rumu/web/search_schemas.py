"""Schemas of a search among works: what it finds, what its words are, and choices that narrow it."""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from rumu.web.schemas import Schema, WorkSummary

Meaning = Literal[
    "character", "form", "reading", "other_reading", "hand", "title", "script", "dynasty", "other"
]


class WorkFound(WorkSummary):
    """A work in a list of works found. meanings: of each word of the search, what it is of this work.

    characters: how many stand on it, where it is a page.
    """

    characters: int = 0
    meanings: list[Meaning] = Field(default_factory=list)


class Understood(Schema):
    """What a word of a search is. works: how many of those found have this as its best meaning."""

    word: str = Field(examples=["永"])
    meaning: Meaning
    works: int


class WorkPage(Schema):
    """A part of all works that match. total: how many match. understood: what the words of a search are."""

    total: int
    items: list[WorkFound]
    understood: list[Understood] = Field(default_factory=list)


class FacetValueRead(Schema):
    """One choice, and how many works have it."""

    value: str
    zh: str
    en: str
    count: int
