"""Owns the pages on the way into the studio by a link: one that opens a design, and one that says why it cannot."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape

from fastapi import Request
from fastapi.responses import HTMLResponse, Response

from studio.access import PAGE_HEADERS

HEADERS = PAGE_HEADERS | {"Cache-Control": "no-store"}
PAGE = """<!doctype html>
<html lang="en">
<head>
  <meta charset="utf-8">
  <meta name="viewport" content="width=device-width, initial-scale=1">
  <meta name="robots" content="noindex">
  <title>{title} · Glider studio</title>
  <link rel="icon" href="{root}static/icon.svg" type="image/svg+xml">
  <script src="{root}static/themestart.js"></script>
  <link rel="stylesheet" href="{root}static/tokens.css">
  <link rel="stylesheet" href="{root}static/opening.css">
</head>
<body>
  <main class="{kind}">
    {content}
  </main>
</body>
</html>
"""


def opening_page(request: Request, name: str, detail: str) -> Response:
    """Return the page that opens a design as soon as somebody looks at it.

    Asking for an address makes nothing: what scans or fetches links ahead, or shows them as pictures, opens no session.
    """
    root = _root(request)
    content = (
        f'<form id="opening" method="post"><h1>{escape(name)}</h1><p>{escape(detail)}</p>'
        '<button class="btn primary" type="submit" data-testid="open-design">Open in the studio</button></form>'
        f'<script type="module" src="{root}static/opening.js"></script>'
    )
    return _page(root, name, content, kind="opening")


def problem_page(
    request: Request, status: int, title: str, detail: str, *, errors: Sequence[str] = (), action: str = ""
) -> Response:
    """Return the page that says why nothing was opened, with the ways on; `action` is one more, as HTML."""
    root = _root(request)
    items = "".join(f"<li>{escape(error)}</li>" for error in errors)
    content = (
        f'<section class="box bad" role="alert" data-testid="problem"><h1>{escape(title)}</h1>'
        f"<p>{escape(detail)}</p>{f'<ul>{items}</ul>' if items else ''}</section>"
        f'<div class="ways">{action}<a class="btn" href="{root}">Presets and stored designs</a></div>'
    )
    return _page(root, title, content, kind="problem", status=status)


def restore_form(request: Request, design_id: str) -> str:
    """Return the button that brings a deleted design back, and opens it."""
    target = escape(f"{_root(request)}d/{design_id}/restore")
    return (
        f'<form method="post" action="{target}">'
        '<button class="btn primary" type="submit" data-testid="restore">Restore and open it</button></form>'
    )


def again_link(request: Request) -> str:
    """Return the link that tries the same address once more."""
    query = f"?{request.url.query}" if request.url.query else ""
    return f'<a class="btn primary" href="{escape(request.url.path + query)}">Try again</a>'


def job_link(request: Request, job_id: str | None) -> str:
    """Return the link back to a job's page, or to the list of jobs."""
    path, name = ("jobs", "All jobs") if job_id is None else (f"jobs/{job_id}", "Back to the job")
    return f'<a class="btn primary" href="{escape(_root(request) + path)}" data-testid="back-to-jobs">{name}</a>'


def _root(request: Request) -> str:
    """Return the way from a page to the studio's root, relative: any base path works."""
    path = request.url.path.removeprefix(request.scope.get("root_path", ""))
    return "../" * (path.count("/") - 1) or "./"


def _page(root: str, title: str, content: str, *, kind: str, status: int = 200) -> Response:
    page = PAGE.format(title=escape(title), root=root, kind=kind, content=content)
    return HTMLResponse(page, status, HEADERS)
