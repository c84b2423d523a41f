"""Milled waveforms: teeth, the law that a simulation follows, and what its recording has beside."""

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from autodb.errors import UnusableInput
from autodb.explain import explain
from autodb.explain.engine.candidates import UNKNOWN
from autodb.explain.waves.candidates import OWN_WAYS
from autodb.explain.waves.fit import variance_of, whitener_of
from autodb.explain.waves.law import ReadLaw, chip_functions, in_ways, read_off
from autodb.explain.waves.look import FoundInWaves, look_in_waves
from autodb.explain.waves.simulation import waves_of
from autodb.explain.waves.teeth import Mill, StandsOut, Teeth
from autodb.explain.waves.waves import mill_of
from autodb.files.channels import FORCES
from autodb.files.side import SideFile
from autodb.proofs.cases.mill.mill_cases import MillCase, draw_mill_case
from autodb.proofs.cases.plan import DEVELOPMENT
from autodb.proofs.runs.explain.explain_oracle import oracle_verdict
from autodb.records.source import read
from autodb.records.tables import Recording
from tests.helpers.campaigns import first

Array = NDArray[np.float64]

K_TC, K_RC, K_AC, K_TE, K_RE, K_AE = 2000.0, 600.0, 300.0, 25.0, 30.0, 4.0
"""N/mm² and N/mm: sizes of the contract's example, and edge forces of the order of Ti6Al4V's."""
FEED, DEPTH = 0.05, 1.0


def _law(chip_mm: Array) -> tuple[Array, Array, Array]:
    some = chip_mm > 0.0
    return K_TC * chip_mm + K_TE * some, K_RC * chip_mm + K_RE * some, K_AC * chip_mm + K_AE * some


def _sharp(chip_mm: Array) -> tuple[Array, Array, Array]:
    return K_TC * chip_mm, K_RC * chip_mm, 0.0 * chip_mm


def _teeth(mill: Mill, angle_rad: Array) -> Teeth:
    one = np.ones(len(angle_rad))
    return Teeth(mill, angle_rad, one, one)


def _slot(teeth: int, helix_deg: float = 0.0, slices: int = 60) -> Mill:
    twist = DEPTH * np.tan(np.radians(helix_deg)) / 5.0
    return Mill(teeth, float(twist), DEPTH, FEED, (0.0, np.pi), slices=slices)


def test_the_contracts_example() -> None:
    alone = _teeth(Mill(1, 0.0, 1.0, FEED, (0.0, np.pi)), np.array([0.5 * np.pi]))
    np.testing.assert_allclose(alone.forces(_sharp)[:, 0], [-30.0, 100.0, 0.0], atol=1e-9)


def test_mean_slot_forces_are_the_closed_form() -> None:
    """The closed form, within 0.1 %."""
    angle = np.arange(7200) * 2.0 * np.pi / 7200
    mean = _teeth(_slot(4, helix_deg=30.0), angle).forces(_law).mean(axis=1)
    z, a, f = 4, DEPTH, FEED
    closed = (
        -z * a / 4 * K_RC * f - z * a / np.pi * K_RE,
        z * a / 4 * K_TC * f + z * a / np.pi * K_TE,
        z * a / np.pi * K_AC * f + z * a / 2 * K_AE,
    )
    np.testing.assert_allclose(mean, closed, rtol=1e-3)


def test_a_tooth_that_stands_out_takes_from_the_next() -> None:
    """The sum of the chips of all teeth stays: what one cuts more the next finds less of."""
    teeth = _teeth(_slot(3), np.linspace(0.0, 2.0 * np.pi, 721))
    out = StandsOut((0.004, -0.002, -0.002))
    sharp = [np.trapezoid(teeth.of_tooth(j, _sharp, out)[1]) for j in range(3)]
    even = [np.trapezoid(teeth.of_tooth(j, _sharp)[1]) for j in range(3)]
    assert sharp[0] > 1.05 * even[0]
    assert sum(sharp) == pytest.approx(sum(even), rel=1e-3)


def test_the_chip_of_a_tooth_that_misses_is_found_by_the_next() -> None:
    teeth = _teeth(_slot(2), np.array([0.5 * np.pi, 1.5 * np.pi]))
    first, second = (
        teeth.forces(_sharp, StandsOut((0.1, -0.1), missed=missed))[1] for missed in (True, False)
    )
    np.testing.assert_allclose(first, [K_TC * 2.0 * FEED * DEPTH, 0.0], atol=1e-9)
    np.testing.assert_allclose(second, [K_TC * (FEED + 0.2) * DEPTH, 0.0], atol=1e-9)


def test_a_line_is_not_whitened_away() -> None:
    """An autoregression fitted to it would filter the line; the running median does not see it."""
    rng = np.random.default_rng(5)
    noise = 3.0 * rng.standard_normal(8000)
    tone = 20.0 * np.sin(2.0 * np.pi * 0.21 * np.arange(8000))
    whitener = whitener_of(noise + tone)
    assert variance_of(whitener, noise + tone) == pytest.approx(9.0, rel=0.1)
    assert np.std(whitener(tone)) == pytest.approx(np.std(tone), rel=0.1)


def _case(kind: str, seed: int, clarity: float) -> MillCase:
    return draw_mill_case(seed, (kind,) if kind else (), clarity, family=DEVELOPMENT)


def _read(case: MillCase) -> Recording:
    return Recording(Path("case.csv"), case.channels, side=SideFile.model_validate(case.side))


