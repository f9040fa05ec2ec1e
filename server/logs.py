"""Owns the log: lines of text for a terminal or JSON for a collector, each with the request it belongs to."""

from __future__ import annotations

import logging
import re
import sys
from typing import Literal, TextIO

from pythonjsonlogger.json import JsonFormatter

from server import request_context

CONTROL = re.compile(r"[\x00-\x1f\x7f-\x9f\u2028\u2029]")
FIELDS = ("levelname", "name", "message", "request_id", "principal")


class RequestFilter(logging.Filter):
    """Adds the request's id and its user to every line that is written while it is served."""

    def filter(self, record: logging.LogRecord) -> bool:
        """Let every line pass."""
        context = request_context.current()
        record.request_id = context.id if context is not None else "-"
        record.principal = context.principal if context is not None else "-"
        return True


class TextFormatter(logging.Formatter):
    """One line a record, whatever was sent: what a client sent cannot begin a line of its own."""

    def __init__(self) -> None:
        super().__init__("%(asctime)s %(levelname)s %(name)s [%(request_id)s %(principal)s] %(message)s")

    def formatMessage(self, record: logging.LogRecord) -> str:
        """Return the line with its control characters escaped; a traceback follows it as it is."""
        return CONTROL.sub(lambda match: repr(match[0])[1:-1], super().formatMessage(record))


def json_formatter() -> logging.Formatter:
    """Return the formatter of JSON lines: time, level, logger, message, request, and the line's own figures."""
    names = {"levelname": "level", "name": "logger"}
    return JsonFormatter(FIELDS, rename_fields=names, timestamp=True)


def configure_logging(kind: Literal["text", "json"], level: str, *, stream: TextIO | None = None) -> None:
    """Write the log of the whole process to `stream`, standard error if not given; calling it again replaces it."""
    handler = logging.StreamHandler(stream if stream is not None else sys.stderr)
    handler.setFormatter(json_formatter() if kind == "json" else TextFormatter())
    handler.addFilter(RequestFilter())
    logging.basicConfig(level=level.upper(), handlers=[handler], force=True)
    for chatty in ("httpx", "httpcore", "websockets", "matplotlib", "numba", "asyncio", "h5py", "alembic"):
        logging.getLogger(chatty).setLevel(logging.WARNING)
