"""A dynamometer on a table: kinematics, what moves tell of it, and the process forces it gives."""

from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose
from numpy.typing import NDArray

from autodb.errors import UnusableInput
from autodb.records.tables import Recording
from autodb.records.timed import on_even_rows
from autodb.sensing.table.forces import envelopes, table_forces
from autodb.sensing.table.identify import air_left_N, identify_table
from autodb.sensing.table.kinematics import Kinematics, about, order_of
from autodb.sensing.table.model import TableModel
from autodb.terms.table import table_gravity_x, table_gravity_y, table_gravity_z

Array = NDArray[np.float64]

RATE_HZ, MASS_KG, G = 200.0, 30.0, 9.80665
LEVER_M = np.array([0.02, 0.065, 0.035])  # P4 section 5.1
ZERO_N = np.array([3.0, -2.0, 5.0])
NOISE_N = 0.5


def _turns(axis: str, angle: float) -> Array:
    """Rotate by P4 equation 2, written out."""
    c, s = np.cos(angle), np.sin(angle)
    if axis == "c":
        return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    if axis == "b":
        return np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])
    return np.array([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]])


def _moved(t: Array, stops: list[tuple[float, float, float]], ramp_s: float) -> tuple[Array, Array]:
    """Return two angles, deg, that go from stop to stop (time, a, c), speeding up evenly."""
    angles = np.zeros((2, len(t)))
    before = (0.0, 0.0)
    for at_s, *goal in stops:
        u = np.clip((t - at_s) / ramp_s, 0.0, 1.0)
        way = u**3 * (10.0 - 15.0 * u + 6.0 * u**2)
        for k in range(2):
            angles[k] += (goal[k] - before[k]) * way
        before = (goal[0], goal[1])
    return angles[0], angles[1]


def _read(
    t: Array,
    a_deg: Array,
    c_deg: Array,
    process_N: Array,
    *,
    order: str = "ac",
    lever_m: Array = LEVER_M,
) -> Array:
    """Return what the sensor reads (3, n): the mass is moved through space, and that is turned."""
    angles = {order[0]: np.radians(a_deg), order[1]: np.radians(c_deg)}
    rotation = np.array(
        [_turns(order[1], angles[order[1]][k]) @ _turns(order[0], angles[order[0]][k])
         for k in range(len(t))]
    )  # fmt: skip
    place = np.einsum("nji,j->ni", rotation, lever_m)
    pull = MASS_KG * np.gradient(np.gradient(place, t, axis=0), t, axis=0)
    weight = MASS_KG * G * (rotation[:, :, 2] - np.array([0.0, 0.0, 1.0]))
    turned = np.einsum("nij,nj->ni", rotation, process_N.T + pull)
    return np.asarray((turned + weight + ZERO_N).T)


def _recording(t: Array, a: Array, c: Array, forces: Array, order: str = "ac") -> Recording:
    noise = NOISE_N * np.random.default_rng(50).standard_normal(forces.shape)
    channels = {"t": t, f"{order[0]}.angle": a, f"{order[1]}.angle": c}
    channels |= {f"force.{axis}": forces[k] + noise[k] for k, axis in enumerate("xyz")}
    return Recording(Path("table.csv"), channels)


T = np.arange(0.0, 36.0, 1.0 / RATE_HZ)
STOPS = [
    (2.0, -60.0, 0.0), (6.0, -60.0, 90.0), (10.0, -30.0, 30.0), (14.0, 30.0, 60.0),
    (18.0, 30.0, 0.0), (22.0, 0.0, 90.0), (26.0, 0.0, 0.0), (30.0, -45.0, 0.0), (33.0, 0.0, 0.0),
]  # fmt: skip
NOTHING = np.zeros((3, len(T)))


@pytest.fixture(scope="module")
def model() -> TableModel:
    """What quick moves with rests between them tell."""
    a, c = _moved(T, STOPS, 1.0)
    return identify_table([_recording(T, a, c, _read(T, a, c, NOTHING))], Kinematics())


