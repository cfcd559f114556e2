"""Schemas of guided tours: steps through works, each with a view and a text."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import Field, field_validator

from rumu.web.dependencies import Id, ShortText
from rumu.web.schemas import BilingualInput, BilingualText, Schema, ShortBilingualInput


class TourStep(Schema):
    """view: the query of the viewer's permalink."""

    work: Id = Field(examples=["regular-shui"])
    view: Annotated[ShortText, Field(max_length=500)] = ""
    title: ShortBilingualInput = ShortBilingualInput()
    text: BilingualInput = BilingualInput()


class TourCreate(Schema):
    """A walk through works."""

    title: ShortBilingualInput
    steps: list[TourStep] = Field(max_length=100)


class TourUpdate(Schema):
    """Fields that are left out stay as they are."""

    title: ShortBilingualInput | None = None
    steps: list[TourStep] | None = Field(default=None, max_length=100)


class TourRead(Schema):
    """A guided walk through works."""

    id: str
    title: BilingualText
    steps: list[dict[str, Any]]

    @field_validator("steps", mode="before")
    @classmethod
    def _join_languages(cls, steps: list[dict[str, str]]) -> list[dict[str, Any]]:
        return [
            {"work": step["work"], "view": step.get("view", "")}
            | {
                name: {language: step.get(f"{name}_{language}", "") for language in ("zh", "en")}
                for name in ("title", "text")
            }
            for step in steps
        ]
