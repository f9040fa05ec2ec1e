"""A small client of Viser's wire: it speaks as a browser does, through the studio's proxy, and keeps what it hears."""

from __future__ import annotations

import asyncio
import time
from typing import Any

import msgspec
import viser
import websockets
import zstandard

ALIGNMENT = 8


def decode(frame: bytes) -> dict[str, Any]:
    """Decode one frame: two little-endian lengths, zstandard around msgpack, then bare aligned arrays."""
    size, compressed = (int.from_bytes(frame[k : k + 8], "little") for k in (0, 8))
    body = zstandard.ZstdDecompressor().decompress(frame[16 : 16 + compressed], max_output_size=size)
    content = dict(msgspec.msgpack.decode(body))
    arrays, at = [], 16 + compressed
    for length in content.get("binaryBufferLengths", ()):
        at += -at % ALIGNMENT
        arrays.append(frame[at : at + length])
        at += length
    return content | {"arrays": arrays}


class RawClient:
    """One browser. `messages` holds all that came, with the time at which it came under `at`."""

    def __init__(self, url: str, *, cookie: str, origin: str) -> None:
        self._url, self._cookie, self._origin = url, cookie, origin
        self.messages: list[dict[str, Any]] = []
        self._news = asyncio.Condition()

    async def __aenter__(self) -> RawClient:
        self._socket = await websockets.connect(
            self._url, subprotocols=[f"viser-v{viser.__version__}"], compression=None, max_size=None,
            origin=self._origin, additional_headers={"Cookie": self._cookie}, proxy=None,
        )  # fmt: skip
        await self.send(
            type="ViewerCameraMessage", wxyz=(1.0, 0.0, 0.0, 0.0), position=(3.0, 3.0, 3.0), fov=1.0, near=0.01,
            far=1000.0, image_height=600, image_width=800, look_at=(0.0, 0.0, 0.0), up_direction=(0.0, 0.0, -1.0),
        )  # fmt: skip
        self._reader = asyncio.create_task(self._read())
        return self

    async def __aexit__(self, *_: object) -> None:
        self._reader.cancel()
        await asyncio.gather(self._reader, return_exceptions=True)
        await self._socket.close()

    async def _read(self) -> None:
        async for frame in self._socket:
            assert isinstance(frame, bytes)
            at = time.perf_counter()
            decoded = decode(frame)
            async with self._news:
                for message in decoded["messages"]:
                    self.messages.append(message | {"at": at, "arrays": decoded["arrays"]})
                self._news.notify_all()

    @property
    def session_id(self) -> str:
        return self._url.split("/")[-2]

    async def send(self, **message: Any) -> None:
        await self._socket.send(msgspec.msgpack.encode(message))

    async def wait_for(self, wanted: Any, *, after: int = 0, timeout: float = 20.0) -> dict[str, Any]:
        """Return the first message from index `after` on for which `wanted(message)` holds."""

        def found() -> dict[str, Any] | None:
            return next((m for m in self.messages[after:] if wanted(m)), None)

        async with asyncio.timeout(timeout), self._news:
            await self._news.wait_for(found)
            message = found()
        assert message is not None
        return message