def test_rows_that_are_missing_change_no_mass_nor_lever_arm() -> None:
    """Two stretches are gone, one amid a turn: filters see no row across them."""
    a, c = _moved(T, STOPS, 1.0)
    whole = _recording(T, a, c, _read(T, a, c, NOTHING))
    there = ~((T > 6.4) & (T < 7.6)) & ~((T > 20.0) & (T < 21.0))
    channels = {name: values[there] for name, values in whole.channels.items()}
    recording = on_even_rows(Recording(Path("table.csv"), channels))
    assert len(recording.pieces) == 3
    found = identify_table([recording], Kinematics())
    assert_allclose(found.zero_N, ZERO_N, atol=0.15)
    assert_allclose(found.mass_kg, MASS_KG, rtol=0.005)
    assert_allclose(found.lever_m, LEVER_M, atol=0.002)
    left = air_left_N(found, [recording])
    assert np.all(left < 1.5 * air_left_N(found, [whole]))


def test_rotations_are_orthogonal_and_those_of_the_paper() -> None:
    angles = {"a": np.array([0.3, -1.0]), "c": np.array([0.7, 2.0])}
    turned = Kinematics().rotation(angles)
    for k in range(2):
        assert_allclose(turned[:, :, k] @ turned[:, :, k].T, np.eye(3), atol=1e-12)
        paper = _turns("c", angles["c"][k]) @ _turns("a", angles["a"][k])
        assert_allclose(turned[:, :, k], paper, atol=1e-12)
    for axis in "abc":
        assert_allclose(about(axis, np.array([0.4]))[:, :, 0], _turns(axis, 0.4), atol=1e-12)


def test_the_weight_is_that_of_the_terms() -> None:
    a, c = np.array([0.3, -1.0, 0.0]), np.array([0.7, 2.0, 0.5])
    down = Kinematics().rotation({"a": a, "c": c})[:, 2] * G
    assert_allclose(down[0], table_gravity_x(a, c), atol=1e-12)
    assert_allclose(down[1], table_gravity_y(a, c), atol=1e-12)
    assert_allclose(down[2] - G, table_gravity_z(a)[:, 0], atol=1e-12)


def test_mass_zero_and_lever_arm_come_back(model: TableModel) -> None:
    """P4 found masses within 0.6 to 2.8 %; here within half a percent, arms within 2 mm."""
    assert_allclose(model.zero_N, ZERO_N, atol=0.15)
    assert_allclose(model.mass_kg, MASS_KG, rtol=0.005)
    assert abs(model.mass_kg - MASS_KG) < 4.0 * model.mass_sd_kg + 0.01
    assert_allclose(model.lever_m, LEVER_M, atol=0.002)
    assert model.not_excited == ()
    assert TableModel.of_json(model.to_json()).to_json() == model.to_json()


def test_another_order_of_axes_is_another_machine() -> None:
    a, c = _moved(T, STOPS, 1.0)
    recording = _recording(T, a, c, _read(T, a, c, NOTHING, order="bc"), "bc")
    found = identify_table([recording], Kinematics(("b", "c")))
    assert_allclose(found.mass_kg, MASS_KG, rtol=0.005)
    assert_allclose(found.lever_m, LEVER_M, atol=0.002)
    assert order_of({"c": "a", "a": None}) == ("a", "c")
    assert order_of({"a": "y", "c": "a"}) == ("a", "c")
    with pytest.raises(UnusableInput, match="no chain"):
        order_of({"a": None, "c": None})
    with pytest.raises(UnusableInput, match="bed to the table"):
        Kinematics(("a", "a"))


@pytest.mark.parametrize("lever_mm", [(11.0, -7.0, 92.0), (-40.0, 25.0, 60.0)])
@pytest.mark.parametrize("senses", [(1, 1), (1, -1), (-1, 1), (-1, -1)])
def test_angles_may_count_either_way(
    senses: tuple[int, int], lever_mm: tuple[float, float, float]
) -> None:
    """Rests tell which, and the lever arm follows from the table's motion alone."""
    a, c = _moved(T, STOPS, 1.0)
    read = _read(T, a, c, NOTHING, lever_m=np.array(lever_mm) / 1000.0)
    seen = _recording(T, senses[0] * a, senses[1] * c, read)
    found = identify_table([seen], Kinematics())
    assert found.kinematics.senses == senses
    assert found.not_excited == ()
    assert_allclose(1000.0 * found.lever_m, lever_mm, atol=2.0)
    assert np.all(air_left_N(found, [seen]) < 1.0)


