"""The proof on published tables asks about a table once, and judges each of its components."""

import pytest

from autodb.errors import UnusableInput
from autodb.proofs.cases.real.real_case import RealSpec
from autodb.proofs.cases.tables.table_case import TabledCase
from autodb.proofs.cases.tables.table_cases import table_specs, tabled_case
from autodb.proofs.catalogue import proof
from autodb.proofs.runs.found import markdown
from autodb.proofs.runs.real.real_answers import RealAnswer, SaidEntry
from autodb.proofs.runs.real.real_score import JudgedReal
from autodb.proofs.runs.run_file import Finished, Origin
from autodb.proofs.runs.tables import table_answers, tables_run
from autodb.proofs.runs.tables.table_peers import PEER, greedy_table, idle_laws
from autodb.proofs.runs.tables.tables_run import run_force_table
from autodb.proofs.runs.tables.tables_summary import TablesSummary, tables_summary_of


def _first(recording: str, term: str, strength: str = "strong") -> RealSpec:
    """Return the first injected case of a plan."""
    return next(
        spec for spec in table_specs()
        if (spec.kind, spec.recording, spec.term, spec.strength)
        == ("injected", recording, term, strength)
    )  # fmt: skip


def _place(spec: RealSpec) -> int:
    return table_specs().index(spec) + 1


WEAR = _first("fnides", "tool_wear")


def _answers(case: TabledCase) -> dict[str, RealAnswer]:
    """Return the truth where something is concealed, and a wrong name where nothing is."""
    return {
        one.channel: RealAnswer(
            (SaidEntry(one.concealed or "hard_spot", "missing", 0.95, one.true_size or 1.0),),
            2.0 * one.rms_full, one.rms_full, seconds=1.0,
        )
        for one in case.cases
    }  # fmt: skip


@pytest.fixture
def told(monkeypatch: pytest.MonkeyPatch) -> list[RealSpec]:
    """Answer in place of the command; return what was asked."""
    asked: list[RealSpec] = []

    def explained(case: TabledCase) -> dict[str, RealAnswer]:
        asked.append(case.spec)
        return _answers(case)

    monkeypatch.setattr(tables_run, "explained_table", explained)
    monkeypatch.setattr(table_answers, "explained_table", explained)
    table_answers.answered_null.cache_clear()
    return asked


def test_components_are_judged_one_by_one(told: list[RealSpec]) -> None:
    judged = run_force_table(_place(WEAR))
    assert [one.recording for one in judged] == [f"fnides force.{axis}" for axis in "xyz"]
    assert all(one.named and one.hit and not one.wrong and not one.harm for one in judged)
    assert all(one.false_name is False and one.sure == ((0.95, True),) for one in judged)
    assert [spec.kind for spec in told] == ["injected", "null"]


def test_a_component_that_an_effect_leaves_alone_is_a_null(told: list[RealSpec]) -> None:
    judged = run_force_table(_place(_first("fnides", "gain")))
    alone = [one for one in judged if one.null]
    assert len(alone) == 2
    assert all(one.tuning == "beside an effect" for one in alone)
    assert len(told) == 2


def test_a_table_in_which_nothing_shows_is_not_asked_about(told: list[RealSpec]) -> None:
    unseen = next(
        spec for spec in table_specs()
        if spec.term == "deflection" and not any(one.seen for one in tabled_case(spec).cases)
    )  # fmt: skip
    judged = run_force_table(_place(unseen))
    assert judged
    assert not any(one.asked for one in judged)
    assert told == []


def test_beyond_the_plan_is_one_line() -> None:
    with pytest.raises(UnusableInput, match=r"the plan has \d+ cases; ask for fewer"):
        run_force_table(len(table_specs()) + 1)


def test_the_peer_names_what_is_plain_to_see() -> None:
    case = tabled_case(WEAR)
    named = greedy_table(case, 2)
    assert "tool_wear" in named.sizes
    assert named.held_out is not None
    assert named.held_out < 2.0 * case.cases[2].rms_full
    assert idle_laws(case, 2, ("tool_wear", "shear", "lag")) == ("lag",)


@pytest.mark.usefixtures("told")
def test_limits_can_be_missed() -> None:
    nulls = run_force_table(_place(RealSpec("null", "fnides", variant="exact")))
    good = [*run_force_table(_place(WEAR)), *nulls]
    summary = _summary(good)
    verdicts = {name: passed for name, _, _, passed in summary.checks()}
    assert verdicts["injected: named"] and verdicts["harmed"]
    assert not verdicts["left out: named"]  # no case
    bad = [JudgedReal(**{**vars(one), "named": False, "harm": True}) for one in good]
    verdicts = {name: passed for name, _, _, passed in _summary(bad).checks()}
    assert not verdicts["injected: named"] and not verdicts["harmed"]
    assert PEER in markdown(summary)
    assert TablesSummary.from_json(summary.to_json()) == summary
    assert proof("force-tables").runs == len(table_specs())


def _summary(judged: list[JudgedReal]) -> TablesSummary:
    runs = [Finished[JudgedReal](1, tuple(judged))]
    return tables_summary_of(runs, Origin("force-tables", "0", "0" * 16, "0" * 16))
