"""Effects injected into published tables of cuts, one for each way in which they were once lost."""

from dataclasses import replace

import numpy as np
import pytest

from autodb.proofs.cases.tables.table_case import TabledCase
from autodb.proofs.cases.tables.table_cases import table_specs, tabled_case
from autodb.proofs.cases.tables.table_models import table_model
from autodb.proofs.runs.real.real_answers import SaidEntry
from autodb.proofs.runs.tables.table_answers import explained_table
from tests.conftest import shared
from tests.helpers.campaigns import first

HALF = 0.5
CASES = {
    "in a softening that was held": "injected/mata/gain/weak/exact 2",
    "by a swap for a curve": "injected/fnides/hard_spot/weak/refitted 1",
    "in the scatter of its component": "injected/aouici/gain/strong/exact 1",
    "in the place of a law": "injected/lin/hard_spot/strong/exact 1",
    "in a drift of that size in another": "injected/aouici/sensor_drift/strong/mistuned 1",
    "beside a curve that follows it": "injected/lin/sensor_drift/strong/mistuned 1",
    "beside a curve that stands beside it": "injected/fnides/gain/strong/exact 1",
    "by a swap of which nothing was left": "injected/borsos/hard_spot/weak/exact 2",
}


def _case(name: str) -> TabledCase:
    shared("data", "real")
    return tabled_case(next(spec for spec in table_specs() if spec.name == name))


def _explained(name: str) -> tuple[TabledCase, dict[str, list[SaidEntry]]]:
    """Return a case, and what is said missing in each of its components."""
    case = _case(name)
    said = {
        channel: [entry for entry in answer.entries if entry.kind == "missing"]
        for channel, answer in explained_table(case).items()
    }
    return case, said


@pytest.mark.parametrize("name", first(6, CASES.values()), ids=CASES)
def test_what_is_injected_is_named_with_its_size(name: str) -> None:
    """A fair name at 0.5 or more within a factor 2, in each component that holds one alone."""
    case, said = _explained(name)
    alone = [one for one in case.cases if one.concealed and len(one.sizes) == 1]
    assert alone
    for one in alone:
        term, size = one.concealed, one.true_size
        assert size is not None
        named = [e.size for e in said[one.channel] if e.term == term and e.confidence >= HALF]
        assert any(0.5 * size <= found <= 2.0 * size for found in named), said[one.channel]


@pytest.mark.parametrize("name", ["injected/mata/gain/weak/exact 2"])
def test_a_softening_that_is_right_is_not_mistuned(name: str) -> None:
    """What a gain changes in the other component was said to be the softening's."""
    case = _case(name)
    said = explained_table(case)
    assert not any(
        entry.term == "speed_softening" for one in said.values() for entry in one.entries
    )


def test_an_account_is_not_judged_by_its_own_scatter_alone() -> None:
    """Softening of 171 N was 245 N, beside wear of as much that fell with it."""
    _, said = _explained("left out/borsos/speed_softening/kept")
    softening = next(entry for entry in said["force.y"] if entry.term == "speed_softening")
    assert 130.0 < softening.size < 215.0


def test_no_effect_is_larger_than_the_force() -> None:
    """A nose and a curve of 1.9 kN stood against each other in forces of 0.4 kN."""
    case, said = _explained("injected/fnides/gain/weak/refitted 4")
    most = {channel: case.recording()[channel].abs().max() for channel in said}
    assert all(e.size <= 1.01 * most[channel] for channel in said for e in said[channel])


def test_a_design_cut_in_the_order_of_its_speeds_softens() -> None:
    """Both sensors might have drifted alike; a law that predicts about as well comes before."""
    case, said = _explained("left out/mata/speed_softening/kept")
    for entries in said.values():
        assert "sensor_drift" not in [entry.term for entry in entries]
    (size,) = [one.true_size for one in case.cases if one.channel == "force.y"]
    assert size is not None
    found = {entry.term: entry.size for entry in said["force.y"]}
    assert found["speed_softening"] == pytest.approx(size, rel=0.25)


def test_all_sensors_may_drift_where_no_law_predicts_as_well() -> None:
    case = _case("left out/mata/speed_softening/kept")
    rises = 60.0 * -np.expm1(-8.0 * case.table.t / case.table.t[-1])
    model = table_model("mata").components
    drifted = replace(case, table=case.table.with_forces(model + rises), simulated=model)
    for answer in explained_table(drifted).values():
        assert "sensor_drift" in [entry.term for entry in answer.entries]
