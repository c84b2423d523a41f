"""The reference table, P4's model on it, and what autodb tells beside it."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy import constants

from autodb.errors import UnusableInput
from autodb.proofs.machines.mill import reference_ringing, reference_table
from autodb.proofs.machines.mill.reference_table import RecordedTable, TrueTable
from autodb.proofs.runs.mill import published_table, table_oracle, table_run, table_summary
from autodb.proofs.runs.run_file import Finished, Origin
from autodb.records.tables import Recording
from autodb.sensing.table.engaged import engaged

SEED = 101


@pytest.fixture(scope="module")
def table() -> TrueTable:
    """A table of development."""
    return reference_table.draw_table(SEED)


@pytest.fixture(scope="module")
def cut(table: TrueTable) -> RecordedTable:
    """Its first tilted cut."""
    return reference_table.mill_on_table(SEED, table, 1)


def test_the_reference_table_is_the_papers(table: TrueTable, cut: RecordedTable) -> None:
    """P4 Table 2: ranges of the force, within 10 %; tared; heat only after chips."""
    rows = published_table.inner(cut.whole)
    low, high = published_table.published_envelopes(cut.true_N)[..., rows].mean(axis=2)
    assert_allclose(high - low, published_table.RANGES_N, rtol=0.1)
    first = np.argmax(cut.engaged)
    assert first == round(reference_table.BEFORE_S * reference_table.FORCE_HZ) + 1
    assert not cut.heat_N[:, :first].any()
    assert np.abs(cut.heat_N[2, -1]) > 5.0
    again = reference_table.mill_on_table(SEED, table, 1)
    assert_allclose(again.reading_N, cut.reading_N, atol=0.0)


def test_what_it_carries_moves_through_space() -> None:
    """A point fixed to the table, by differences of where it is in the machine."""
    t = np.arange(0.0, 2.0, 1e-4)
    angle = np.array([0.8 * np.sin(2.0 * t), 0.6 * np.cos(3.0 * t) - 0.4 * t**2])
    rate = np.gradient(angle, t, axis=1)
    motion = np.array([angle, rate, np.gradient(rate, t, axis=1)])
    lever_m = np.array([0.011, -0.007, 0.092])
    turned = reference_table.machine_to_table(angle)
    place = np.einsum("jin,j->in", turned, lever_m)
    fast = np.gradient(np.gradient(place, t, axis=1), t, axis=1)
    expected = np.einsum("ijn,jn->in", turned, fast)[:, 10:-10]
    found = reference_table.carried_m_s2(motion, lever_m)[:, 10:-10]
    assert_allclose(found, expected, atol=1e-3 * np.max(np.abs(expected)))
    still = np.where(np.arange(3)[:, None, None] == 0, motion, 0.0)
    assert not reference_table.carried_m_s2(still, lever_m).any()


def test_its_rests_weigh_what_lies_on_it(table: TrueTable) -> None:
    """P4 equation 5 at rest in −60°, 0°: y reads −m g sin θ_x, z m g (cos θ_x − 1)."""
    seen = reference_table.record_tilted(SEED, table, added_kg=3.0, stops_deg=((-60.0, 0.0),))
    begin, end = published_table.rests(seen.log)[1]
    read = seen.reading_N[:, (begin + end) // 2 : end].mean(axis=1)
    weight = (table.sensor_kg + 3.0) * constants.g
    expected = table.matrix @ [0.0, weight * np.sin(np.pi / 3.0), -0.5 * weight]
    assert_allclose(read, expected, atol=4.0 * max(reference_table.WANDERS_N))


def test_p4s_model_finds_the_mass_of_a_quiet_table(
    table: TrueTable, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Without noise, crosstalk and offsets its median is the mass, and weight goes to nothing."""
    monkeypatch.setattr(reference_table, "WANDERS_N", (0.0, 0.0, 0.0))
    monkeypatch.setattr(reference_table, "NOISE_N", 0.0)
    still = replace(table, matrix=np.eye(3), offsets_deg=(0.0, 0.0), drawn_m=table.loaded(10.1)[1])
    alone = reference_table.record_tilted(SEED, still, added_kg=0.0)
    fixed = reference_table.record_tilted(
        SEED, still, added_kg=12.3, stops_deg=reference_table.TILTS_FIXED_DEG
    )
    found = published_table.model(alone, fixed, 12.3, still)
    assert_allclose(found.mass_kg, still.sensor_kg + 10.1, rtol=1e-4)
    seen = reference_table.mill_on_table(SEED, still, 2)
    before = slice(0, round(2.5 * reference_table.FORCE_HZ))
    assert np.abs(found.process_N(seen)[:, before]).max() < 0.05


