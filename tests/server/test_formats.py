"""Files of results, read back by other programs' readers: every number to the last bit, every text as it was."""

from __future__ import annotations

import csv
import errno
import io
import json
import os
import shutil
import subprocess
import sys
import time

import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
import xarray as xr
from scipy.io import loadmat

from models.variables import VARIABLES
from server.jobs import formats, matlab, netcdf
from server.jobs.case_table import CaseRow
from server.jobs.column_names import plain_names
from server.jobs.files import DiskFullError, JobFiles
from server.jobs.matlab import TooLargeError, write_matlab
from server.jobs.results import LostResultsError, Results
from server.jobs.task import ColumnInfo
from tests.server.results_support import (
    COLUMNS,
    METRICS,
    PARAMETERS,
    REASON,
    add_trajectories,
    case_row,
    example_run,
    made_up,
    write_chunks,
)

CASES = [k for k in range(100) if k // 8 not in {3, 4} and k < 90]
NUMERIC = [column.name for column in COLUMNS if column.numeric]
ABOUT = {"title": "Länge", "job": "job", "design": {"name": "a"}, "cases": 90}


@pytest.fixture
def results(tmp_path):
    """Results with failures, a gap and an early stop within a chunk."""
    return made_up(tmp_path, without={3, 4}, counted=90)


def numbers(name):
    """Return what a column of numbers holds, NaN for nothing."""
    place = NUMERIC.index(name)
    rows = [case_row(k) for k in CASES]
    table = [[v for v, c in zip(row.values, COLUMNS, strict=False) if c.numeric] + list(row.metrics) for row in rows]
    return np.array([values[place] for values in table])


def texts(name):
    rows = [case_row(k) for k in CASES]
    if name == "method":
        return [json.dumps(row.values[3]) for row in rows]
    return [getattr(row, name) for row in rows]


def same(values, name):
    """Whether numbers are those of the column bit by bit, wherever there is one."""
    given, wanted = np.asarray(values, dtype=np.float64).ravel(), numbers(name)
    missing = np.isnan(wanted)
    return (np.isnan(given) == missing).all() and given[~missing].tobytes() == wanted[~missing].tobytes()


def test_json(results):
    content = json.loads(b"".join(formats.stream_json(results)), parse_constant=pytest.fail)
    assert list(content) == ["columns", "units"]
    columns = content["columns"]
    assert list(columns) == ["case", "status", "reason", *PARAMETERS, *METRICS]
    assert columns["case"] == CASES and columns["status"] == texts("status") and columns["reason"] == texts("reason")
    assert columns["method"] == [case_row(k).values[3] for k in CASES]
    for name in NUMERIC:
        assert same([np.nan if value is None else value for value in columns[name]], name)
    assert content["units"]["range"] == "m" and "method" not in content["units"]


def test_csv(results):
    content = b"".join(formats.stream_csv(results)).decode()
    header, *rows = csv.reader(io.StringIO(content, newline=""), strict=True)
    assert header == [
        "case", "status", "reason", "Front bellows position x [m]", "'=cmd|'/c calc'!A1 [kg]", 'odd, "quoted" [1]',
        "method", "Länge ☃ [m]", "range [m]", "x [m/s]", "end",
    ]  # fmt: skip
    assert {len(row) for row in rows} == {len(header)}
    columns = dict(zip(["case", "status", "reason", *PARAMETERS, *METRICS], zip(*rows, strict=True), strict=True))
    assert list(columns["case"]) == [str(case) for case in CASES]
    assert list(columns["reason"]) == [reason or "" for reason in texts("reason")]
    assert list(columns["method"]) == texts("method")
    for name in NUMERIC:
        assert same([float(value) if value else np.nan for value in columns[name]], name)
    # RFC 4180: lines end with CR LF, and a line break within quotes stays what it is
    assert content.count("\r\n") == len(CASES) + 1 and REASON.replace('"', '""') in content


def test_csv_read_by_pandas(results):
    table = pd.read_csv(io.BytesIO(b"".join(formats.stream_csv(results))))
    assert same(table["range [m]"], "range") and same(table["Länge ☃ [m]"], "Länge ☃")


@pytest.mark.parametrize("begin", list("=+-@\t\r"))
def test_no_spreadsheet_computes_a_cell(tmp_path, begin):
    columns = [ColumnInfo(f"{begin}SUM(A1)", "m", "", "parameter"), ColumnInfo("range", "m", "", "metric")]
    row = CaseRow(0, "refused", f"{begin}HYPERLINK()", [-1.5], [-2.5])
    content = b"".join(formats.stream_csv(write_chunks(tmp_path, [row], size=1, columns=columns))).decode()
    header, cells = csv.reader(io.StringIO(content, newline=""))
    assert header[3] == f"'{begin}SUM(A1) [m]"
    assert cells[2:] == [f"'{begin}HYPERLINK()", "-1.5", "-2.5"]  # a negative number is no formula


def test_parquet(results):
    path = formats.parquet_file(results, ABOUT)
    table = pq.read_table(path)
    assert table.equals(pa.Table.from_batches(list(results.batches())))
    assert all(table.schema.field(own.name).equals(own, check_metadata=True) for own in results.schema)
    about = {name.decode(): value.decode() for name, value in table.schema.metadata.items()}
    assert about == ABOUT | {"design": '{"name": "a"}', "cases": "90"}
    assert table.schema.field("range").metadata == {b"unit": b"m", b"meaning": b"distance", b"role": b"metric"}
    frame = pd.read_parquet(path)
    assert frame["case"].tolist() == CASES and frame["method"].tolist() == texts("method")
    for name in NUMERIC:
        assert same(frame[name], name)


def test_netcdf_without_trajectories(results):
    path = formats.netcdf_file(results, ABOUT)
    names = netcdf.column_names(results)
    with xr.open_dataset(path, engine="h5netcdf", decode_times=False) as data:
        assert data.attrs == {"Conventions": "CF-1.11", **ABOUT, "design": '{"name": "a"}'}
        assert dict(data.sizes) == {"case": len(CASES)} and "row_size" not in data
        assert "cf_role" not in data["case"].attrs, "there is no trajectory that a case could name"
        assert data["case"].values.tolist() == CASES and data["status"].values.tolist() == texts("status")
        assert data["reason"].values.tolist() == [reason or "" for reason in texts("reason")]
        assert data[names["method"]].values.tolist() == texts("method")
        for column in COLUMNS:
            variable = data[names[column.name]]
            assert variable.attrs["long_name"] == column.name and variable.attrs["role"] == column.role
            assert variable.attrs.get("comment", "") == column.meaning
            if column.numeric:
                assert same(variable.values, column.name) and variable.attrs["units"] == (column.unit or "1")


def test_names_of_netcdf_variables_are_those_of_the_conventions(results):
    names = netcdf.column_names(results)
    assert names["Front bellows position x"] == "Front_bellows_position_x" and names["Länge ☃"] == "Lange"
    assert names["x"] == "x_2"  # x is where a trajectory goes
    assert all(name.isidentifier() and name.isascii() for name in names.values())


LENGTHS = {1: 50, 2: 1, 40: 1301, 41: 7, 88: 12, 89: 3, 90: 400}
"""Samples of the cases that keep trajectories: all of a run, one, some in the chunk in which an early stop cuts."""


@pytest.mark.parametrize("preset_id", ["three-cell-glider", "quad-bellows-spiral"])
def test_netcdf_with_trajectories(results, preset_id, monkeypatch):
    monkeypatch.setattr(netcdf, "ROWS_AT_ONCE", 100)
    run = example_run(preset_id)
    lengths = {case: min(length, len(run.times)) for case, length in LENGTHS.items()}
    add_trajectories(results, lengths, run)
    with xr.open_dataset(formats.netcdf_file(results, ABOUT), engine="h5netcdf", decode_times=False) as data:
        counted = {case: length for case, length in lengths.items() if case < 90}
        assert data.attrs["featureType"] == "trajectory" and data["case"].attrs["cf_role"] == "trajectory_id"
        assert data["row_size"].attrs["sample_dimension"] == "obs"
        assert data["row_size"].values.tolist() == [counted.get(case, 0) for case in CASES]
        assert dict(data.sizes) == {"case": len(CASES), "obs": sum(counted.values()), "cell": len(run.cells)}
        assert data["cell"].values.tolist() == list(run.cells)
        assert same(data[netcdf.column_names(results)["range"]].values, "range")
        end = 0
        for length in counted.values():
            part, end = data.isel(obs=slice(end, end + length)), end + length
            assert part["time"].values.tobytes() == run.times[:length].tobytes()
            for name, (unit, meaning) in run.variables.items():
                np.testing.assert_array_equal(part[name].values, run.values[name][:length])
                assert data[name].attrs["units"] == unit and data[name].attrs["long_name"] == meaning
            for name in run.cell_variables:
                np.testing.assert_array_equal(part[name].values, run.cell_values[name][:length])
        assert data["z"].attrs["standard_name"] == "depth" and data["z"].attrs["positive"] == "down"
        assert set(data.coords) >= {"time", "x", "z", "case", "cell"}  # the conventions' auxiliary coordinates


def test_trajectories_of_unlike_models_and_cells_share_a_file(results):
    planar, spatial = example_run(), example_run("quad-bellows-spiral")
    add_trajectories(results, {0: 5}, planar)
    add_trajectories(results, {50: 4}, spatial)
    with xr.open_dataset(formats.netcdf_file(results, {}), engine="h5netcdf", decode_times=False) as data:
        assert data["cell"].values.tolist() == list(dict.fromkeys([*planar.cells, *spatial.cells]))
        assert np.isnan(data["phi"].values[:5]).all()
        assert data["phi"].values[5:].tobytes() == spatial.values["phi"][:4].tobytes()
        table = data["volume"].sel(cell=list(spatial.cells)).values
        np.testing.assert_array_equal(table[5:], spatial.cell_values["volume"][:4])
        only = [k for k, cell in enumerate(data["cell"].values) if cell not in spatial.cells]
        assert only and np.isnan(data["volume"].values[5:, only]).all()
    assert set(VARIABLES["planar"]) < set(VARIABLES["spatial"])


def test_trajectories_that_an_early_stop_leaves_out(tmp_path):
    results = made_up(tmp_path, counted=10)
    add_trajectories(Results(results.files, cases=100, chunk_size=8), {12: 5, 40: 5}, example_run())
    with xr.open_dataset(formats.netcdf_file(results, {}), engine="h5netcdf", decode_times=False) as data:
        assert dict(data.sizes) == {"case": 10} and "featureType" not in data.attrs


def test_matlab(results):
    path = formats.mat_file(results, ABOUT)
    assert path.read_bytes()[:19] == b"MATLAB 5.0 MAT-file"
    content = loadmat(path, simplify_cells=True)
    names = matlab.variable_names(results)
    assert set(content) == {"__header__", "__version__", "__globals__", *names.values(), *matlab.STRUCTS}
    assert content["case_number"].tolist() == CASES
    for name in ("status", "reason", "method"):
        told = content[names[name]]
        values = [None, *np.atleast_1d(told["values"]).tolist()]
        assert [values[int(code)] for code in told["code"]] == texts(name)
    for name in NUMERIC:
        assert same(content[names[name]], name)
    assert {content["names"][plain]: plain for plain in content["names"]} == names
    assert content["units"][names["range"]] == "m" and content["meanings"][names["Länge ☃"]] == "größte Länge"
    assert content["about"] == {"title": "Länge", "job": "job", "design": '{"name": "a"}', "cases": "90"}


def test_matlab_vectors_are_columns(results):
    assert loadmat(formats.mat_file(results, {}))["range"].shape == (len(CASES), 1)


def test_matlab_names_are_no_words_of_the_language(results):
    names = matlab.variable_names(results)
    assert names["case"] == "case_number" and names["end"] == "end_2"
    assert names["=cmd|'/c calc'!A1"] == "cmd_c_calc_A1" and names['odd, "quoted"'] == "odd_quoted"


def test_matlab_refuses_what_its_format_cannot_hold(results, tmp_path):
    with pytest.raises(TooLargeError, match=r"holds up to 6000 bytes.*Parquet or NetCDF"):
        write_matlab(results, tmp_path / "a.mat", {}, largest=6000)
    path = tmp_path / "b.mat"
    with pytest.raises(TooLargeError):  # texts count too
        write_matlab(results, path, {}, largest=8 * len(CASES) * (len(COLUMNS) + 3))


def test_plain_names():
    given = ["a b", "a_b", "A-B", "a__b", "1st", "☃", "é", "x" * 90, "x" * 91, "_", "case"]
    plain = plain_names(given, longest=63, taken=("case",))
    assert list(plain) == given and plain["1st"] == "column_1st" and plain["case"] == "case_2"
    assert [plain[name] for name in given[:4]] == ["a_b", "a_b_2", "A_B_3", "a_b_4"]
    assert len({name.lower() for name in plain.values()}) == len(given)
    assert all(len(name) <= 63 and name.isidentifier() and name.isascii() for name in plain.values())


def test_a_job_of_which_nothing_is_done_has_empty_files(tmp_path):
    results = Results(JobFiles(tmp_path, "job"), cases=5, chunk_size=2)
    paths = [formats.parquet_file(results, ABOUT), formats.netcdf_file(results, {}), formats.mat_file(results, {})]
    assert pq.read_table(paths[0]).schema.names == ["case", "status", "reason"]
    with xr.open_dataset(paths[1], engine="h5netcdf") as data:
        assert dict(data.sizes) == {"case": 0}
    assert loadmat(paths[2])["case_number"].size == 0
    for path in paths:
        path.unlink()


def test_streams_of_a_job_of_which_nothing_is_done(tmp_path):
    results = Results(JobFiles(tmp_path, "job"), cases=5, chunk_size=2)
    assert b"".join(formats.stream_csv(results)) == b"case,status,reason\r\n"
    empty = json.loads(b"".join(formats.stream_json(results)))
    assert empty == {"columns": {"case": [], "status": [], "reason": []}, "units": {"case": "1"}}


def test_a_chunk_that_comes_after_the_header_waits_for_the_next_download(tmp_path):
    results = Results(JobFiles(tmp_path, "job"), cases=100, chunk_size=8)
    lines = formats.stream_csv(results)
    assert next(lines) == b"case,status,reason\r\n"
    made_up(tmp_path)
    assert list(lines) == []


def downloads(results):
    return list(results.files.folder.glob("download-*"))


def test_a_file_is_gone_once_it_is_sent_or_the_client_has_left(results):
    path = formats.parquet_file(results, ABOUT)
    content = path.read_bytes()
    assert path.parent == results.files.folder and downloads(results) == [path]
    assert b"".join(formats.file_blocks(path)) == content and downloads(results) == []
    left = formats.file_blocks(formats.parquet_file(results, ABOUT))
    next(left)
    left.close()
    assert downloads(results) == []


def test_nothing_is_left_of_a_file_that_cannot_be_written(results, monkeypatch):
    def full(*_):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    with monkeypatch.context() as patch:
        patch.setattr(os, "posix_fallocate", full)
        with pytest.raises(DiskFullError, match=r"the disk is full.*take CSV"):
            formats.netcdf_file(results, {})
    results.files.path(11).write_bytes(b"nonsense")
    for make in (lambda r: formats.parquet_file(r, {}), lambda r: formats.mat_file(r, {})):
        with pytest.raises(Exception, match="cannot be read"):
            make(results)
    assert downloads(results) == []


def test_netcdf_where_room_cannot_be_taken_but_looked_for(results, monkeypatch):
    monkeypatch.delattr(os, "posix_fallocate")
    with xr.open_dataset(formats.netcdf_file(results, {}), engine="h5netcdf") as data:
        assert data["case"].values.tolist() == CASES
    usage = shutil.disk_usage(results.files.folder)
    monkeypatch.setattr(shutil, "disk_usage", lambda _: usage._replace(free=10_000))
    with pytest.raises(DiskFullError):
        formats.netcdf_file(results, {})


FULL_DISK = """
import resource, sys
from pathlib import Path
from server.jobs import formats
from server.jobs.files import DiskFullError, JobFiles
from server.jobs.results import LostResultsError, Results

results = Results(JobFiles(Path(sys.argv[1]), "job"), cases=400, chunk_size=8)
resource.setrlimit(resource.RLIMIT_FSIZE, (int(sys.argv[2]),) * 2)
for make in (formats.parquet_file, formats.netcdf_file, formats.mat_file):
    try:
        make(results, {})
    except DiskFullError:
        print("refused")
"""


@pytest.mark.parametrize("bound", [100, 5000, 20_000])
def test_a_disk_that_is_full_is_an_error_and_no_crash(tmp_path, bound):
    results = made_up(tmp_path, 400)
    command = [sys.executable, "-c", FULL_DISK, str(tmp_path), str(bound)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120, check=True)
    assert done.stdout.split() == ["refused"] * 3 and done.stderr == ""
    assert downloads(results) == []


def test_a_job_that_is_deleted_meanwhile_is_told(results, monkeypatch):
    room = netcdf._take_room

    def deleting(path, size):
        room(path, size)
        results.files.remove()

    monkeypatch.setattr(netcdf, "_take_room", deleting)
    with pytest.raises(LostResultsError, match="deleted meanwhile"):
        formats.netcdf_file(results, {})


def test_texts_of_any_language_reach_matlab(tmp_path):
    columns = [ColumnInfo("größe 🌊", "m", "Länge 深さ", "parameter"), ColumnInfo("range", "m", "", "metric")]
    row = CaseRow(0, "refused", "🌊 深さ", [1.0], [2.0])
    results = write_chunks(tmp_path, [row], size=1, columns=columns)
    content = loadmat(formats.mat_file(results, {"title": "深さ"}), simplify_cells=True)
    assert content["names"]["groe"] == "größe 🌊" and content["meanings"]["groe"] == "Länge 深さ"
    assert content["about"]["title"] == "深さ" and content["reason"]["values"] == "🌊 深さ"


def test_files_that_a_killed_server_left_are_removed(results):
    old, new = (results.files.folder / f"download-{name}.nc" for name in ("old", "new"))
    for path in (old, new):
        path.write_bytes(b"")
    os.utime(old, (time.time() - 1e6,) * 2)
    formats.parquet_file(results, ABOUT).unlink()
    assert downloads(results) == [new]
