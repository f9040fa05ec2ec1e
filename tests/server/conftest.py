"""Owns what the tests of the server share: a compiled kernel."""

from __future__ import annotations

import pytest

from models.warm import warm_kernel


@pytest.fixture(scope="session", autouse=True)
def kernel() -> None:
    warm_kernel()
