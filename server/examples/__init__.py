"""The worked examples of the OpenAPI document, one an operation; `build` writes them by asking the program itself."""

from __future__ import annotations

import json
from importlib.resources import files
from typing import Any


def load_examples() -> dict[str, Any]:
    """Return the examples by operation: `parameters` and `request` where there are any, and `response`."""
    examples: dict[str, Any] = json.loads(files(__package__).joinpath("examples.json").read_bytes())
    return examples
