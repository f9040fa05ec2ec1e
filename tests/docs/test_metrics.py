"""docs/metrics.md lists the metrics that there are, and what it shows can be asked for."""

from __future__ import annotations

import json
import math
import re
from pathlib import Path

import pytest
from pydantic import TypeAdapter

from models.built_in_metrics import BUILT_IN
from models.metric_phases import Phase
from models.metric_requests import KINDS, MetricRequest, StatisticName
from models.metrics import evaluate, metrics_for
from models.presets import load_preset
from models.simulate import simulate

PAGE = (Path(__file__).parents[2] / "docs" / "metrics.md").read_text(encoding="utf-8")
DESIGN = load_preset("quad-bellows-yo-yo")
COMPOSED = [json.loads(block) for block in re.findall(r"^```json\n(.*?)^```", PAGE, re.S | re.M)]
PHASES = [json.loads(row) for row in re.findall(r"^\| `(\{.*?\})` \|", PAGE, re.M)]


@pytest.fixture(scope="module")
def run():
    return simulate(DESIGN)


def test_the_table_is_that_of_the_program():
    rows = re.findall(r"^\| `(\w+)` \| (.+?) \| (.+) \|$", PAGE, re.M)
    assert rows == [
        (name, built_in.unit, built_in.meaning + ("" if "planar" in built_in.models else " (spatial)"))
        for name, built_in in BUILT_IN.items()
    ]


def kinds(union):
    """The kinds of a union of descriptions, and of all that they hold."""
    fields = [model["properties"].get("kind", {}) for model in TypeAdapter(union).json_schema()["$defs"].values()]
    return {kind for field in fields for kind in (field.get("enum") or [field.get("const")]) if kind}


def test_every_kind_is_shown():
    phases = kinds(Phase)
    assert {phase["kind"] for phase in PHASES} == phases
    assert all(f"`{name}`" in PAGE for name in StatisticName.__args__)
    assert kinds(MetricRequest) - phases == set(KINDS)
    assert [kind for kind in KINDS if f"**{kind}**" not in PAGE] == []


def test_what_is_shown_has_values(run):
    shown = COMPOSED + [{"kind": "statistic", "of": "speed", "statistic": "mean", "over": phase} for phase in PHASES]
    values = evaluate(run, metrics_for(DESIGN, shown))
    missing = [request for request, value in zip(shown, values, strict=True) if math.isnan(value)]
    assert [request["kind"] for request in missing] in ([], ["event_time"])  # a stop that no cell reaches


def test_the_code_shown_runs(capsys):
    (code,) = re.findall(r"^```python\n(.*?)^```", PAGE, re.S | re.M)
    exec(compile(code, "docs/metrics.md", "exec"), {})
    lines = capsys.readouterr().out.splitlines()
    assert lines[0].startswith("glide_ratio 1.6") and lines[1].startswith("slowest climb 0.36")
