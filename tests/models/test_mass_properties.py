"""Mass, centres and inertia: against clouds of points, against the kernel, and the trimming of ballast."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from models.assemble import assemble
from models.design import CompositeMass, Design, parse_design
from models.design_warnings import warnings_for
from models.kernel.actuators import balance_with_parts
from models.mass_properties import mass_balance, point_inertia, trim_ballast
from models.presets import load_preset, preset_ids
from models.problems import DesignError
from models.vehicle_length import vehicle_length
from models.volumes import volume
from models.water import density_at, gravity_of
from tests.models.support import BODY, PISTON, document
from tests.strategies import designs, states


def composite(design: Design) -> Design:
    return design.model_copy(update={"vehicle": design.vehicle.model_copy(update={"mass_properties": CompositeMass()})})


def box(mass, center, sides):
    """A component that is a box of eight equal points; its inertia by their sum."""
    offsets = np.array([[i, j, k] for i in (-1, 1) for j in (-1, 1) for k in (-1, 1)]) * np.array(sides) / 2
    own = sum(mass / 8 * point_inertia(offset) for offset in offsets)
    component = {
        "kind": "rigid", "name": f"Box {center}", "mass": mass, "position": list(center), "volume": 1e-4,
        "inertia": {"xx": own[0, 0], "yy": own[1, 1], "zz": own[2, 2], "xy": own[0, 1], "xz": own[0, 2]},
    }  # fmt: skip
    return component, [(mass / 8, np.array(center) + offset) for offset in offsets]


@given(st.lists(st.tuples(st.floats(0.1, 2.0), *[st.floats(-1.0, 1.0)] * 3), min_size=1, max_size=6, unique=True))
def test_composition_equals_that_of_a_cloud_of_points(boxes):
    parts, cloud = [], []
    for i, (mass, *center) in enumerate(boxes):
        component, points = box(mass, center, (0.1 + 0.05 * i, 0.2, 0.3))
        parts.append(component | {"name": f"Box {i}"})
        cloud += points
    changed = document()
    changed["vehicle"]["components"] = parts
    balance = mass_balance(parse_design(changed).vehicle)
    m = sum(mass for mass, _ in cloud)
    center = sum(mass * r for mass, r in cloud) / m
    inertia = sum(mass * point_inertia(r - center) for mass, r in cloud)
    assert balance.mass == pytest.approx(m, rel=1e-14)
    np.testing.assert_allclose(balance.center_of_mass, center, rtol=0, atol=1e-14)
    np.testing.assert_allclose(balance.inertia, inertia, rtol=0, atol=1e-13 * m)
    about_origin = sum(mass * point_inertia(r) for mass, r in cloud)
    np.testing.assert_allclose(balance.inertia_about_origin, about_origin, rtol=0, atol=1e-13 * m)


def test_parallel_axes():
    """I_O = I_G + m (|r|^2 1 - r r^T) = I_G - m S(r)^2."""
    r = np.array([0.3, -0.2, 0.5])
    S = np.array([[0, -r[2], r[1]], [r[2], 0, -r[0]], [-r[1], r[0], 0]])
    np.testing.assert_allclose(point_inertia(r), -S @ S, rtol=0, atol=1e-16)


@given(st.data(), designs(neutral=False))
def test_the_kernel_composes_as_the_library_does(data, design):
    assembly = assemble(design)
    y = data.draw(states(assembly))
    extensions = dict(zip(assembly.cells, y[8:], strict=True))
    balance = mass_balance(design.vehicle, extensions)
    mass_x, mass_z, inertia, volume, volume_x, volume_z = balance_with_parts(y, assembly.params)
    assert assembly.params.body["mass"][0] == pytest.approx(balance.mass, rel=1e-14)
    first_moment = balance.mass * balance.center_of_mass
    volume_moment = balance.volume * balance.center_of_buoyancy
    assert (mass_x, mass_z) == pytest.approx((first_moment[0], first_moment[2]), rel=1e-12, abs=1e-15)
    assert inertia == pytest.approx(balance.inertia_about_origin[1, 1], rel=1e-12)
    assert volume == pytest.approx(balance.volume, rel=1e-13)
    assert (volume_x, volume_z) == pytest.approx((volume_moment[0], volume_moment[2]), rel=1e-12, abs=1e-18)


def test_an_emptied_piston_keeps_the_moment_of_what_it_lost():
    """V = 0 has no centre, but a first moment: the stack's -V0 sits half the travel behind the core's V0."""
    piston = PISTON | {"volume": 5e-5, "volume_range": [0.0, 6e-5]}
    assembly = assemble(parse_design(document(piston)))
    y = assembly.initial_state.copy()
    y[8] = -0.05
    balance = mass_balance(assembly.design.vehicle, {"Piston": -0.05})
    _, _, _, volume, volume_x, _ = balance_with_parts(y, assembly.params)
    assert (balance.volume, volume) == (0.95e-3, 0.95e-3)
    expected = 0.95e-3 * BODY["position"][0] - 5e-5 * 0.5 * -0.05
    assert volume_x == pytest.approx(expected, rel=1e-12)
    assert balance.volume * balance.center_of_buoyancy[0] == pytest.approx(expected, rel=1e-12)


@given(designs(neutral=False))
def test_where_a_part_sits_in_the_list_does_not_matter(design):
    turned = design.vehicle.model_copy(update={"components": design.vehicle.components[::-1]})
    one, two = mass_balance(design.vehicle), mass_balance(turned)
    assert one.mass == pytest.approx(two.mass, rel=1e-14)
    np.testing.assert_allclose(one.center_of_mass, two.center_of_mass, rtol=0, atol=1e-15)
    np.testing.assert_allclose(one.inertia, two.inertia, rtol=0, atol=1e-14)
    np.testing.assert_allclose(one.center_of_buoyancy, two.center_of_buoyancy, rtol=0, atol=1e-14)


def test_declared_properties_replace_the_composed_ones_but_not_volumes():
    design = load_preset("canete-dual-bellows")
    balance, composed = mass_balance(design.vehicle), mass_balance(composite(design).vehicle)
    assert balance.mass == 0.787  # Table II of the paper
    np.testing.assert_array_equal(balance.center_of_mass, [0.0, 0.0, 0.001])
    assert balance.inertia[1, 1] == 0.029
    assert balance.volume == composed.volume
    np.testing.assert_array_equal(balance.center_of_buoyancy, composed.center_of_buoyancy)


def test_a_movable_mass_moves_the_centre_of_mass_along_its_axis():
    slide = {
        "kind": "movable_mass", "name": "Slide", "mass": 0.25, "position": [0.0, 0.0, 0.0], "axis": [3.0, 0.0, 4.0],
        "extension_range": [-0.1, 0.1], "neutral_extension": 0.02,
    }  # fmt: skip
    vehicle = parse_design(document(slide)).vehicle
    home, moved = (mass_balance(vehicle, {"Slide": e}) for e in (0.02, 0.07))
    expected = 0.25 * 0.05 * np.array([0.6, 0.0, 0.8]) / 1.2
    np.testing.assert_allclose(moved.center_of_mass - home.center_of_mass, expected, rtol=0, atol=1e-16)
    assert moved.volume == home.volume


@pytest.mark.parametrize("preset_id", ["canete-dual-bellows", "three-cell-glider"])
def test_planar_presets_are_neutral(preset_id):
    design = load_preset(preset_id)
    environment = design.mission.environment
    net = mass_balance(design.vehicle).net_buoyancy(environment.water.density, gravity_of(environment))
    assert abs(net) <= 1e-14  # N: rounding of a weight of 8 N


@pytest.mark.parametrize("preset_id", [name for name in preset_ids() if name.startswith(("quad", "movable"))])
def test_lake_presets_are_as_heavy_at_the_surface_as_light_at_100_m(preset_id):
    """Cells at neutral: so dive and climb ask the same of them. The hull gives way to pressure, the water does not."""
    design = load_preset(preset_id)
    environment, net = design.mission.environment, []
    for depth in (0.0, 100.0):
        z = np.linspace(0.0, depth, 20_001)
        pressure = np.trapezoid(density_at(environment.water, z), z) * gravity_of(environment)
        displaced = sum(
            volume(c, getattr(c, "neutral", 0.0)) * (1.0 - (pressure / c.bulk_modulus if c.bulk_modulus else 0.0))
            for c in design.vehicle.components if c.kind not in ("movable_mass", "rolling_mass")
        )  # fmt: skip
        net.append(gravity_of(environment) * (density_at(environment.water, depth) * displaced - _mass(design)))
    assert net[0] < -0.2 and net[0] == pytest.approx(-net[1], abs=2e-3)


def _mass(design):
    return mass_balance(design.vehicle).mass


@given(designs())
def test_trimming_leaves_no_net_buoyancy_and_says_what_it_changed(design):
    before = {c.name: getattr(c, "volume", None) for c in design.vehicle.components}
    trimmed, change = trim_ballast(design, "Body")
    environment = design.mission.environment
    balance = mass_balance(trimmed.vehicle)
    net = balance.net_buoyancy(environment.water.density, gravity_of(environment))
    assert abs(net) <= 4e-15 * balance.mass * gravity_of(environment)
    after = {c.name: getattr(c, "volume", None) for c in trimmed.vehicle.components}
    assert {name for name in after if after[name] != before[name]} <= {"Body"}
    assert (change.component, change.before, change.after) == ("Body", before["Body"], after["Body"])
    assert change.pointer == "/vehicle/components/0/volume"
    assert "'Body'" in str(change) and f"{change.after * 1e6:.3f} cm3" in str(change)
    assert trimmed.mission == design.mission


def test_trimming_chooses_the_largest_rigid_part():
    small = {"kind": "rigid", "name": "Small", "mass": 0.0, "volume": 1e-6, "position": [0.0, 0.0, 0.0]}
    _, change = trim_ballast(parse_design(document(small, PISTON)))
    assert change.component == BODY["name"]


def test_trimming_refuses_what_it_cannot_do():
    with pytest.raises(DesignError, match="no rigid component named 'Nobody'"):
        trim_ballast(parse_design(document()), "Nobody")
    light = document(PISTON | {"mass": 0.0}, body=BODY | {"mass": 0.001, "volume": 1e-6})
    with pytest.raises(DesignError) as refused:
        trim_ballast(parse_design(light))
    assert refused.value.problems[0].pointer == "/vehicle/components/0/volume"
    cell = document()
    cell["vehicle"]["components"] = [PISTON]
    with pytest.raises(DesignError, match="no rigid component"):
        trim_ballast(parse_design(cell))


def test_a_heavy_or_top_heavy_glider_is_warned_of_with_numbers():
    heavy = parse_design(document(body=BODY | {"mass": 1.05}))
    messages = [str(warning) for warning in warnings_for(heavy)]
    assert any("net buoyancy with neutral cells is -0.98 N" in message for message in messages)
    top = parse_design(document(body=BODY | {"center_of_mass": [-0.15 * 0.05 / 0.95, 0.0, -0.01]}))
    assert any("9.5 mm above the centre of buoyancy" in str(warning) for warning in warnings_for(top))
    assert [str(warning) for warning in warnings_for(parse_design(document()))] == []


def far_off(design: Design) -> dict[str, str]:
    return {w.pointer: w.message for w in warnings_for(design) if "far off" in w.message}


def moved(preset: str, *places: tuple[int, int, float]) -> Design:
    changed = load_preset(preset).model_dump(mode="json")
    for component, axis, place in places:
        changed["vehicle"]["components"][component]["position"][axis] = place
    return parse_design(changed)


@pytest.mark.parametrize("axis", range(3))
@pytest.mark.parametrize("component", range(3))
def test_a_part_kilometres_off_the_hull_is_warned_of_with_the_length(component, axis):
    told = far_off(moved("canete-dual-bellows", (component, axis, -5000.0)))
    assert told.keys() == {f"/vehicle/components/{component}/position/{axis}"}
    (message,) = told.values()
    part = load_preset("canete-dual-bellows").vehicle.components[component]
    length = vehicle_length(load_preset("canete-dual-bellows").vehicle)
    assert message.startswith(f"'{part.name}' is far off the vehicle: its position {'xyz'[axis]} is -5000 m")
    assert float(message.split("the vehicle is ")[1].split()[0]) <= length * 1.01


def test_both_of_a_pair_far_off_are_warned_of_and_one_of_two_parts():
    told = far_off(moved("quad-bellows-spiral", (4, 1, -2000.0), (5, 1, 2000.0)))
    assert told.keys() == {f"/vehicle/components/{i}/position/1" for i in (4, 5)}
    assert all(message.endswith("without it the vehicle is 2 m long") for message in told.values())
    assert far_off(moved("quad-bellows-spiral", (4, 0, 4.0))) == {}  # odd, not absurd
    changed = load_preset("quad-bellows-spiral").model_dump(mode="json")
    changed["vehicle"]["components"][0]["center_of_mass"] = [0.0, 0.0, 3000.0]
    (told,) = far_off(parse_design(changed)).items()
    assert told[0] == "/vehicle/components/0/center_of_mass/2" and "its centre of mass z is 3000 m" in told[1]
    plain = BODY | {"center_of_mass": None}
    two = document(plain | {"name": "Keel", "mass": 0.5, "position": [900.0, 0.0, 0.3]}, body=plain)
    two["mission"]["control"] = {}
    assert far_off(parse_design(two)).keys() == {"/vehicle/components/1/position/0"}  # of two, the lighter one