def test_a_sense_that_no_rest_tells_is_said_by_name() -> None:
    """Tilted about a alone, then turned about c upright: c may count either way."""
    a, c = _moved(T, [(2.0, -60.0, 0.0), (8.0, 0.0, 0.0), (14.0, 0.0, 90.0), (24.0, 0.0, 0.0)], 1.0)
    found = identify_table([_recording(T, a, c, _read(T, a, c, NOTHING))], Kinematics())
    assert found.kinematics.senses == (1, 1)
    (said,) = [one for one in found.not_excited if "sense" in one]
    assert said.startswith("the sense of c.angle is not determined, taken as +1; rest in tilts")


def test_the_angular_velocity_is_that_of_the_turned_frame() -> None:
    """[ω]× = T dTᵀ/dt and its derivative, by differences, in every order and sense."""
    t = np.arange(0.0, 1.0, 1e-4)
    angles = {"a": 0.7 * np.sin(3.0 * t), "b": 0.4 * np.cos(2.0 * t), "c": 1.1 * t**2}
    for order, senses in (("ac", (1, -1)), ("bc", (1, 1)), ("acb", (-1, 1, -1))):
        table = Kinematics(tuple(order), senses)
        rates = {axis: np.gradient(angles[axis], t) for axis in order}
        faster = {axis: np.gradient(rates[axis], t) for axis in order}
        turned = np.moveaxis(table.rotation(angles), -1, 0)
        spin = turned @ np.gradient(turned, t, axis=0).transpose(0, 2, 1)
        omega = np.array([spin[:, 2, 1], spin[:, 0, 2], spin[:, 1, 0]])
        inner = slice(5, -5)
        assert_allclose(table.omega(angles, rates)[:, inner], omega[:, inner], atol=1e-6)
        found = table.omega_dot(angles, rates, faster)[:, inner]
        assert_allclose(found, np.gradient(omega, t, axis=1)[:, inner], atol=1e-4)


def test_a_rate_of_another_sense_or_unit_is_refused() -> None:
    a, c = _moved(T, STOPS, 1.0)
    read = _read(T, a, c, NOTHING)
    for factor in (-1.0, np.pi / 180.0):
        seen = _recording(T, a, c, read)
        rate = factor * np.gradient(c, T)
        turned = Recording(seen.path, {**seen.channels, "c.velocity": rate})
        with pytest.raises(UnusableInput, match=r"c\.velocity is .* times the rate at which c"):
            identify_table([turned], Kinematics())


def test_a_table_of_an_older_version_has_no_lever_arm(model: TableModel) -> None:
    kept = {key: value for key, value in model.to_json().items() if key != "senses"}
    found = TableModel.of_json(kept)
    assert not found.moment_kg_m.any()
    assert found.mass_kg == model.mass_kg
    assert "calibrate again" in found.not_excited[0]


def test_what_no_turn_tells_is_said_by_name() -> None:
    """About a alone: the arm's x, along it, shows nowhere."""
    a, _ = _moved(T, [(at, goal, 0.0) for at, goal, _ in STOPS], 1.0)
    still = np.zeros_like(a)
    found = identify_table([_recording(T, a, still, _read(T, a, still, NOTHING))], Kinematics())
    assert [said.split(" is")[0] for said in found.not_excited] == [
        "the sense of c.angle", "the lever arm's x"
    ]  # fmt: skip
    assert found.moment_kg_m[0] == 0.0
    assert_allclose(found.lever_m[1:], LEVER_M[1:], atol=0.002)


def test_process_forces_come_back_in_machine_axes(model: TableModel) -> None:
    """A cut while the table turns; the error is noise, and 95 % intervals hold."""
    a, c = _moved(T, [(2.0, -20.0, 31.0), (20.0, -35.0, -57.0)], 6.0)
    cuts = (T > 8.0) & (T < 30.0)
    process = np.array([120.0, -80.0, 40.0])[:, None] * cuts * (1.0 + 0.3 * np.sin(3.0 * T))
    recording = _recording(T, a, c, _read(T, a, c, process))
    made = table_forces(model, recording, cuts, cutoff_hz=20.0)
    inner = slice(200, -200)
    edges = np.zeros(len(T), dtype=bool)
    for at in (8.0, 30.0):
        edges |= np.abs(T - at) < 0.2
    off = (made.force_N - process)[:, inner][:, ~edges[inner]]
    assert np.sqrt(np.mean(off**2)) < 1.0
    held = np.abs(off) <= 1.96 * made.sd_N[:, inner][:, ~edges[inner]]
    assert held.mean() > 0.9