def test_where_a_tool_cuts_is_seen(cut: RecordedTable) -> None:
    found = engaged(table_run.table_recording(cut))
    assert np.mean(found != cut.engaged) < 0.02
    assert found[cut.whole].all()
    slow = Recording(
        table_run.table_recording(cut).path,
        {"t": np.arange(50) / 50.0} | {f"force.{one}": np.zeros(50) for one in "xyz"},
    )
    with pytest.raises(UnusableInput, match="teeth do not show at 50 Hz; record at 200 Hz or more"):
        engaged(slow)


def test_a_dynamometer_that_rings_reads_a_force_that_stays() -> None:
    """At rest what it is; a sine as its response says, to 1 % far below and near the resonance."""
    ringing = reference_ringing.draw_ringing(SEED)
    rate_hz = reference_ringing.FINER * reference_table.FORCE_HZ
    t = np.arange(0.0, 0.5, 1.0 / rate_hz)
    assert_allclose(ringing.read(np.full((3, len(t)), 40.0))[:, -1], 40.0, rtol=1e-3)
    for hz in (100.0, float(ringing.natural_hz[0, 0])):
        read = ringing.read(np.repeat(np.cos(2.0 * np.pi * hz * t)[None], 3, axis=0))
        late = t > 0.3
        wave = np.exp(-2j * np.pi * hz * t[late])
        got = 2.0 * np.mean(read[:, late] * wave, axis=1)
        assert_allclose(np.abs(got), np.abs(ringing.response(np.array([hz]))[:, 0]), rtol=0.05)


def test_taps_and_a_long_cut_are_drawn_from_the_seed(table: TrueTable) -> None:
    ringing = reference_ringing.draw_ringing(SEED)
    taps = reference_ringing.tap_table(SEED, table, ringing)
    assert_allclose(taps.reading_N, reference_ringing.tap_table(SEED, table, ringing).reading_N)
    quick = np.abs(np.diff(taps.true_N)).max(axis=0) > 20.0
    assert np.sum(np.diff(np.flatnonzero(quick)) > 1000) == 3 * reference_ringing.TAPS - 1
    once, twice = (reference_ringing.mill_ringing(SEED, table, None, 1, n) for n in (1, 2))
    assert twice.whole.sum() == pytest.approx(2 * once.whole.sum(), rel=0.01)


def test_who_knows_the_laws_is_no_worse_with_the_work_weighed() -> None:
    """The mass of twelve tables: moves without the work take a seventh of the error and more."""
    off = []
    for seed in range(SEED, SEED + 12):
        drawn = reference_table.draw_table(seed)
        loaded = reference_table.record_tilted(seed, drawn, added_kg=reference_table.WORK_KG)
        alone = reference_table.record_tilted(seed, drawn, added_kg=0.0)
        with_work = (loaded, reference_table.WORK_KG)
        found = [table_oracle.mass_at_best(one) for one in ([with_work], [with_work, (alone, 0.0)])]
        off.append(np.array(found) / drawn.sensor_kg - 1.0)
    single, both = np.sqrt(np.mean(np.square(off), axis=0))
    assert both < 0.85 * single


@pytest.mark.campaign
def test_a_run_is_summed_up() -> None:
    """One table: the gate's shape, ours nearer than P4's model by three and more."""
    run = Finished(SEED, tuple(table_run.run_table(SEED)))
    origin = Origin("table", "0", "generator", "product")
    found = table_summary.table_summary_of([run], origin)
    by_way = {row.way: row for row in found.off}
    ours, published = by_way[table_summary.OURS], by_way[table_summary.PUBLISHED]
    assert ours.sideways_N < 0.35 * published.sideways_N
    assert ours.off_N[2] < 0.35 * published.off_N[2]
    assert found.along > 0.15
    assert found.identified == 4
    rings = {row.way: row.off_N for row in found.ringing}
    assert np.all(np.array(rings[table_summary.OURS]) < np.array(rings[table_summary.LEFT_IN]) / 4)
    drift = dict(found.drift)
    assert drift[table_summary.OURS] < 0.1 * drift[table_summary.LEFT_IN]
    assert found.two_times == 1
    assert found.recordings == 2
    assert table_summary.TableForcesSummary.from_json(found.to_json()) == found
    limits = found.tables()[0]
    assert len(limits.rows) == 14
    gate = found.tables()[1]
    assert len(gate.rows) == 6
    assert [len(row) for row in gate.rows] == [5] * 6
