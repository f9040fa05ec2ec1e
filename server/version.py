"""Owns the version of the program as it is told to others."""

from __future__ import annotations

from importlib.metadata import PackageNotFoundError, version


def _installed_version() -> str:
    try:
        return version("glider-studio")
    except PackageNotFoundError:
        # run from a checkout that was not installed
        return "0+unknown"


VERSION = _installed_version()
