"""The water as the kernel reads it: TEOS-10's own numbers, hydrostatics, what holds beyond the profile, currents."""

from __future__ import annotations

import gsw
import numpy as np
import pytest
from scipy.integrate import quad

from models.environment import (
    DensityProfile,
    Environment,
    ShearedCurrent,
    TabulatedCurrent,
    Teos10Water,
    UniformCurrent,
    UniformWater,
)
from models.problems import DesignError
from models.water import (
    current_table,
    density_at,
    gravity_of,
    profile_range,
    surface_density,
    unstable_layers,
    water_table,
)

GRAVITY = 9.81
LAKE = Teos10Water(
    kind="teos10",
    depths=(0.5, 5.0, 9.0, 12.0, 20.0, 60.0, 250.0),
    temperatures=(22.0, 21.5, 17.0, 11.0, 6.5, 5.0, 4.6),
    latitude=47.6,
)
OCEAN = Teos10Water(
    kind="teos10",
    depths=(2.0, 30.0, 80.0, 150.0, 400.0, 1000.0, 2000.0),
    temperatures=(24.0, 23.5, 18.0, 15.0, 11.0, 6.0, 3.5),
    salinities=(36.6, 36.6, 36.4, 36.1, 35.5, 35.1, 35.0),
    latitude=32.0,
    longitude=-64.0,
)
STEP = DensityProfile(kind="density_profile", depths=(3.0, 10.0, 11.0, 47.0), densities=(998.0, 998.2, 1003.0, 1003.5))
WATERS = pytest.mark.parametrize("water", [UniformWater(density=1027.0), STEP, LAKE, OCEAN], ids=lambda w: w.kind)
MIXED = pytest.mark.parametrize("mixed", [0.0, 1.5, 10.4, 5000.0])


def row_at(table, z):
    return table.rows[int(np.clip(np.floor((z - table.top) / table.spacing) + 1, 0, len(table.rows) - 1))]


def density_of(table, z):
    z_ref, c0, c1, c2, c3, _ = row_at(table, z)
    h = z - z_ref
    return c0 + c1 * h + c2 * h**2 + c3 * h**3


def pressure_of(table, z, gravity):
    z_ref, c0, c1, c2, c3, reference = row_at(table, z)
    h = z - z_ref
    return reference + gravity * (c0 * h + c1 * h**2 / 2 + c2 * h**3 / 3 + c3 * h**4 / 4)


def direct(water, z):
    """TEOS-10 without a table: the levels' cubics, then the toolbox."""
    from scipy.interpolate import PchipInterpolator

    z = np.minimum(z, water.depths[-1])
    held = np.clip(z, water.depths[0], water.depths[-1])
    pressure = gsw.p_from_z(-z, water.latitude)
    temperature = PchipInterpolator(water.depths, water.temperatures)(held)
    salinity = np.zeros_like(z)
    if water.salinities:
        practical = PchipInterpolator(water.depths, water.salinities)(held)
        salinity = gsw.SA_from_SP(practical, pressure, water.longitude, water.latitude)
    return gsw.rho_t_exact(salinity, temperature, pressure)


def test_published_densities_of_sea_water():
    # The example of the GSW manual for gsw_rho (SA, CT, p), TEOS-10 toolbox 3.06, 75-term polynomial.
    salinity = (34.7118, 34.8915, 35.0256, 34.8472, 34.7366, 34.7324)
    conservative = np.array([28.8099, 28.4392, 22.7862, 10.2262, 6.8272, 4.3236])
    pressure = np.array([10.0, 50.0, 125.0, 250.0, 600.0, 1000.0])
    published = [1021.839935738108, 1022.262457966867, 1024.427195413316, 1027.790152759127, 1029.837779000189, 1032.002453224572]  # fmt: skip  # noqa: E501
    depths = -gsw.z_from_p(pressure, 4.0)
    water = Teos10Water(
        kind="teos10",
        depths=tuple(depths.tolist()),
        temperatures=tuple(gsw.t_from_CT(np.array(salinity), conservative, pressure).tolist()),
        salinities=salinity,
        salinity_kind="absolute",
        latitude=4.0,
    )
    # 2e-3: what 512 to 16384 pieces leave at levels, which are no nodes; see TABULATION_ERROR.
    assert density_at(water, depths) == pytest.approx(published, abs=2e-3)


