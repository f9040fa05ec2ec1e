"""docs/physics.md names files and tests that exist."""

from __future__ import annotations

import re

import pytest

from docs.make_paper import DOCS

TEXT = (DOCS / "physics.md").read_text(encoding="utf-8")
ROOT = DOCS.parent


@pytest.mark.parametrize("name", sorted(set(re.findall(r"`(test_\w+)`", TEXT))))
def test_named_tests_exist(name):
    assert (ROOT / "tests" / "models" / f"{name}.py").is_file()


@pytest.mark.parametrize("name", sorted(set(re.findall(r"`([\w/]+\.py)`", TEXT))))
def test_named_files_exist(name):
    assert any((ROOT / folder / name).is_file() for folder in (".", "models", "models/kernel"))
