"""The socket that the program listens on."""

from __future__ import annotations

import asyncio
import socket

from server.settings import Settings
from studio.serve import bind


def test_small_answers_leave_at_once():
    """Nagle's algorithm would keep the second part of an answer until the first is acknowledged, 40 ms later."""
    told: asyncio.Queue[int] = asyncio.Queue()

    async def answer(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        accepted: socket.socket = writer.get_extra_info("socket")
        await told.put(accepted.getsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY))
        writer.close()

    async def ask() -> int:
        listener = bind(Settings(host="127.0.0.1", port=0, token=None))
        assert listener is not None
        async with await asyncio.start_server(answer, sock=listener):
            _, writer = await asyncio.open_connection(*listener.getsockname())
            writer.close()
            return await told.get()

    assert asyncio.run(ask()) != 0
