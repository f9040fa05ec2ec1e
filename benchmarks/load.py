"""Owns the client of the load tests: requests and event streams on bare sockets, so that it takes little of the cores.

It knows as much HTTP as the studio speaks: answers with a length or in chunks, on connections that are kept.
"""

from __future__ import annotations

import asyncio
import json
import time
from collections.abc import AsyncIterator
from dataclasses import dataclass
from typing import Any
from urllib.parse import urlsplit


@dataclass(frozen=True)
class Asked:
    """A request: what it is called in the figures, and its bytes."""

    name: str
    content: bytes


def asked(name: str, method: str, path: str, body: Any = None) -> Asked:
    """Return a request to a server on this machine."""
    content = b"" if body is None else json.dumps(body).encode()
    head = f"{method} {path} HTTP/1.1\r\nHost: 127.0.0.1\r\nAccept: */*\r\n"
    if body is not None:
        head += f"Content-Type: application/json\r\nContent-Length: {len(content)}\r\n"
    return Asked(name, head.encode() + b"\r\n" + content)


class Connection:
    """One kept connection to a server."""

    def __init__(self, url: str) -> None:
        parts = urlsplit(url)
        self._host, self._port = parts.hostname, parts.port

    async def __aenter__(self) -> Connection:
        """Connect."""
        self._reader, self._writer = await asyncio.open_connection(self._host, self._port)
        return self

    async def __aexit__(self, *_: object) -> None:
        """Hang up."""
        self._writer.close()

    async def ask(self, request: Asked) -> tuple[int, bytes]:
        """Return the status and the body of an answer."""
        self._writer.write(request.content)
        status, headers = await self._head()
        if "content-length" in headers:
            return status, await self._reader.readexactly(int(headers["content-length"]))
        return status, b"".join([part async for part in self._chunks()]) if "transfer-encoding" in headers else b""

    async def events(self, path: str) -> AsyncIterator[tuple[float, int, dict[str, Any]]]:
        """Yield when each event of a stream came (perf_counter), its id, and its data, until the stream ends."""
        self._writer.write(asked("", "GET", path).content)
        status, _ = await self._head()
        assert status == 200, status
        waiting = b""
        async for part in self._chunks():
            waiting += part
            *whole, waiting = waiting.split(b"\n\n")
            for block in whole:
                fields = dict(line.split(": ", 1) for line in block.decode().splitlines() if not line.startswith(":"))
                if "data" in fields:
                    yield time.perf_counter(), int(fields["id"]), json.loads(fields["data"])

    async def _head(self) -> tuple[int, dict[str, str]]:
        first, *lines = (await self._reader.readuntil(b"\r\n\r\n")).decode("latin-1").split("\r\n")
        headers = dict(line.lower().split(": ", 1) for line in lines if line)
        return int(first.split()[1]), headers

    async def _chunks(self) -> AsyncIterator[bytes]:
        while size := int(await self._reader.readline(), 16):
            yield (await self._reader.readexactly(size + 2))[:-2]
        await self._reader.readline()
