"""Owns the OpenAPI document: what FastAPI cannot know of the routes, the errors of each, and the worked examples."""

from __future__ import annotations

import threading
from collections.abc import Mapping
from typing import Any

from fastapi import FastAPI
from pydantic import BaseModel
from pydantic.json_schema import models_json_schema

from server.errors import PROBLEM_JSON
from server.examples import load_examples
from server.schemas import REQUESTS
from server.schemas_analyses import ANALYSIS_REQUESTS
from server.schemas_control import CONTROL_REQUESTS
from server.schemas_linear import LINEAR_REQUESTS
from server.schemas_store import STORE_REQUESTS

API = "/api/"
REF = "#/components/schemas/{model}"
PROBLEM_REF = {"$ref": "#/components/schemas/ProblemDocument"}
FAILURES = {
    400: "The body is not JSON.",
    401: "The server demands its token.",
    403: "A page of another site asks for a change.",
    404: "There is nothing of this name.",
    405: "The method is not possible here.",
    406: "None of the kinds on offer is accepted.",
    409: "The job's state does not allow it; the message names the state.",
    410: "It was deleted, and can be restored.",
    412: "The design has changed since the revision that If-Match names.",
    413: "The body is too large.",
    415: "The body is not said to be JSON.",
    421: "The host name is not one that the server goes by.",
    422: "The request or its design cannot be used as it is; every place is named.",
    428: "If-Match is missing.",
    429: "A quota is used up; Retry-After says when to come again.",
    500: "A fault of the program.",
    503: "A part that is needed cannot be reached; Retry-After says when to come again.",
}
WITH_BODY = (400, 403, 413, 415, 422)


NOT_MODIFIED = 304


def operation(
    operation_id: str,
    *fails: int,
    body: type[BaseModel] | None = None,
    bare: dict[str, Any] | None = None,
    files: Mapping[str, dict[str, Any]] | None = None,
) -> dict[str, Any]:
    """Return what a route tells FastAPI for OpenAPI: its name, its failures, and a body that FastAPI does not read.

    `bare` is the schema of what may be sent in place of the object `body`; `files` are those of other media types.
    """
    statuses = sorted({401, 405, 421, 429, 500, *fails, *(WITH_BODY if body or files else ())})
    extra: dict[str, Any] = {"responses": {str(status): _failure(status) for status in statuses}}
    content = {media: {"schema": schema} for media, schema in (files or {}).items()}
    if body is not None:
        schema: dict[str, Any] = {"$ref": REF.format(model=body.__name__)}
        content = {"application/json": {"schema": {"oneOf": [schema, bare]} if bare is not None else schema}} | content
    if content:
        extra["requestBody"] = {"required": True, "content": content}
    return {"operation_id": operation_id, "openapi_extra": extra}


def _failure(status: int) -> dict[str, Any]:
    if status == NOT_MODIFIED:
        return {"description": "The client has it already."}
    return {"description": FAILURES[status], "content": {PROBLEM_JSON: {"schema": PROBLEM_REF}}}


class DocumentedApi(FastAPI):
    """A FastAPI application whose OpenAPI document also holds request types, problem documents and examples."""

    def __init__(self, **options: Any) -> None:
        super().__init__(**options)
        self._building = threading.Lock()

    def openapi(self) -> dict[str, Any]:
        """Return the OpenAPI document; it is built once, and whoever asks meanwhile waits for it."""
        with self._building:
            document = super().openapi()
            schemas = document.setdefault("components", {}).setdefault("schemas", {})
            if "securitySchemes" not in document["components"]:
                _complete(document, schemas)
                if self.state.settings.demands_token:
                    document["security"] = [{"token": []}]
        return document


def _complete(document: dict[str, Any], schemas: dict[str, Any]) -> None:
    _, requests = models_json_schema(
        [
            (model, "validation")
            for model in (*REQUESTS, *ANALYSIS_REQUESTS, *LINEAR_REQUESTS, *CONTROL_REQUESTS, *STORE_REQUESTS)
        ],
        ref_template=REF,
    )
    schemas.update(requests["$defs"])
    for name in ("HTTPValidationError", "ValidationError"):
        schemas.pop(name, None)
    document["components"]["securitySchemes"] = {"token": {"type": "http", "scheme": "bearer"}}
    examples = load_examples()
    for path, operations in document["paths"].items():
        for item in operations.values():
            _forget_fastapis_own_errors(item["responses"])
            if path.startswith(API):  # there an unknown query parameter is refused, whatever else there is
                item["responses"].setdefault("422", _failure(422))
            _show_example(item, examples.get(item["operationId"], {}))


def _forget_fastapis_own_errors(responses: dict[str, Any]) -> None:
    for status in [status for status in responses if status.startswith(("4", "5"))]:
        if PROBLEM_JSON not in responses[status]["content"]:
            del responses[status]
        else:
            responses[status]["content"] = {PROBLEM_JSON: responses[status]["content"][PROBLEM_JSON]}


def _show_example(item: dict[str, Any], example: dict[str, Any]) -> None:
    for parameter in item.get("parameters", ()):
        if parameter["name"] in example.get("parameters", {}):  # what may be left out is
            parameter["example"] = example["parameters"][parameter["name"]]
    if "requestBody" in item:
        next(iter(item["requestBody"]["content"].values()))["example"] = example["request"]
    if "response" in example:
        answer = next(answer for status, answer in item["responses"].items() if status.startswith("2"))
        answer["content"]["application/json"]["example"] = example["response"]