def _looked(case: MillCase) -> FoundInWaves:
    simulation = {name: case.simulation[name] for name in FORCES}
    return look_in_waves(_read(case), simulation, list(case.includes))[1]


def _said(case: MillCase) -> set[str]:
    """Return the names of what the answer says to be missing."""
    forces = {"t": case.channels["t"], **{name: case.simulation[name] for name in FORCES}}
    done = explain(_read(case), Recording(Path("s.csv"), forces), includes=list(case.includes))
    said = [c for answer in done.explanation.channels.values() for c in answer.missing]
    return {c.term for c in said if c.kind == "missing" and c.term != UNKNOWN}


def _named(looked: FoundInWaves) -> list[str]:
    """Return what was named; that an own term's ways are off by unlike factors is no name."""
    choices = looked.found.choices
    return [c.candidate.term for c in choices if c.candidate.key != OWN_WAYS]


@pytest.mark.parametrize("seed", first(2, [4108, 4201, 4105]))
def test_a_simulations_law_is_read_off_its_waves(seed: int) -> None:
    """Side milling, a mill whose angle was not recorded, and a slot on a tilting table."""
    case = _case("", seed, 20.0)
    waves = waves_of(_read(case), {name: case.simulation[name] for name in FORCES})
    assert waves.fits > 0.999
    made = waves.seen(waves.teeth.forces(waves.law.whole))
    assert np.std(made - case.simulated) < 0.03 * np.std(case.simulated)


def test_an_edge_and_the_chip_are_told_apart() -> None:
    """Of a waveform of K h^p and a rounded edge, in a slot: its numbers come back."""
    truth = ReadLaw(
        np.array([[90.0], [30.0], [15.0]]),
        np.array([[0.8], [0.75], [0.9]]),
        np.array([20.0, 25.0, 3.0]),
        0.006,
    )
    teeth = _teeth(_slot(3, helix_deg=30.0), np.linspace(0.0, 20.0, 900))
    columns = in_ways(teeth.moments(chip_functions)).reshape(-1, 3, 2700)
    found = read_off(columns, teeth.forces(truth.whole).ravel(), edged=True)
    assert found.round_mm == truth.round_mm
    np.testing.assert_allclose(found.power, truth.power, atol=1e-9)
    np.testing.assert_allclose(found.edge, truth.edge, rtol=1e-3)
    np.testing.assert_allclose(found.shear, truth.shear, rtol=1e-3)


def test_the_slope_of_a_law_is_its_derivative() -> None:
    law = ReadLaw(np.full((3, 1), 50.0), np.full((3, 1), 0.7), np.full(3, 20.0), 0.01)
    chip, by = np.array([0.01, 0.05, 0.1]), 1e-7
    made = (np.array(law.whole(chip + by)) - np.array(law.whole(chip - by))) / (2.0 * by)
    np.testing.assert_allclose(law.slope(chip), made, rtol=1e-5)


KINDS = (
    ("table_inertia", 4212), ("sensor_drift", 4209), ("crosstalk", 4214), ("edge_force", 4201),
    ("runout", 4202), ("tool_wear", 4205), ("chatter", 4208),
)  # fmt: skip


@pytest.mark.parametrize(("kind", "seed"), first(1, KINDS))
def test_what_is_clear_is_named(kind: str, seed: int) -> None:
    """One effect of clarity 100; cases of development, which the search was written on."""
    case = _case(kind, seed, 100.0)
    assert case.reached
    assert _said(case) == {kind}


def test_a_faint_scale_and_crosstalk_take_the_place_of_a_smooth_law() -> None:
    """White rows tell them with nine coefficients from a law of the chip with seventeen, which
    blocks of time left out need as well.
    """
    case = draw_mill_case(562, ("gain", "crosstalk"), 20.0, family=DEVELOPMENT)
    assert set(_named(_looked(case))) == {"gain", "crosstalk"}


@pytest.mark.parametrize("seed", first(1, (4216, 4218, 4217, 4219)))
def test_of_nothing_nothing_is_named(seed: int) -> None:
    """An own law that is off in ways which several effects share is `unknown`, with these."""
    assert not _said(_case("", seed, 20.0))


@pytest.mark.campaign
def test_how_far_teeth_stand_out_is_found() -> None:
    case = _case("runout", 4202, 100.0)
    out = _looked(case).world.out
    assert out is not None
    assert np.ptp(out.mm) == pytest.approx(2.0 * case.hidden[0].size, rel=0.05)


def test_the_oracle_finds_what_is_clear_in_a_waveform() -> None:
    assert oracle_verdict(_case("table_gravity", 4211, 20.0)).decidable


@pytest.mark.campaign
@pytest.mark.parametrize(("folder", "hidden"), [("mill-1", ["runout"]), ("mill-2", [])])
def test_foreign_mills(tryout: Path, folder: str, hidden: list[str]) -> None:
    recording, simulation = (
        read(tryout / folder / name) for name in ("recording.csv", "simulation.csv")
    )
    assert isinstance(recording, Recording)
    forces = {name: simulation[name] for name in FORCES}
    _, looked = look_in_waves(recording, forces, ["shear", "edge_force"])
    assert looked.world.waves.fits > 0.9999
    assert _named(looked) == hidden


def test_what_the_side_file_lacks_is_named() -> None:
    t = np.arange(10) / 10.0
    with pytest.raises(UnusableInput, match=r"\[tool\] diameter_mm, \[tool\] teeth"):
        mill_of(Recording(Path("r.csv"), {"t": t, "force.x": t}))
