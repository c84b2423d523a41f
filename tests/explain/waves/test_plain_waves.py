"""Laws of a real edge, which follows none exactly: what comes round with every turn is no name.

The slot here is worked out by sums of its own: two teeth, twelve slices, N and mm.
"""

from functools import cache
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from autodb.explain import explain
from autodb.explain.answer import Cause, ChannelAnswer
from autodb.explain.engine.noise import PLAIN, Whitener
from autodb.explain.waves.fit import WhitenedNoise, WhiteWaves, component_noise_sd, fit_waves
from autodb.files.side import SideFile
from autodb.fitting.gaussian import NORMAL_95
from autodb.records.tables import Recording
from tests.helpers.campaigns import first

Array = NDArray[np.float64]

RATE_HZ, RPM, FEED_MM, DEPTH_MM, DIAMETER_MM, HELIX_DEG = 10_000.0, 6000.0, 0.04, 3.0, 20.0, 25.0
SLICES, ROWS = 12, 1500
T = np.arange(ROWS) / RATE_HZ
ANGLE = 2.0 * np.pi * RPM / 60.0 * T + 0.7
SHEAR, EDGE, RUNOUT = (900.0, 350.0, 150.0), (18.0, 15.0, 12.0), (16.0, 9.0, 8.0)
"""Tangential, radial, axial: N/mm² of the chip, N/mm of the edge, and N/mm that one tooth has more
and the other less, each way in a proportion of its own."""
LEAVES = 0.08
"""Share of the force by which a real edge leaves any law, the same in each turn."""
NOISE_N = 1.0
SIDE = {
    "tool": {"diameter_mm": DIAMETER_MM, "teeth": 2, "helix_deg": HELIX_DEG},
    "cut": {
        "operation": "slot",
        "depth_mm": DEPTH_MM,
        "width_mm": DIAMETER_MM,
        "feed_mm_tooth": FEED_MM,
        "speed_rpm": RPM,
    },
}


@cache
def _part(name: str) -> Array:
    """Return what a term adds to x, y, z (3, n)."""
    found = np.zeros((3, ROWS))
    for tooth in range(2):
        for slice_ in range(SLICES):
            height = (slice_ + 0.5) / SLICES * DEPTH_MM
            lag = height * np.tan(np.radians(HELIX_DEG)) / (0.5 * DIAMETER_MM)
            phi = np.mod(ANGLE - tooth * np.pi - lag, 2.0 * np.pi)
            inside = (phi < np.pi) * DEPTH_MM / SLICES
            of_edge = inside * (1.0 if tooth == 0 else -1.0) if name == "runout" else inside
            loaded = inside * FEED_MM * np.sin(phi) if name == "shear" else of_edge
            t, r, a = {"shear": SHEAR, "edge_force": EDGE, "runout": RUNOUT}[name]
            found[0] += loaded * (-t * np.cos(phi) - r * np.sin(phi))
            found[1] += loaded * (t * np.sin(phi) - r * np.cos(phi))
            found[2] += loaded * a
    return found


TERMS = ("shear", "edge_force", "runout")
WHOLE = sum((_part(name) for name in TERMS), np.zeros((3, ROWS)))


def _as_no_law_has_it(seed: int) -> Array:
    """Return what a real edge does otherwise (3, n): six harmonics of the turn."""
    rng = np.random.default_rng(seed)
    order = np.arange(1, 7)
    waves = np.stack([np.cos(order[:, None] * ANGLE), np.sin(order[:, None] * ANGLE)])
    made = np.einsum("cko,kon->cn", rng.standard_normal((3, 2, 6)), waves)
    size = LEAVES * np.std(WHOLE, axis=1) / np.std(made, axis=1)
    return np.asarray(size[:, None] * made)


