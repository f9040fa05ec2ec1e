"""Owns how answers are written: straight to JSON, numbers that are not finite as null, and the kinds on offer."""

from __future__ import annotations

from typing import Any

import orjson
from fastapi.responses import Response
from pydantic_core import to_json
from starlette.exceptions import HTTPException

from models.problems import echo

JSON, CSV, NETCDF = "application/json", "text/csv", "application/x-netcdf"


def json_answer(content: Any, status: int = 200) -> Response:
    """Return `content` (models, dicts, lists, numbers) as a JSON answer."""
    return Response(to_json(content, inf_nan_mode="null"), status, media_type=JSON)


def series_json(content: Any) -> bytes:
    """Return `content` (plain values, and NumPy arrays of numbers) as JSON.

    Arrays are written from memory as they are, in less than half the time that lists take. It knows no models, and no
    whole numbers beyond 64 bits, which a document that is sent back may hold.
    """
    return orjson.dumps(content, option=orjson.OPT_SERIALIZE_NUMPY)


def series_answer(content: Any) -> Response:
    """Return `content` (plain values, and NumPy arrays of numbers) as a JSON answer."""
    return Response(series_json(content), media_type=JSON)


def negotiate(accept: str | None, offers: tuple[str, ...]) -> str:
    """Return the offer that an Accept header likes best; of equals the first. Answers 406 where it likes none."""
    ranges = [_media_range(item) for item in (accept or "*/*").split(",") if item.strip()]
    weights = [_weight(offer, ranges) for offer in offers]
    best = max(weights)
    if best <= 0.0:
        raise HTTPException(406, f"Accept is {echo(accept)}; on offer are {', '.join(offers)}")
    return offers[weights.index(best)]


def _media_range(item: str) -> tuple[str, float]:
    name, *parameters = (part.strip().lower() for part in item.split(";"))
    quality = next((p[2:] for p in parameters if p.startswith("q=")), "1")
    try:
        return name, min(max(float(quality), 0.0), 1.0)
    except ValueError:
        return name, 0.0


def _weight(offer: str, ranges: list[tuple[str, float]]) -> float:
    """Return the quality of the most specific range that covers an offer (RFC 9110, section 12.5.1)."""
    for pattern in (offer, offer.split("/")[0] + "/*", "*/*"):
        for name, quality in ranges:
            if name == pattern:
                return quality
    return 0.0
