"""Routes of characters: their strokes as copybooks print them."""

from __future__ import annotations

from typing import Annotated, Any

from fastapi import APIRouter, Path
from pydantic import Field, model_validator

from rumu.characters.stroke_data import CanonicalCharacter, find_character
from rumu.studio.errors import Missing
from rumu.web.schemas import BilingualText, Extended, Schema

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


@router.get("/api/characters/{character}", response_model=CharacterRead)
def get_character(character: Annotated[str, Path(max_length=8)]) -> CanonicalCharacter:
    """The strokes of a character in the order of writing, in regular script."""
    found = find_character(character)
    if found is None:
        raise Missing(zh="沒有這個字的筆順資料。", en="The strokes of this character are not known.")
    return found
