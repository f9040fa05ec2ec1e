"""Owns /presets: the designs that come with the program."""

from __future__ import annotations

from functools import cache

from fastapi import APIRouter
from fastapi.responses import Response
from starlette.exceptions import HTTPException

from models.design import Design
from models.presets import load_preset, preset_ids
from models.problems import echo
from server.answers import json_answer
from server.openapi import operation
from server.schemas import PresetItem, PresetList
from server.summaries import summarize

router = APIRouter(tags=["presets"])


@cache
def _preset(preset_id: str) -> Design:
    return load_preset(preset_id)


@router.get("/presets", response_model=PresetList, summary="List the presets", **operation("list_presets"))
def list_presets() -> Response:
    """List the designs that come with the program, each with the beginning of its notes."""
    named = [(name, _preset(name)) for name in preset_ids()]
    return json_answer(
        PresetList(items=[PresetItem(id=name, name=d.name, summary=summarize(d.notes)) for name, d in named])
    )


@router.get("/presets/{preset_id}", response_model=Design, summary="Get a preset", **operation("get_preset", 404))
def get_preset(preset_id: str) -> Response:
    """Answer a preset's whole document, ready to be edited or simulated."""
    if preset_id not in preset_ids():
        known = ", ".join(preset_ids())
        raise HTTPException(404, f"there is no preset {echo(preset_id)}; there are {known}")
    return json_answer(_preset(preset_id))