def _answers(forces: Array, simulated: Array, includes: list[str]) -> dict[str, ChannelAnswer]:
    names = [f"force.{axis}" for axis in "xyz"]
    noise = NOISE_N * np.random.default_rng(5).standard_normal(forces.shape)
    turned = {"t": T, "spindle.angle": np.degrees(ANGLE)}
    recorded = turned | dict(zip(names, forces + noise, strict=True))
    made = {"t": T} | dict(zip(names, simulated, strict=True))
    found = explain(
        Recording(Path("cut.csv"), recorded, side=SideFile.model_validate(SIDE)),
        Recording(Path("simulation.csv"), made),
        includes=includes,
    )
    return found.explanation.channels


def _sure(answer: ChannelAnswer) -> dict[str, Cause]:
    return {cause.term: cause for cause in answer.missing if cause.confidence >= 0.9}


@pytest.mark.parametrize("hidden", ["edge_force", "runout"])
@pytest.mark.parametrize("seed", first(1, [1, 2]))
def test_what_is_missing_is_named_with_its_size_beside_what_no_law_has(
    hidden: str, seed: int
) -> None:
    kept = [name for name in TERMS if name != hidden]
    simulated = sum((_part(name) for name in kept), np.zeros((3, ROWS)))
    answers = _answers(WHOLE + _as_no_law_has_it(seed), simulated, kept)
    for component, answer in enumerate(answers.values()):
        sure = _sure(answer)
        assert set(sure) <= {hidden, "unknown"}
        size, truth = sure[hidden].parameters["size"], np.abs(_part(hidden)[component]).max()
        assert size.value == pytest.approx(truth, rel=0.25)
        assert abs(size.value - truth) <= 3.0 * (size.high - size.low) / (2.0 * NORMAL_95)
        assert answer.fit.noise_floor <= answer.fit.heldout_after


@pytest.mark.parametrize("seed", first(1, [3, 4]))
def test_with_nothing_missing_what_no_law_has_gets_no_name(seed: int) -> None:
    for answer in _answers(WHOLE + _as_no_law_has_it(seed), WHOLE, [*TERMS]).values():
        (course,) = (c for c in answer.missing if c.kind == "missing")
        assert (course.term, course.variables) == ("unknown", ("spindle.angle",))
        size = {c.term: c.parameters["size"].value for c in answer.missing}
        assert all(size[c.term] <= size["unknown"] for c in answer.missing)
        assert answer.fit.heldout_after < 0.5 * answer.fit.heldout_before


def test_a_run_out_of_the_simulation_may_be_mistuned() -> None:
    simulated = WHOLE - 0.25 * _part("runout")
    for answer in _answers(WHOLE, simulated, [*TERMS]).values():
        (cause,) = _sure(answer).values()
        assert (cause.term, cause.kind) == ("runout", "mistuned")
        assert cause.parameters["factor"].value == pytest.approx(1.0 / 0.75, rel=0.05)


def test_noise_taken_as_white_keeps_every_row() -> None:
    rng = np.random.default_rng(6)
    difference, column = rng.standard_normal((2, 2, 300))
    bench = WhiteWaves(difference, {"shear": column})
    plain = bench.plain(bench.chosen(()))
    assert plain(column[:, :, None]).shape == (600, 1)
    fit = fit_waves(bench, (), plain)
    weight = 1.0 / np.array(plain.sd)[:, None] ** 2
    by_hand = np.sum(weight * column * difference) / np.sum(weight * column**2)
    assert fit.coefficients == pytest.approx(by_hand, rel=1e-9)
    assert np.all(np.isfinite(bench.held_out((), plain)[0]))


def test_the_size_of_a_coloured_noise_is_that_of_its_spectrum() -> None:
    """Of x_t = ρ x_(t−1) + e_t it is sd(e)/√(1 − ρ²), whatever the scale of white rows."""
    rho, sd = 0.9, 2.5
    quiet = WhitenedNoise((Whitener(np.array([rho])), PLAIN), (sd, sd))
    assert component_noise_sd(quiet) == pytest.approx([sd / np.sqrt(1.0 - rho**2), sd], rel=1e-9)