def test_practical_salinity_takes_the_composition_of_its_sea():
    # The example of the GSW manual for gsw_SA_from_SP at 188 E, 4 N: 34.5487 is 34.711778... g/kg at 10 dbar.
    sea = {"kind": "teos10", "depths": (0.0, 1000.0), "temperatures": (20.0, 20.0), "latitude": 4.0}
    depth = -float(gsw.z_from_p(10.0, 4.0))

    def density(salinity, **more):
        return density_at(Teos10Water(**sea, salinities=(salinity, salinity), **more), depth)

    practical = density(34.5487, longitude=188.0)
    assert practical == pytest.approx(density(34.711778344814114, salinity_kind="absolute"), abs=1e-3)
    reference = density(34.5487)
    assert reference == pytest.approx(density(34.5487 * 35.16504 / 35.0, salinity_kind="absolute"), abs=1e-3)
    assert practical > reference


def test_fresh_water_is_densest_near_4_degrees():
    def density(t):
        return surface_density(Teos10Water(kind="teos10", depths=(0.0, 1.0), temperatures=(t, t), latitude=45.0))

    temperatures = np.arange(0.0, 10.0, 0.1)
    densest = temperatures[np.argmax([density(t) for t in temperatures])]
    assert densest == pytest.approx(3.98, abs=0.06)
    # IAPWS-95 has 999.975 kg/m3; the polynomial of TEOS-10 is made for the sea and is good to some 1e-3 here.
    assert density(3.98) == pytest.approx(999.975, abs=3e-3)


@WATERS
@MIXED
def test_pressure_is_the_weight_of_the_water_above(water, mixed):
    table = water_table(water, GRAVITY, mixed=mixed)
    end = table.top + table.spacing * (len(table.rows) - 2)
    for z in (-1.0, 0.0, 0.7, 10.4, 10.9, 46.0, 300.0, 2100.0):
        kinks = sorted(k for k in {table.top, end, 10.0, 11.0} if 0.0 < k < z)
        total = 0.0
        for a, b in zip([0.0, *kinks], [*kinks, z], strict=True):
            total += quad(lambda s: GRAVITY * density_of(table, s), a, b, epsabs=1e-4, epsrel=1e-10, limit=400)[0]
        assert pressure_of(table, z, GRAVITY) == pytest.approx(total, rel=1e-9, abs=1e-6), z
    assert pressure_of(table, 0.0, GRAVITY) == pytest.approx(0.0, abs=1e-9)


@WATERS
@MIXED
def test_pressure_is_continuous_and_its_slope_is_density_times_gravity(water, mixed):
    table = water_table(water, GRAVITY, mixed=mixed)
    rows = table.rows
    seams = rows[1:, 0]
    for row, seam, following in zip(rows[:-1], seams, rows[1:], strict=True):
        h = seam - row[0]
        below = row[5] + GRAVITY * (row[1] * h + row[2] * h**2 / 2 + row[3] * h**3 / 3 + row[4] * h**4 / 4)
        assert below == pytest.approx(following[5], rel=1e-12, abs=1e-9)
        assert row[1] + h * (row[2] + h * (row[3] + h * row[4])) == pytest.approx(following[1], rel=1e-12)
    step = 1e-3
    for z in (0.3, 7.0, 10.45, 33.3, 500.0):
        slope = (pressure_of(table, z + step, GRAVITY) - pressure_of(table, z - step, GRAVITY)) / (2 * step)
        # Rounding of a pressure of 1e7 Pa over 2 mm, and the curvature of 5 kg/m3 in a metre over it.
        assert slope == pytest.approx(GRAVITY * density_of(table, z), rel=1e-6)


@WATERS
def test_the_kernels_rows_are_writable_ordered_and_its_own(water):
    table = water_table(water, GRAVITY)
    assert table.rows.flags.c_contiguous and table.rows.flags.writeable and table.rows.dtype == np.float64
    before = table.rows.copy()
    table.rows[:] = 0.0
    assert np.array_equal(water_table(water, GRAVITY).rows, before)
    doubled = water_table(water, 2 * GRAVITY).rows
    assert np.array_equal(doubled[:, :5], before[:, :5])
    assert doubled[:, 5] == pytest.approx(2 * before[:, 5], rel=1e-15)


def test_uniform_water_has_no_pieces():
    table = water_table(UniformWater(density=1025.0), GRAVITY, mixed=3.0)
    assert (table.top, table.spacing) == (0.0, 1.0)
    assert np.array_equal(table.rows, [[0.0, 1025.0, 0.0, 0.0, 0.0, 0.0]] * 2)


@pytest.mark.parametrize("water", [LAKE, OCEAN], ids=["lake", "ocean"])
def test_the_table_is_teos10_at_random_depths(water):
    depths = np.random.default_rng(7).uniform(0.0, 1.1 * water.depths[-1], 2000)
    # Half a CTD's 0.003 kg/m3; the exact Gibbs function and the polynomial in use differ by as much.
    assert density_at(water, depths) == pytest.approx(direct(water, depths), abs=2e-3)


