"""Proof: an explanation of a published table names what its simulation left out.

A case is a place in a plan that is fixed; what is drawn of it is fixed by its name. The table is
explained once, and each component of it is judged.
"""

from dataclasses import replace

from autodb.errors import UnusableInput
from autodb.proofs.cases.real.real_case import RealSpec
from autodb.proofs.cases.tables import (
    published_tables,
    rival_laws,
    table_case,
    table_cases,
    table_columns,
    table_effects,
    table_models,
)
from autodb.proofs.cases.tables.table_case import TabledCase
from autodb.proofs.cases.tables.table_cases import table_specs, tabled_case, without_effect
from autodb.proofs.runs.real.real_answers import RealAnswer
from autodb.proofs.runs.real.real_run import REAL_GENERATOR
from autodb.proofs.runs.real.real_score import (
    JudgedReal,
    judged_answer,
    peer_score,
    sure_names,
    unjudged,
)
from autodb.proofs.runs.tables.table_answers import answered_null, explained_table
from autodb.proofs.runs.tables.table_peers import PEER, greedy_table, idle_laws

TABLES_GENERATOR = (
    *REAL_GENERATOR, published_tables, rival_laws, table_case, table_cases, table_columns,
    table_effects, table_models,
)  # fmt: skip
"""All modules that make cases."""
TABLES_RUNS = len(table_specs())


def run_force_table(seed: int) -> list[JudgedReal]:
    """Make the case of a place in the plan, ask about it, and judge each component.

    Raises UnusableInput beyond the plan's end.
    """
    case = tabled_case(_planned(seed))
    changed = [one for one in case.cases if one.concealed]
    if changed and not any(one.seen for one in changed):
        return [unjudged(one, one.recording) for one in changed]
    answers = explained_table(case)
    twins = {} if case.spec.kind == "null" else answered_null(without_effect(case.spec))
    return [
        _judged(case, place, answers[one.channel], twins.get(one.channel, RealAnswer()))
        for place, one in enumerate(case.cases)
    ]


def _planned(seed: int) -> RealSpec:
    specs = table_specs()
    if seed > len(specs):
        raise UnusableInput(f"--runs {seed}: the plan has {len(specs)} cases; ask for fewer")
    return specs[seed - 1]


def _judged(case: TabledCase, place: int, answer: RealAnswer, twin: RealAnswer) -> JudgedReal:
    one = case.cases[place]
    if not one.seen:
        return unjudged(one, one.recording)
    judged = judged_answer(one, one.recording, answer, twin)
    if one.concealed is None and not answer.error:
        judged = replace(judged, idle=idle_laws(case, place, sure_names(answer)))
    return replace(judged, peers={PEER: peer_score(one, greedy_table(case, place))})
