"""Owns /schemas: the JSON Schema of the design document."""

from __future__ import annotations

from functools import cache
from typing import Any

from fastapi import APIRouter
from fastapi.responses import Response

from models.design import Design
from server.answers import json_answer
from server.openapi import operation

router = APIRouter(tags=["schemas"])


@cache
def design_schema() -> dict[str, Any]:
    """Return the JSON Schema of a design document, with units, symbols and limits."""
    return {"$schema": "https://json-schema.org/draft/2020-12/schema"} | Design.model_json_schema()


@router.get(
    "/schemas/design", response_model=dict[str, Any], summary="Get the design's JSON Schema",
    **operation("get_design_schema"),
)  # fmt: skip
def get_design_schema() -> Response:
    """Answer the JSON Schema of the design document: every field with its unit, symbol, limits and a sentence."""
    return json_answer(design_schema())