def test_a_density_profile_passes_through_its_levels_and_never_beyond_them():
    assert density_at(STEP, np.array(STEP.depths)) == pytest.approx(STEP.densities, abs=1e-3)
    depths = np.linspace(0.0, 60.0, 4001)
    densities = density_at(STEP, depths)
    assert np.all(np.diff(densities) >= -1e-10)
    assert densities.min() >= 998.0 - 1e-9 and densities.max() <= 1003.5 + 1e-9


def test_density_is_held_beyond_the_ends():
    assert density_at(STEP, -5.0) == density_at(STEP, 0.0) == 998.0
    # The level is no node: the cubic about the kink there differs by what a table may (TABULATION_ERROR).
    assert density_at(STEP, 3.0) == pytest.approx(998.0, abs=1e-3)
    assert density_at(STEP, 47.0) == density_at(STEP, 9e3) == pytest.approx(1003.5, abs=1e-9)
    assert density_at(OCEAN, 2000.0) == density_at(OCEAN, 2500.0)
    assert density_at(LAKE, -1.0) == surface_density(LAKE)
    # Above the first level only pressure changes: 0.5 m of water make some 2e-3 kg/m3.
    assert 0.0 < density_at(LAKE, 0.5) - surface_density(LAKE) < 4e-3


@pytest.mark.parametrize("water", [STEP, LAKE, OCEAN], ids=["step", "lake", "ocean"])
def test_the_mixed_layer_has_the_density_found_below_it(water):
    mixed = 10.4
    depths = np.array([-2.0, 0.0, 3.0, 10.399])
    assert np.ptp(density_at(water, depths, mixed=mixed)) == 0.0
    assert density_at(water, 5.0, mixed=mixed) == pytest.approx(density_at(water, mixed), abs=1e-3)
    below = np.array([10.5, 20.0, 46.0, 3000.0])
    assert density_at(water, below, mixed=mixed) == pytest.approx(density_at(water, below), abs=2e-3)
    assert water_table(water, GRAVITY, mixed=-1.0).top == 0.0


def test_a_scalar_depth_gives_a_number_and_an_array_its_shape():
    assert isinstance(density_at(STEP, 4.0), float)
    assert density_at(STEP, np.zeros((2, 3))).shape == (2, 3)


def test_gravity_is_as_stated_or_of_the_latitude_or_9_8():
    assert gravity_of(Environment(gravity=0.0, water=LAKE)) == 0.0
    assert gravity_of(Environment()) == 9.8
    # The normal gravity of GRS 80 at the equator and 45 deg, m/s2: 9.780327 and 9.806199.
    for latitude, expected in ((0.0, 9.780327), (45.0, 9.806199), (-45.0, 9.806199)):
        water = LAKE.model_copy(update={"latitude": latitude})
        assert gravity_of(Environment(water=water)) == pytest.approx(expected, abs=1e-5)


def test_a_place_without_an_atlas_is_refused_with_the_way_out():
    water = OCEAN.model_copy(update={"latitude": -88.0, "longitude": 10.0})
    with pytest.raises(DesignError, match=r"longitude 10, latitude -88 deg.*leave longitude out") as caught:
        water_table(water, GRAVITY)
    assert caught.value.problems[0].pointer == "/mission/environment/water/longitude"
    assert surface_density(water.model_copy(update={"longitude": None})) > 1020.0


def test_range_of_the_profile():
    assert profile_range(UniformWater()) is None
    assert profile_range(STEP) == (3.0, 47.0)


def test_stable_water_is_not_called_unstable():
    assert [unstable_layers(water) for water in (UniformWater(), STEP, LAKE, OCEAN)] == [None] * 4


def test_the_worst_inversion_is_named_with_its_size():
    water = DensityProfile(
        kind="density_profile", depths=(0.0, 5.0, 10.0, 20.0), densities=(1000.0, 999.9, 1001.0, 1000.5)
    )
    layer = unstable_layers(water)
    assert (layer.top, layer.bottom) == (10.0, 20.0)
    assert layer.drop == pytest.approx(0.5, rel=1e-9)


