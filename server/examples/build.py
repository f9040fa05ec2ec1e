"""Owns the making of examples.json: it sends each example request to the program and keeps what was answered.

Run `python -m server.examples.build` after a change of the API, the presets or the physics.
"""

from __future__ import annotations

import asyncio
import json
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import httpx
from fastapi import FastAPI

from models.design import Design, parse_design
from models.presets import load_preset
from models.warm import warm_kernel
from server.app import API, create_app
from server.editing import apply_patch
from server.examples.jobs import JOB_HEADERS, demo_jobs, job_requests
from server.examples.stored import HEADERS, demo_store, stored_requests
from server.live import LiveSession
from server.settings import Settings

FILE = Path(__file__).parent / "examples.json"
PRESET = "three-cell-glider"
SESSION = "demo"
THIRD_CELL = {
    "kind": "piston",
    "name": "Tail piston",
    "mass": 0.05,
    "volume": 5e-5,
    "volume_range": [3e-5, 7e-5],
    "position": [-0.1, 0.0, 0.01],
}
"""A cell needs no more than this."""
JSON = "application/json"
TABLE_ANGLES = (0.0, 5.0, 10.0, 20.0, 45.0, 90.0)


def example_design() -> Design:
    """Return a preset cut short for reading: two bellows, one speed and few angles of its table, 10 s."""
    document = load_preset("canete-dual-bellows").model_dump(mode="json")
    document |= {"name": "Example glider", "notes": "A preset cut short, to show the interface; not for use."}
    vehicle, mission = document["vehicle"], document["mission"]
    for component in vehicle["components"]:
        component |= {"shapes": [], "notes": ""}
    table = vehicle["hydrodynamics"]
    speed = max(table["row_speed"])
    rows = [
        k
        for k, (v, alpha) in enumerate(zip(table["row_speed"], table["row_alpha_deg"], strict=True))
        if v == speed and alpha in TABLE_ANGLES
    ]
    for name in [name for name in table if name.startswith("row_")]:
        table[name] = [table[name][k] for k in rows]
    vehicle["mass_properties"] = {"kind": "composite"}
    mission |= {"duration": 10.0}
    mission["control"]["schedules"] = mission["control"]["schedules"][:1]
    for schedule in mission["control"]["schedules"]:
        schedule["points"] = [p for p in schedule["points"] if p["time"] <= mission["duration"]]
    return parse_design(document)


def example_document() -> dict[str, Any]:
    """Return that design as short as it can be written."""
    return {"format": "glider-design", "version": 1} | example_design().model_dump(mode="json", exclude_defaults=True)


class DemoSession:
    """An open session without a browser."""

    def __init__(self, design: Design) -> None:
        self._design = design

    @property
    def design(self) -> Design:
        """The document as it is now."""
        return self._design

    def edit(self, patch: Sequence[Mapping[str, Any]]) -> Design:
        """Apply a JSON Patch."""
        self._design = apply_patch(self._design, patch)
        return self._design


class DemoSessions:
    """Open sessions that are always as at the start, so that examples do not depend on their order."""

    def get(self, session_id: str) -> LiveSession | None:
        """Return the one session there is, or None."""
        return DemoSession(example_design()) if session_id == SESSION else None


def example_requests() -> dict[str, dict[str, Any]]:
    """Return, by operation, the method and path, the parameters and the body of a worked example."""
    design = example_document()
    add = [{"op": "add", "path": "/vehicle/components/-", "value": THIRD_CELL}]
    first_cell = next(c.name for _, c in example_design().vehicle.actuated)
    options = {"max_points": 5, "columns": ["x", "z", "theta", "extension"]}
    requests: dict[str, dict[str, Any]] = {
        "get_health": {"at": ("GET", "/healthz")},
        "get_readiness": {"at": ("GET", "/readyz")},
        "get_index": {"at": ("GET", API)},
        "list_presets": {"at": ("GET", f"{API}/presets")},
        "get_preset": {"at": ("GET", f"{API}/presets/{{preset_id}}"), "parameters": {"preset_id": PRESET}},
        "get_design_schema": {"at": ("GET", f"{API}/schemas/design")},
        "validate_design": {"at": ("POST", f"{API}/designs:validate"), "request": design},
        "edit_design": {"at": ("POST", f"{API}/designs:edit"), "request": {"design": design, "patch": add}},
        "trim_ballast": {"at": ("POST", f"{API}/designs:trim-ballast"), "request": {"design": design}},
        "get_session_design": {
            "at": ("GET", f"{API}/sessions/{{session_id}}/design"), "parameters": {"session_id": SESSION},
        },
        "edit_session_design": {
            "at": ("PATCH", f"{API}/sessions/{{session_id}}/design"), "parameters": {"session_id": SESSION},
            "request": [{"op": "replace", "path": "/mission/duration", "value": 20.0}],
        },
        "preview_simulation": {
            "at": ("POST", f"{API}/simulations:preview"), "request": {"design": design, "options": options},
        },
        "analyze_mass": {
            "at": ("POST", f"{API}/analyses:mass"),
            "request": {"design": design, "options": {"extensions": {first_cell: 0.02}}},
        },
    }  # fmt: skip
    stored = stored_requests(API, design, THIRD_CELL) | job_requests(API, design)
    return requests | _analysis_requests(design, first_cell) | stored


