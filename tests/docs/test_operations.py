"""docs/operations.md lists every setting, and names only settings, figures and addresses that exist."""

from __future__ import annotations

import re

from docs.make_operations import PAGE, page, settings_table
from server.settings import Settings
from tests.server.job_api_support import idle_api
from tests.server.support import ask

TEXT = PAGE.read_text(encoding="utf-8")
NAMES = {f"GLIDER_STUDIO_{name.upper()}" for name in Settings.model_fields}


def test_the_table_is_what_its_generator_writes():
    assert page() == TEXT, "the table of settings is stale: run `python -m docs.make_operations`"


def test_every_setting_says_what_it_is():
    rows = re.findall(r"^\| `(\w+)` \| (.*) \| (.+) \|$", settings_table(), re.M)
    assert {name for name, _, _ in rows} == NAMES
    assert all(words.endswith(".") for _, _, words in rows)


def test_the_page_names_only_settings_that_exist():
    assert set(re.findall(r"GLIDER_STUDIO_[A-Z_]+", TEXT)) == NAMES


def test_the_page_tells_every_figure_and_no_other(tmp_path):
    with idle_api(tmp_path) as api:
        ask("GET", "/healthz", app=api.app)  # a histogram is told once it has something to tell
        exposition = ask("GET", "/metrics", app=api.app).text
    there = set(re.findall(r"^# TYPE (glider_studio_\w+)", exposition, re.M))
    assert len(there) > 8
    told = re.findall(r"^\| `(glider_studio_\w+)` \| \S", TEXT, re.M)
    assert set(told) == {name for name in there if not name.endswith("_created")} and len(told) == len(set(told))
    assert set(re.findall(r"glider_studio_[a-z_]+", TEXT)) == set(told)


def test_the_addresses_are_answered():
    for path in re.findall(r"^\| `(/\w+)` \|", TEXT, re.M):
        assert ask("GET", path).status_code == 200, path