def test_compression_hides_no_inversion():
    # Warmer below: unstable, though pressure makes the deep water denser in situ.
    water = Teos10Water(kind="teos10", depths=(0.0, 1000.0), temperatures=(15.0, 15.5), latitude=45.0)
    assert density_at(water, 1000.0) > surface_density(water)
    layer = unstable_layers(water)
    fall = gsw.rho(0.0, gsw.CT_from_t(0.0, 15.0, 0.0), 500.0) - gsw.rho(0.0, gsw.CT_from_t(0.0, 15.5, 1008.0), 500.0)
    assert layer.drop == pytest.approx(fall, rel=0.02)


def test_the_sign_of_the_inversion_is_that_of_the_buoyancy_frequency():
    for warming in (-1.0, -0.1, 0.1, 1.0):
        temperatures = (15.0, 15.0 + warming)
        water = Teos10Water(kind="teos10", depths=(0.0, 10.0), temperatures=temperatures, latitude=45.0)
        pressure = gsw.p_from_z(-np.array(water.depths), 45.0)
        conservative = gsw.CT_from_t(0.0, np.array(temperatures), pressure)
        (frequency2,), _ = gsw.Nsquared(np.zeros(2), conservative, pressure, 45.0)
        assert (unstable_layers(water) is None) == (frequency2 > 0.0)


def test_fresh_water_across_4_degrees_is_unstable_below_them():
    # 2 degC above 6 degC: the ends are about as dense as each other, the middle of the layer is densest.
    water = Teos10Water(kind="teos10", depths=(0.0, 10.0), temperatures=(2.0, 6.0), latitude=45.0)
    layer = unstable_layers(water)
    # Densities of pure water at 4 and 6 degC: 999.975 and 999.943 kg/m3.
    assert layer.drop == pytest.approx(0.032, abs=0.003)


def test_still_uniform_and_sheared_currents():
    still = current_table(None)
    assert still.levels == 1 and np.array_equal(still.rows, np.zeros((1, 9))) and np.array_equal(still.times, [0.0])
    uniform = current_table(UniformCurrent(kind="uniform", velocity=(0.1, -0.2)))
    assert np.array_equal(uniform.rows, [[0.0, 0.1, 0.0, 0.0, 0.0, -0.2, 0.0, 0.0, 0.0]])
    sheared = current_table(ShearedCurrent(kind="sheared", surface_velocity=(0.1, 0.2), shear=(-0.01, 0.03)))
    assert np.array_equal(sheared.rows, [[0.0, 0.1, -0.01, 0.0, 0.0, 0.2, 0.03, 0.0, 0.0]])


def velocity(table, k, z):
    rows = table.rows[k * table.levels : (k + 1) * table.levels]
    row = rows[max(int(np.searchsorted(rows[:, 0], z, side="right")) - 1, 0)]
    powers = (z - row[0]) ** np.arange(4)
    return np.array([row[1:5] @ powers, row[5:9] @ powers])


def test_a_table_that_is_linear_in_depth_is_that_line_and_held_beyond():
    depths = (2.0, 5.0, 11.0, 30.0)
    north = tuple(tuple(a + 0.02 * z for z in depths) for a in (0.1, -0.3))
    east = tuple(tuple(b - 0.01 * z for z in depths) for b in (0.0, 0.2))
    current = TabulatedCurrent(kind="tabulated", depths=depths, times=(0.0, 60.0), north=north, east=east)
    table = current_table(current)
    assert table.levels == 5 and table.rows.shape == (10, 9) and np.array_equal(table.times, [0.0, 60.0])
    assert table.rows.flags.c_contiguous and table.rows.flags.writeable and table.times.flags.writeable
    assert np.array_equal(table.rows[:5, 0], [2.0, 2.0, 5.0, 11.0, 30.0])
    for k, (a, b) in enumerate(((0.1, 0.0), (-0.3, 0.2))):
        for z in (-1.0, 0.0, 2.0, 3.3, 5.0, 20.0, 30.0, 99.0):
            held = min(max(z, 2.0), 30.0)
            assert velocity(table, k, z) == pytest.approx([a + 0.02 * held, b - 0.01 * held], abs=1e-14)


def test_a_tabulated_current_does_not_overshoot_and_the_cache_keeps_its_own():
    profile = (0.5, 0.5, 0.1, 0.1)
    current = TabulatedCurrent(kind="tabulated", depths=(0.0, 10.0, 12.0, 40.0), north=(profile,), east=(profile,))
    table = current_table(current)
    values = np.array([velocity(table, 0, z) for z in np.linspace(0.0, 45.0, 901)])
    assert values.min() >= 0.1 - 1e-12 and values.max() <= 0.5 + 1e-12
    assert np.all(np.diff(values[:, 0]) <= 1e-12)
    table.rows[:] = np.nan
    assert np.isfinite(current_table(current).rows).all()
