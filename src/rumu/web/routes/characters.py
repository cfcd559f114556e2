"""Routes of characters: their strokes as copybooks print them, and all hands that wrote them."""

from __future__ import annotations

from typing import Annotated, Any

from fastapi import APIRouter, Path
from pydantic import Field, model_validator

from rumu.characters.stroke_data import CanonicalCharacter, find_character
from rumu.gallery.hands import CharacterHands, hands_of
from rumu.studio.errors import Missing
from rumu.web.dependencies import CleanText, ServiceDep
from rumu.web.schemas import BilingualText, Extended, Schema, WorkSummary

router = APIRouter(tags=["characters"])


class CharacterStrokeRead(Schema):
    """path: outline, as the `d` of an SVG path. centre_line: points, [x, y]; both in a square of side 1."""

    name: BilingualText
    path: str
    centre_line: list[list[float]]

    @model_validator(mode="before")
    @classmethod
    def _add_path(cls, stroke: Any) -> Any:
        return Extended(stroke, path=stroke.svg_path(), centre_line=stroke.centre_line.round(4).tolist())


class CharacterRead(Schema):
    """A character in regular script, its strokes in the order of writing; structure: null if not known."""

    character: str = Field(examples=["永"])
    structure: str | None = Field(examples=["left-right"])
    strokes: list[CharacterStrokeRead]


class HandRead(Schema):
    """A writer with all works of the character by this hand. time: the dynasty's name, '' if not known."""

    hand: BilingualText
    time: BilingualText
    works: list[WorkSummary]


class ScriptHandsRead(Schema):
    """The hands of one script, the earliest first. script: '' where it is not known."""

    script: str = Field(examples=["running"])
    hands: list[HandRead]


class CharacterHandsRead(Schema):
    """A character by all hands. total: of its works; hands: how many writers."""

    character: str = Field(examples=["永"])
    total: int
    hands: int
    scripts: list[ScriptHandsRead]


@router.get("/api/characters/{character}/works", response_model=CharacterHandsRead)
def list_hands(
    service: ServiceDep, character: Annotated[CleanText, Path(min_length=1, max_length=8)]
) -> CharacterHands:
    """All works of a character, in any of its forms: by script, then by time, then by hand."""
    return hands_of(service.gallery, character)


@router.get("/api/characters/{character}", response_model=CharacterRead)
def get_character(character: Annotated[str, Path(max_length=8)]) -> CanonicalCharacter:
    """The strokes of a character in the order of writing, in regular script."""
    found = find_character(character)
    if found is None:
        raise Missing(zh="沒有這個字的筆順資料。", en="The strokes of this character are not known.")
    return found
