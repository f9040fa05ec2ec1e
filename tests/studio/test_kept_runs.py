from __future__ import annotations

from collections.abc import Iterator

import httpx
import numpy as np
import pytest

from models.presets import load_preset
from models.problems import DesignError
from models.run import Run
from models.simulate import simulate
from studio.kept_runs import LONGEST_NAME, MOST_KEPT, KeptRuns
from studio.outputs import curves_of, outputs_of
from tests.studio.conftest import Studio, wait_until


@pytest.fixture(scope="module")
def opened(studio: Studio) -> Iterator[httpx.Client]:
    client, _ = studio.open()
    wait_until(lambda: client.get("state").json()["run"] is not None)
    yield client
    client.close()


@pytest.fixture(scope="module")
def run(kernel: None) -> Run:
    return simulate(load_preset("quad-bellows-spiral"))


def test_a_kept_run_stays_while_the_design_goes_on(opened: httpx.Client) -> None:
    before = opened.get("runs/current/columns", params={"name": "z"}).json()
    kept = opened.post("runs", json={"name": "Before"}).json()["id"]
    number = opened.get("state").json()["run"]["number"]
    opened.post("edit", json={"patch": [{"op": "replace", "path": "/mission/initial/pitch", "value": 0.2}]})
    wait_until(lambda: opened.get("state").json()["run"]["number"] > number)
    assert opened.get(f"runs/{kept}/columns", params={"name": "z"}).json() == before
    assert opened.get("runs/current/columns", params={"name": "z"}).json() != before
    assert [item["name"] for item in opened.get("state").json()["kept"]] == ["Before"]
    assert opened.patch(f"runs/{kept}", json={"name": "Heavier  before"}).status_code == 204
    assert opened.get("state").json()["kept"][0]["name"] == "Heavier before"
    assert opened.delete(f"runs/{kept}").status_code == 204
    assert opened.get("state").json()["kept"] == []
    gone = opened.get(f"runs/{kept}/columns", params={"name": "z"})
    assert gone.status_code == 404
    assert opened.delete(f"runs/{kept}").status_code == 404


def test_bad_requests_are_told(opened: httpx.Client) -> None:
    for answer, pointer in [
        (opened.post("runs", json={"name": 7}), "/name"),
        (opened.post("runs", json={"name": "x" * (LONGEST_NAME + 1)}), "/name"),
        (opened.get("runs/current/columns", params={"name": ""}), "/name"),
    ]:
        assert answer.status_code == 422
        assert answer.json()["errors"][0]["pointer"] == pointer


def test_only_so_many_are_kept_and_their_colours_are_given_again(run: Run) -> None:
    kept = KeptRuns()
    runs = [kept.keep(run) for _ in range(MOST_KEPT)]
    with pytest.raises(DesignError, match="the most is 4"):
        kept.keep(run)
    assert kept.forget(runs[1].id)
    again = kept.keep(run)
    assert again.place == runs[1].place
    assert again.id not in {r.id for r in runs}
    assert [k.id for k in kept] == [runs[0].id, runs[2].id, runs[3].id, again.id]


def test_every_output_can_be_had_with_its_unit(run: Run) -> None:
    items = outputs_of(run)
    names = [item["name"] for item in items]
    assert len(set(names)) == len(names)
    curves = curves_of(run, names)
    assert curves["missing"] == []
    assert curves["units"] == {item["name"]: item["unit"] for item in items}
    assert {len(column) for column in curves["columns"].values()} == {len(curves["t"])}


def test_a_curve_hides_no_extreme(run: Run) -> None:
    cell = f"extension@{run.cells[0]}"
    columns = curves_of(run, ["theta", cell])["columns"]
    theta, extension = run.values["theta"], run.cell_values["extension"][:, 0]
    for shown, whole in ((columns["theta"], theta), (columns[cell], extension)):
        np.testing.assert_allclose([min(shown), max(shown)], [whole.min(), whole.max()], rtol=1e-6)


def test_what_another_design_has_not_is_missing_not_wrong(run: Run) -> None:
    curves = curves_of(run, ["z", "extension@No such cell", "no_such_output"])
    assert curves["missing"] == ["extension@No such cell", "no_such_output"]
    assert set(curves["columns"]) == {"z"}
