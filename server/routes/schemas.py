"""Owns /schemas: the JSON Schemas of the design document and the batch document."""

from __future__ import annotations

from functools import cache
from typing import Any

from fastapi import APIRouter
from fastapi.responses import Response

from models.design import Design
from server.answers import json_answer
from server.jobs.spec import batch_schema
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


@router.get(
    "/schemas/batch", response_model=dict[str, Any], summary="Get the batch document's JSON Schema",
    **operation("get_batch_schema"),
)  # fmt: skip
def get_batch_schema() -> Response:
    """Answer the JSON Schema of the batch document, which says what jobs do: every field with a sentence and limits."""
    return json_answer(batch_schema())