def _analysis_requests(design: dict[str, Any], first_cell: str) -> dict[str, dict[str, Any]]:
    """Return the examples of analyses: a glide 30 deg down, and what follows from it."""
    heavy: dict[str, Any] = {"targets": {"glide_angle": -0.5, "speed": 0.2}}
    options: dict[str, dict[str, Any]] = {
        "trim": heavy,
        "polar": {"points": 3},
        "linearize": heavy | {
            "responses": [{"input": f"command of {first_cell}", "output": "theta"}], "frequencies": [0.1, 1.0],
        },
        "stability": {"samples": 3, "max_points": 3},
        "allocation": {"wanted": {"heave": -0.05, "pitch": 0.01}},
    }  # fmt: skip
    feedback = {"trim": heavy, "sample_time": 0.5, "step": {"state": "theta", "amount": 0.01, "duration": 5.0}}
    return {
        f"analyze_{name}": {
            "at": ("POST", f"{API}/analyses:{name}"), "request": {"design": design, "options": chosen},
        }
        for name, chosen in options.items()
    } | {
        "design_controller": {
            "at": ("POST", f"{API}/controllers:design"), "request": {"design": design, "options": feedback},
        }
    }  # fmt: skip


def _shortened(name: str, response: Any) -> Any:
    if name == "get_batch_schema":
        return {key: response[key] for key in ("$schema", "title", "discriminator")}
    if name == "get_design_schema":
        # the whole of it is what the operation answers; an example needs its beginning
        return {key: response[key] for key in ("$schema", "title", "type", "required")}
    if name == "analyze_linearize":
        # eigenvectors and cosines of modes that lie close together depend on rounding: names and growth tell enough
        kept = ("name", "real", "imag", "period", "damping_ratio", "time_constant")
        modes = [{key: mode[key] for key in kept} for mode in response["modes"]["modes"]]
        reach = {key: response["controllability"][key] for key in ("inputs", "states", "rank", "unmoved", "words")}
        return response | {"modes": response["modes"] | {"modes": modes}, "controllability": reach}
    if name == "design_controller":
        shown = ("controller", "trim", "cells", "states", "gains", "stable", "response", "warnings")
        return response | {"feedback": {key: response["feedback"][key] for key in shown}}  # modes as above
    if name == "analyze_allocation":
        return {key: value for key, value in response.items() if key != "directions"}  # equal values: any will do
    return response


async def build() -> dict[str, Any]:
    """Ask every example and return all with what was answered."""
    await asyncio.to_thread(warm_kernel)
    examples = {}
    for name, example in example_requests().items():
        answer = await _ask(*example.pop("at"), parameters=example.get("parameters", {}), body=example.get("request"))
        answer.raise_for_status()
        if answer.headers.get("content-type") == JSON:
            example["response"] = _shortened(name, answer.json())
        examples[name] = example
    return examples


async def _ask(method: str, path: str, media: str = JSON, *, parameters: dict[str, Any], body: Any) -> httpx.Response:
    """Ask an app of its own, so that examples do not depend on their order."""
    headers = {name: value for name, value in parameters.items() if name in HEADERS | JOB_HEADERS}
    query = {name: value for name, value in parameters.items() if name not in headers and f"{{{name}}}" not in path}
    content = json.dumps(body) if media == JSON and body is not None else body
    with demo_app() as app:
        async with httpx.AsyncClient(transport=httpx.ASGITransport(app), base_url="http://localhost") as client:
            return await client.request(
                method, path.format(**parameters), params=query, content=content,
                headers=headers | ({"content-type": media} if content is not None else {}),
            )  # fmt: skip


@contextmanager
def demo_app() -> Iterator[FastAPI]:
    """Enter the API as the examples find it: with an open session, a few designs and jobs, all as at the start."""
    with demo_store(example_design()) as store, demo_jobs(example_document()) as jobs:
        yield create_app(Settings(host="127.0.0.1", token=None), live=DemoSessions(), store=store, jobs=jobs)


if __name__ == "__main__":
    FILE.write_text(json.dumps(asyncio.run(build()), indent=1, ensure_ascii=False) + "\n")
