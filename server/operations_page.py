"""Owns the page at /docs: every operation of the OpenAPI document, to be read by people; it needs no script."""

from __future__ import annotations

import json
from collections.abc import Iterator
from html import escape
from itertools import groupby
from typing import Any

LONGEST_EXAMPLE = 3000
"""An example with more letters is left to the OpenAPI document."""
STYLE = """
:root { color-scheme: light dark; font: 14px/1.5 system-ui, sans-serif }
body { max-width: 60rem; margin: 2rem auto; padding: 0 1rem; overflow-wrap: anywhere }
summary { cursor: pointer; padding: .2rem 0 }
summary b { display: inline-block; min-width: 4.5rem }
details > div { margin: .3rem 0 1rem 4.7rem }
pre { overflow-x: auto; padding: .5rem; border: 1px solid color-mix(in srgb, currentColor 25%, transparent) }
table { border-collapse: collapse } td { padding: .1rem 1rem .1rem 0; vertical-align: top; overflow-wrap: normal }
@media (max-width: 40rem) { details > div { margin-left: 0 } td { padding-right: .5rem } }
"""
Item = tuple[str, str, dict[str, Any]]


def operations_page(document: dict[str, Any]) -> str:
    """Return the page of an OpenAPI document; addresses in it are relative, so that any base path works."""
    info = document["info"]
    title = f"{escape(info['title'])} {escape(info['version'])}"
    groups = [(tag, list(items)) for tag, items in groupby(_operations(document), key=lambda item: item[2]["tags"][0])]
    return (
        f'<!doctype html><html lang="en"><head><meta charset="utf-8"><title>{title}: API</title>'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        f"<style>{STYLE}</style></head><body><h1>{title}: API</h1><p>{escape(info['description'])}</p>"
        '<p>For programs: <a href="api/v1/openapi.json">the OpenAPI document</a>, '
        '<a href="api/v1">the index</a>. From Python: <code>server.client</code>.</p>'
        + "".join(f"<h2>{escape(tag.capitalize())}</h2>" + "".join(map(_section, items)) for tag, items in groups)
        + "</body></html>\n"
    )


def _operations(document: dict[str, Any]) -> Iterator[Item]:
    for path, item in document["paths"].items():
        for method, operation in item.items():
            yield method.upper(), path, operation


def _section(item: Item) -> str:
    method, path, operation = item
    heading = f"<b>{method}</b><code>{escape(path)}</code> {escape(operation['summary'])}"
    about = f"<p>{escape(operation['description'])}</p>"
    parts = (about, _parameters(operation), _body(operation), _answers(operation))
    return (
        f'<details id="{escape(operation["operationId"])}"><summary>{heading}</summary>'
        f"<div>{''.join(parts)}</div></details>"
    )


def _parameters(operation: dict[str, Any]) -> str:
    rows = (
        f"<tr><td><code>{escape(given['name'])}</code></td><td>{escape(given['in'])}</td>"
        f"<td>{escape(given.get('description', ''))}</td></tr>"
        for given in operation.get("parameters", ())
    )
    return f"<table>{''.join(rows)}</table>"


def _body(operation: dict[str, Any]) -> str:
    content = operation.get("requestBody", {}).get("content", {})
    if not content:
        return ""
    return f"<p>Body: {escape(', '.join(content))}</p>" + _example(content)


def _answers(operation: dict[str, Any]) -> str:
    shown = ""
    for status, answer in operation["responses"].items():
        if status.startswith("2"):
            content = answer.get("content", {})
            shown += f"<p>{status}: {escape(', '.join(content) or 'no content')}</p>" + _example(content)
    others = [status for status in sorted(operation["responses"]) if not status.startswith("2")]
    return f"{shown}<p>Else: {', '.join(others)}</p>"


def _example(content: dict[str, Any]) -> str:
    for media in content.values():
        if "example" in media:
            example = media["example"]
            text = example if isinstance(example, str) else json.dumps(example, indent=1, ensure_ascii=False)
            return f"<pre>{escape(text)}</pre>" if len(text) <= LONGEST_EXAMPLE else ""
    return ""
