"""Owns the OpenAPI document: what FastAPI cannot know of the routes, the errors of each, and the worked examples."""

from __future__ import annotations

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

REF = "#/components/schemas/{model}"
PROBLEM_REF = {"$ref": "#/components/schemas/ProblemDocument"}
FAILURES = {
    400: "The body is not JSON.",
    401: "The server demands its token.",
    404: "There is nothing of this name.",
    405: "The method is not possible here.",
    406: "None of the kinds on offer is accepted.",
    413: "The body is too large.",
    415: "The body is not said to be JSON.",
    422: "The request or its design cannot be used as it is; every place is named.",
    500: "A fault of the program.",
}
WITH_BODY = (400, 413, 415, 422)


def operation(
    operation_id: str, *fails: int, body: type[BaseModel] | None = None, bare: dict[str, Any] | None = None
) -> dict[str, Any]:
    """Return what a route tells FastAPI for OpenAPI: its name, its failures, and a body that FastAPI does not read.

    `bare` is the schema of what may be sent in place of the object `body`.
    """
    statuses = sorted({401, 405, 500, *fails, *(WITH_BODY if body else ())})
    extra: dict[str, Any] = {"responses": {str(status): _failure(status) for status in statuses}}
    if body is not None:
        schema: dict[str, Any] = {"$ref": REF.format(model=body.__name__)}
        schema = {"oneOf": [schema, bare]} if bare is not None else schema
        extra["requestBody"] = {"required": True, "content": {"application/json": {"schema": schema}}}
    return {"operation_id": operation_id, "openapi_extra": extra}


def _failure(status: int) -> dict[str, Any]:
    return {"description": FAILURES[status], "content": {PROBLEM_JSON: {"schema": PROBLEM_REF}}}


class DocumentedApi(FastAPI):
    """A FastAPI application whose OpenAPI document also holds request types, problem documents and examples."""

    def openapi(self) -> dict[str, Any]:
        """Return the OpenAPI document."""
        document = super().openapi()
        schemas = document.setdefault("components", {}).setdefault("schemas", {})
        if PROBLEM_REF["$ref"].rpartition("/")[2] not in schemas:
            _complete(document, schemas)
            if self.state.settings.demands_token:
                document["security"] = [{"token": []}]
        return document


def _complete(document: dict[str, Any], schemas: dict[str, Any]) -> None:
    _, requests = models_json_schema(
        [(model, "validation") for model in (*REQUESTS, *ANALYSIS_REQUESTS, *LINEAR_REQUESTS, *CONTROL_REQUESTS)],
        ref_template=REF,
    )
    schemas.update(requests["$defs"])
    for name in ("HTTPValidationError", "ValidationError"):
        schemas.pop(name, None)
    document["components"]["securitySchemes"] = {"token": {"type": "http", "scheme": "bearer"}}
    examples = load_examples()
    for path in document["paths"].values():
        for item in path.values():
            _forget_fastapis_own_errors(item["responses"])
            _show_example(item, examples.get(item["operationId"], {}))


def _forget_fastapis_own_errors(responses: dict[str, Any]) -> None:
    for status in [status for status in responses if not status.startswith("2")]:
        if PROBLEM_JSON not in responses[status]["content"]:
            del responses[status]
        else:
            responses[status]["content"] = {PROBLEM_JSON: responses[status]["content"][PROBLEM_JSON]}


def _show_example(item: dict[str, Any], example: dict[str, Any]) -> None:
    for parameter in item.get("parameters", ()):
        parameter["example"] = example["parameters"][parameter["name"]]
    if "requestBody" in item:
        item["requestBody"]["content"]["application/json"]["example"] = example["request"]
    if "response" in example:
        item["responses"]["200"]["content"]["application/json"]["example"] = example["response"]
