"""A user's own water and currents: CSV and NetCDF read alike, and refused with file, line and column otherwise."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr

from models.problems import DesignError
from models.profile_files import read_current_profile, read_density_profile, read_water_profile

DEPTHS = (0.5, 4.0, 10.0, 30.0)
TEMPERATURES = (21.0, 20.5, 12.25, 6.0)
SALINITIES = (0.1, 0.1, 0.15, 0.2)
CTD = [
    "depth,temperature,salinity",
    *(f"{z},{t},{s}" for z, t, s in zip(DEPTHS, TEMPERATURES, SALINITIES, strict=True)),
]
NORTH = ((0.3, 0.2, 0.1, 0.0), (0.1, 0.1, 0.05, -0.2))
EAST = ((0.0, 0.0, 0.1, 0.1), (-0.1, -0.2, 0.0, 0.4))
CURRENT = [
    "time,depth,north,east",
    *(f"{60 * k},{z},{NORTH[k][i]},{EAST[k][i]}" for k in range(2) for i, z in enumerate(DEPTHS)),
]


def written(tmp_path, rows, name="cast.csv"):
    path = tmp_path / name
    path.write_text("\n".join(rows), encoding="utf-8")
    return path


def saved(tmp_path, dataset, name="cast.nc"):
    path = tmp_path / name
    dataset.to_netcdf(path, engine="h5netcdf")
    return path


def cast(**attributes):
    variables = {"temperature": ("depth", list(TEMPERATURES)), "salinity": ("depth", list(SALINITIES))}
    return xr.Dataset(variables, coords={"depth": list(DEPTHS)}, attrs=attributes)


def water(path, **fields):
    return read_water_profile(path, **({"latitude": 47.5} | fields))


def problem(call, *arguments, **fields):
    with pytest.raises(DesignError) as caught:
        call(*arguments, **fields)
    return str(caught.value)


def test_columns_and_fields_are_read_in_any_order_of_rows(tmp_path):
    shuffled = [CTD[0] + ",oxygen", *(f"{row},bad" for row in (CTD[3], CTD[1], CTD[4], CTD[2]))]
    profile = water(written(tmp_path, shuffled), longitude=9.0, salinity_kind="absolute", source="buoy 3")
    assert (profile.depths, profile.temperatures, profile.salinities) == (DEPTHS, TEMPERATURES, SALINITIES)
    assert (profile.latitude, profile.longitude, profile.salinity_kind) == (47.5, 9.0, "absolute")
    assert profile.source == "buoy 3"


@pytest.mark.parametrize(
    ("header", "kind"),
    [
        ("depth (m),temperature [degC],salinity (PSU)", "practical"),
        ("depth[m],temperature (°C),salinity", "absolute"),
        ("depth [ metres ] ,temperature (degree_Celsius),salinity [g/kg]", "absolute"),
    ],
)
def test_columns_may_carry_the_unit_that_is_read(tmp_path, header, kind):
    plain = water(written(tmp_path, CTD), salinity_kind=kind)
    assert water(written(tmp_path, [header, *CTD[1:]], "units.csv"), salinity_kind=kind) == plain


@pytest.mark.parametrize(
    ("header", "says"),
    [
        ("depth (ft),temperature,salinity", "cast.csv: column depth is in 'ft', wanted is m (convert it"),
        ("depth,temperature [K],salinity", "column temperature is in 'K', wanted is degC"),
        ("depth,temperature,salinity (g/kg)", "column salinity is in 'g/kg', wanted is 1"),
        ("depth,depth (m),temperature", "has the columns depth more than once"),
    ],
)
def test_another_unit_in_the_header_is_refused_by_name(tmp_path, header, says):
    assert says in problem(water, written(tmp_path, [header, *CTD[1:]]))


def test_a_column_in_another_unit_is_left_alone_beside_the_one_that_is_meant(tmp_path):
    rows = ["depth (m),temperature,depth (ft)", "0,20,0", "10,9,32.8"]
    assert water(written(tmp_path, rows)).depths == (0.0, 10.0)


def test_without_salinity_the_water_is_fresh(tmp_path):
    path = written(tmp_path, ["\ufeffdepth , temperature", "0,20", "", "5,10", " , "])
    profile = water(path)
    assert profile.salinities is None and profile.depths == (0.0, 5.0)


def test_csv_and_netcdf_give_the_same_profile(tmp_path):
    assert water(saved(tmp_path, cast())) == water(written(tmp_path, CTD))


def test_density_from_csv_and_netcdf(tmp_path):
    rows = ["density,depth", "1001.5,10", "1000,0"]
    profile = read_density_profile(written(tmp_path, rows), source="made up")
    assert (profile.depths, profile.densities, profile.source) == ((0.0, 10.0), (1000.0, 1001.5), "made up")
    dataset = xr.Dataset(
        {"rho": ("level", [1000.0, 1001.5], {"standard_name": "sea_water_density", "units": "kg m-3"})},
        coords={"depth": ("level", [0.0, 10.0])},
    )
    assert read_density_profile(saved(tmp_path, dataset), source="made up") == profile


def test_standard_names_and_a_coordinate_upward(tmp_path):
    dataset = xr.Dataset(
        {
            "TEMP": (
                "z",
                list(TEMPERATURES[::-1]),
                {"standard_name": "sea_water_temperature", "units": "degree_Celsius"},
            ),
            "PSAL": ("z", list(SALINITIES[::-1]), {"standard_name": "sea_water_practical_salinity", "units": "1"}),
        },
        coords={"z": ("z", [-z for z in DEPTHS[::-1]], {"positive": "up", "units": "m"})},
    )
    assert water(saved(tmp_path, dataset)) == water(written(tmp_path, CTD))
    named = dataset.rename(z="height").assign_coords(height=("height", dataset.z.values, {"standard_name": "height"}))
    assert water(saved(tmp_path, named, "height.nc")) == water(written(tmp_path, CTD))
    down = dataset.assign_coords(z=("z", list(DEPTHS[::-1]), {"positive": "down"}))
    assert water(saved(tmp_path, down, "down.nc")) == water(written(tmp_path, CTD))


def test_the_kind_of_salinity_is_that_of_the_standard_name(tmp_path):
    dataset = cast()
    dataset.salinity.attrs["standard_name"] = "sea_water_absolute_salinity"
    assert water(saved(tmp_path, dataset)).salinity_kind == "absolute"
    dataset.salinity.attrs["standard_name"] = "sea_water_practical_salinity"
    assert water(saved(tmp_path, dataset, "other.nc"), salinity_kind="absolute").salinity_kind == "practical"


def test_latitude_and_longitude_of_the_file_are_taken_unless_given(tmp_path):
    by_attribute = read_water_profile(saved(tmp_path, cast(latitude=47.25, lon=9.5)))
    assert (by_attribute.latitude, by_attribute.longitude) == (47.25, 9.5)
    path = saved(tmp_path, cast().assign_coords(lat=-12.0, longitude=("x", [170.5])), "scalar.nc")
    by_variable = read_water_profile(path)
    assert (by_variable.latitude, by_variable.longitude) == (-12.0, 170.5)
    given = read_water_profile(path, latitude=3.0, longitude=4.0)
    assert (given.latitude, given.longitude) == (3.0, 4.0)
    for path in (written(tmp_path, CTD), saved(tmp_path, cast(), "nowhere.nc")):
        assert "no latitude (give latitude" in problem(read_water_profile, path)


def test_a_profile_among_axes_of_one_entry_is_read_and_several_are_refused(tmp_path):
    one = cast().expand_dims(time=[0.0], station=["A"])
    assert water(saved(tmp_path, one)) == water(written(tmp_path, CTD))
    two = xr.concat([cast(), cast()], dim="station")
    assert "temperature varies along station (2)" in problem(water, saved(tmp_path, two, "two.nc"))


def test_levels_without_any_value_are_left_out_and_half_empty_ones_refused(tmp_path):
    rows = [*CTD, "40,,", "50,nan,nan"]
    assert water(written(tmp_path, rows)) == water(written(tmp_path, CTD, "whole.csv"))
    dataset = cast()
    dataset.temperature[3] = dataset.salinity[3] = np.nan
    assert water(saved(tmp_path, dataset)).depths == DEPTHS[:3]
    dataset.salinity[1] = np.nan
    assert "depth[1], column salinity: no number (1 such rows)" in problem(water, saved(tmp_path, dataset, "gap.nc"))


@pytest.mark.parametrize(
    ("rows", "says"),
    [
        ([], "cast.csv is empty (give a header with depth, temperature"),
        (CTD[:1], "cast.csv: no row has a number"),
        (
            ["depth,temp", "1,2"],
            "cast.csv lacks the columns temperature (wanted are depth, temperature; its header has depth, temp)",
        ),
        (["depth,temperature,depth", "1,2,3"], "has the columns depth more than once"),
        ([*CTD[:2], "4,warm,0.1"], "cast.csv, line 3, column temperature: 'warm' is not a number"),
        ([*CTD[:2], "", "4,inf,0.1"], "cast.csv, line 4, column temperature: 'inf' is not finite"),
        ([*CTD[:3], "10,nan,0.1"], "cast.csv: line 4, column temperature: no number"),
        ([*CTD[:3], "10,9"], "cast.csv: line 4, column salinity: no number"),
        ([*CTD[:3], ",9,0.1"], "cast.csv: line 4, column depth: no number"),
        ([*CTD[:3], "10,5,9,0.1"], "cast.csv, line 4: 4 cells under a header of 3 (separate cells by commas"),
        ([*CTD, "4,20,0.1"], "cast.csv: given more than once: depth 4 (line 3 and line 6) (1 in all)"),
        ([*CTD, "50,60,0.1"], "/temperatures/4: cast.csv: Input should be less than or equal to 40, not 60"),
        ([*CTD, "-1,20,0.1"], "/depths/0: cast.csv: Input should be greater than or equal to 0, not -1"),
        (CTD[:2], "cast.csv: Tuple should have at least 2 items"),
    ],
)
def test_what_is_no_profile_is_refused_with_its_place(tmp_path, rows, says):
    assert says in problem(water, written(tmp_path, rows))


@pytest.mark.parametrize(
    ("name", "attributes", "says"),
    [
        ("temperature", {"standard_name": "sea_water_potential_temperature"}, "wanted is sea_water_temperature"),
        ("temperature", {"units": "K"}, "temperature is in 'K', wanted is degC"),
        ("depth", {"units": "dbar"}, "depth is in 'dbar', wanted is m"),
        ("depth", {"positive": "up"}, "greater than or equal to 0"),
    ],
)
def test_a_netcdf_of_other_quantities_or_units_is_refused(tmp_path, name, attributes, says):
    dataset = cast()
    dataset[name].attrs.update(attributes)
    assert says in problem(water, saved(tmp_path, dataset))


def test_files_of_another_kind_are_refused(tmp_path):
    assert "cast.nc cannot be read as NetCDF-4" in problem(water, written(tmp_path, CTD, "cast.nc"))
    path = tmp_path / "cast.csv"
    path.write_bytes(b"depth,temperature\n1,2\xff")
    assert "cast.csv is not a CSV in UTF-8" in problem(water, path)
    says = problem(water, saved(tmp_path, cast().drop_vars("temperature"), "bare.nc"))
    assert "bare.nc lacks the variables temperature (it has " in says and "CF standard names are read too" in says
    words = cast().assign(temperature=("depth", ["a", "b", "c", "d"]))
    assert "variable temperature: " in problem(water, saved(tmp_path, words, "words.nc"))
    with pytest.raises(FileNotFoundError):
        water(tmp_path / "absent.nc")


def test_two_variables_of_one_standard_name_are_refused(tmp_path):
    dataset = cast().rename(temperature="up").assign(down=("depth", list(TEMPERATURES)))
    for name in ("up", "down"):
        dataset[name].attrs["standard_name"] = "sea_water_temperature"
    says = problem(water, saved(tmp_path, dataset))
    assert "temperature may be any of" in says and "rename the one that is meant" in says


def test_currents_in_time_from_csv_and_netcdf(tmp_path):
    current = read_current_profile(written(tmp_path, [CURRENT[0], *reversed(CURRENT[1:])]))
    assert (current.depths, current.times, current.north, current.east) == (DEPTHS, (0.0, 60.0), NORTH, EAST)
    variables = {
        "u": (("depth", "time"), np.array(EAST).T, {"standard_name": "eastward_sea_water_velocity", "units": "m s-1"}),
        "v": (("time", "depth"), np.array(NORTH), {"standard_name": "northward_sea_water_velocity", "units": "m/s"}),
    }
    dates = np.array(["2024-05-01T10:00:00", "2024-05-01T10:01:00"], dtype="datetime64[ns]")
    for k, times in enumerate((("time", [0.0, 60.0], {"units": "s"}), ("time", dates))):
        dataset = xr.Dataset(variables, coords={"depth": list(DEPTHS), "time": times})
        assert read_current_profile(saved(tmp_path, dataset, f"adcp{k}.nc")) == current


def test_a_steady_current_has_one_profile(tmp_path):
    current = read_current_profile(written(tmp_path, ["depth,north,east", "5,0.1,0", "0,0.3,-0.2"]), source="ADCP")
    assert (current.depths, current.times) == ((0.0, 5.0), (0.0,))
    assert (current.north, current.east, current.source) == (((0.3, 0.1),), ((-0.2, 0.0),), "ADCP")


def test_a_hole_and_a_doubled_sample_of_a_current_are_named(tmp_path):
    says = problem(read_current_profile, written(tmp_path, [*CURRENT[:6], *CURRENT[7:]]))
    assert "missing: time 60, depth 4 (1 in all)" in says
    says = problem(read_current_profile, written(tmp_path, [*CURRENT, CURRENT[2]]))
    assert "given more than once: time 0, depth 4 (line 3 and line 10) (1 in all)" in says
    scattered = [CURRENT[0], *(f"{k},{k},0.1,0.1" for k in range(20))]
    says = problem(read_current_profile, written(tmp_path, scattered))
    assert "missing: time 0, depth 1; time 0, depth 2" in says and "; ... (380 in all)" in says
