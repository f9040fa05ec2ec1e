"""Owns what the tests of the server share: a compiled kernel, and a data folder that is nobody's."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterator

import pytest

from models.warm import warm_kernel
from tests.server.database import database, database_url, postgres, store  # noqa: F401
from tests.server.job_api_support import api, idle  # noqa: F401

# before any application is made: none may touch the designs of who runs the tests
_DATA = tempfile.TemporaryDirectory(prefix="glider-tests-")
os.environ["GLIDER_STUDIO_DATA"] = _DATA.name


@pytest.fixture(scope="session", autouse=True)
def data_folder() -> Iterator[None]:
    yield
    _DATA.cleanup()


@pytest.fixture(scope="session", autouse=True)
def kernel() -> None:
    warm_kernel()
