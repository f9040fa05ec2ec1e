"""The result of a run: named axes, units, files, and what it says of itself."""

import csv
import io
import json

import numpy as np
import pytest
import xarray as xr
from hypothesis import given, settings

from models.design import parse_design
from models.kernel import KERNEL_HASH
from models.presets import load_preset, preset_ids
from models.run import Event, Run, Status
from models.simulate import simulate
from models.water import gravity_of
from tests.models.support import PISTON, document, schedule
from tests.strategies import designs


@pytest.fixture(scope="module", params=preset_ids())
def run(request):
    return simulate(load_preset(request.param))


def assert_units(run, data):
    for name, (unit, meaning) in (run.variables | run.cell_variables).items():
        assert data[name].attrs == {"units": unit, "long_name": meaning}
    assert data["time"].attrs["units"] == "s"


def test_every_variable_has_its_unit_and_meaning(run):
    assert set(run.data.data_vars) == set(run.variables) | set(run.cell_variables)
    assert_units(run, run.data)
    assert run.data.sizes["cell"] == len(run.design.vehicle.actuated)


def test_netcdf_brings_back_everything(run, tmp_path):
    path = tmp_path / "run.nc"
    content = run.to_netcdf(path)
    assert path.read_bytes() == content
    again = Run.from_netcdf(path)
    assert again.design == run.design
    assert again.status is run.status
    assert again.events == run.events
    assert again.statistics == run.statistics
    assert again.kernel == run.kernel == KERNEL_HASH
    xr.testing.assert_identical(again.data, run.data)
    assert_units(run, again.data)


def test_netcdf_says_what_it_is(run, tmp_path):
    path = tmp_path / "run.nc"
    run.to_netcdf(path)
    with xr.open_dataset(path, engine="h5netcdf") as stored:
        assert stored.attrs["title"] == run.design.name
        assert stored.attrs["design_identity"] == run.design.identity
        assert json.loads(stored.attrs["design"])["format"] == "glider-design"
        assert_units(run, stored)


def test_csv_reads_back_digit_for_digit(run, tmp_path):
    path = tmp_path / "run.csv"
    run.to_csv(path)
    xr.testing.assert_identical(Run.read_csv(path), run.data)
    with pytest.raises(ValueError, match="first column"):
        (tmp_path / "other.csv").write_text("a,b\n1,2\n")
        Run.read_csv(tmp_path / "other.csv")


def test_writing_a_file_leaves_the_run_as_it_was(run):
    before = run.data.copy(deep=True)
    run.to_netcdf()
    run.to_csv()
    xr.testing.assert_identical(run.data, before)


def test_a_file_of_something_else_is_refused(tmp_path):
    path = tmp_path / "other.nc"
    xr.Dataset({"a": ("t", [1.0])}).to_netcdf(path, engine="h5netcdf")
    with pytest.raises(ValueError, match="not a run of the glider studio: it lacks design, events"):
        Run.from_netcdf(path)


def test_csv_brings_back_every_number(run, tmp_path):
    path = tmp_path / "run.csv"
    content = run.to_csv(path)
    assert path.read_text() == content
    header, *rows = csv.reader(io.StringIO(content))
    numbers = np.array(rows, dtype=float)
    assert len(header) == numbers.shape[1] == 1 + len(run.variables) + len(run.cell_variables) * len(run.data["cell"])
    assert header[0] == "t [s]"
    np.testing.assert_allclose(numbers[:, 0], run.data["time"], rtol=1e-11)
    for k, (name, (unit, _)) in enumerate(run.variables.items(), start=1):
        assert header[k] == f"{name} [{unit}]"
        np.testing.assert_allclose(numbers[:, k], run.data[name], rtol=1e-11, atol=1e-300)


def test_names_with_commas_and_quotes_survive_csv():
    name = 'Cell "1", front'
    run = simulate(parse_design(document(PISTON | {"name": name}, duration=0.2)))
    header = next(csv.reader(io.StringIO(run.to_csv())))
    assert f"extension of {name} [m]" in header


def test_a_run_without_moving_parts_has_files_too(tmp_path):
    changed = document(duration=0.2)
    changed["vehicle"]["components"] = changed["vehicle"]["components"][:1]
    run = simulate(parse_design(changed))
    assert run.data.sizes["cell"] == 0
    path = tmp_path / "run.nc"
    run.to_netcdf(path)
    assert Run.from_netcdf(path).data.sizes["cell"] == 0
    assert len(run.to_csv().splitlines()) == len(run.data["time"]) + 1


@settings(max_examples=10)
@given(designs())
def test_outputs_are_consistent_with_the_states(design):
    d = simulate(design).data
    s, c = np.sin(d["theta"]), np.cos(d["theta"])
    np.testing.assert_allclose(d["x_dot"], c * d["u"] + s * d["w"], rtol=0, atol=1e-14)
    np.testing.assert_allclose(d["z_dot"], -s * d["u"] + c * d["w"], rtol=0, atol=1e-14)
    np.testing.assert_allclose(d["speed"], np.hypot(d["u"], d["w"]), rtol=1e-14)
    np.testing.assert_allclose(d["alpha"], np.arctan2(d["w"], d["u"]), rtol=0, atol=1e-14)
    np.testing.assert_allclose(d["flow_angle"], np.arctan2(d["z_dot"], d["x_dot"]), rtol=0, atol=1e-12)
    turned = np.mod(d["flow_angle"] + d["theta"] - d["alpha"] + np.pi, 2 * np.pi) - np.pi
    moving = d["speed"] > 0.0  # at rest the flow has no direction
    assert np.abs(turned.where(moving, 0.0)).max() <= 1e-12  # Eq. 11 with atan2, wrapped
    environment = design.mission.environment
    net = gravity_of(environment) * environment.water.density * d["volume"].sum("cell")
    rigid = sum(part.volume for part in design.vehicle.components if part.kind == "rigid")
    changes = d["net_buoyancy"] - net
    np.testing.assert_allclose(changes, changes[0], rtol=0, atol=1e-12)
    assert rigid >= 0.0


def test_the_last_sample_is_the_final_state(run):
    assert run.final["t"] == float(run.data["time"][-1])
    assert run.final["z"] == float(run.data["z"][-1])


def test_statistics_count_the_work(run):
    s = run.statistics
    assert s["steps"] > 0 and s["elapsed"] > 0.0
    # six evaluations a step tried, and one at the start of each segment
    assert s["evaluations"] >= 6 * (s["steps"] + s["rejected_steps"])


@pytest.mark.parametrize("status", Status)
def test_every_status_says_what_happened_in_a_sentence(status):
    assert status.value.endswith(".") and len(status.value) > 20
    # one that ends early also says what to try or what is kept
    assert status is Status.completed or ";" in status.value or "kept" in status.value


def test_events_read_as_sentences():
    assert str(Event(1.0, "bed")) == "the glider reached the bed at 1.000 s"
    assert str(Event(2.5, "end_of_stroke", "Front")) == "Front reached a stop at 2.500 s"


def test_events_survive_the_file(tmp_path):
    control = schedule("Piston", (0.5, 0.01), (1.0, -0.01))
    run = simulate(parse_design(document(control=control, duration=2.0)))
    path = tmp_path / "run.nc"
    run.to_netcdf(path)
    assert Run.from_netcdf(path).events == run.events
    assert [event.cell for event in run.events] == ["Piston", "Piston"]