def test_heat_of_chips_is_estimated_from_the_air_around_a_cut(model: TableModel) -> None:
    """z drifts to 25 N with a time of 12 s: left in, the force in z is off by 15 N and more."""
    t = np.arange(0.0, 60.0, 1.0 / RATE_HZ)
    a, c = _moved(t, [(1.0, -20.0, 31.0)], 2.0)
    cuts = (t > 6.0) & (t < 26.0)
    process = np.array([100.0, 60.0, 30.0])[:, None] * cuts
    heat = np.zeros(len(t))
    for k in range(1, len(t)):
        heat[k] = heat[k - 1] + (25.0 * cuts[k] - heat[k - 1]) / (12.0 * RATE_HZ)
    read = _read(t, a, c, process)
    read[2] += heat
    made = table_forces(model, _recording(t, a, c, read), cuts, cutoff_hz=20.0)
    inside = (t > 8.0) & (t < 25.0)
    assert_allclose(made.heat.times_s, [12.0], rtol=0.2)
    assert np.abs(heat[inside]).max() > 15.0
    assert np.abs(made.heat.drift_N[2] - heat)[inside].max() < 3.0
    assert_allclose(made.force_N[:, inside].mean(axis=1), [100.0, 60.0, 30.0], atol=3.0)


def test_mass_that_left_weighs_no_more(model: TableModel) -> None:
    """After 2 kg have gone the sensor reads 2 kg less; with that stated, no force is seen."""
    a, c = _moved(T, [(2.0, -30.0, 0.0)], 2.0)
    gone = np.where(T > 18.0, 2.0, 0.0)
    still = _read(T, a, c, NOTHING)
    down = np.array([Kinematics().rotation({"a": np.radians(a), "c": np.radians(c)})[:, 2]])[0]
    recording = _recording(T, a, c, still - gone * G * down)
    nothing = np.zeros(len(T), dtype=bool)
    made = table_forces(model, recording, nothing, cutoff_hz=20.0, removed_kg=gone)
    blind = table_forces(model, recording, nothing, cutoff_hz=20.0)
    late = slice(round(20.0 * RATE_HZ), -200)
    assert np.abs(made.force_N[:, late].mean(axis=1)).max() < 0.7
    assert np.abs(blind.force_N[:, late].mean(axis=1)).max() > 15.0


def test_envelopes_are_the_extremes_of_a_turn() -> None:
    force = np.sin(2.0 * np.pi * np.arange(400) / 20.0)
    low, high = envelopes(force, [slice(0, len(force))], rows=21)
    assert_allclose(low[20:-20], -1.0, atol=1e-9)
    assert_allclose(high[20:-20], 1.0, atol=1e-9)


def test_what_cannot_be_used_is_refused(model: TableModel) -> None:
    a, c = _moved(T, STOPS, 1.0)
    whole = _recording(T, a, c, _read(T, a, c, NOTHING))

    def without(name: str) -> Recording:
        return Recording(whole.path, {n: one for n, one in whole.channels.items() if n != name})

    with pytest.raises(UnusableInput, match=r"no channel 'c\.angle'"):
        identify_table([without("c.angle")], Kinematics())
    with pytest.raises(UnusableInput, match=r"no channel 'force\.z'"):
        identify_table([without("force.z")], Kinematics())
    level = np.zeros_like(T)
    with pytest.raises(UnusableInput, match="never rests tilted"):
        identify_table([_recording(T, level, c, NOTHING)], Kinematics())
    with pytest.raises(UnusableInput, match="never rests upright"):
        identify_table([_recording(T, level + 30.0, c, NOTHING)], Kinematics())
    with pytest.raises(UnusableInput, match="120 Hz is too much at 200 Hz"):
        table_forces(model, whole, T > 9.0, cutoff_hz=120.0)
    with pytest.raises(UnusableInput, match="3 rows say where it cuts"):
        table_forces(model, whole, np.zeros(3, dtype=bool), cutoff_hz=20.0)
