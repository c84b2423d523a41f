"""Proof: an explanation names what a simulation left out, and nothing where nothing is missing."""

from dataclasses import replace
from pathlib import Path

from autodb.errors import UnusableInput
from autodb.explain import explain
from autodb.files.side import SideFile
from autodb.proofs.cases.base.case import Case
from autodb.proofs.cases.mill.mill_cases import MillCase
from autodb.proofs.cases.mill.mill_plan import draw_planned_mill
from autodb.proofs.cases.plan import draw_concealed
from autodb.proofs.runs.explain.explain_score import (
    ScoredCase,
    answer_entries,
    answer_recovery,
    overlap,
    stretches,
    unanswered,
)
from autodb.records.tables import CutTable, Recording


def run_left_out(seed: int) -> list[ScoredCase]:
    """Draw the case of a seed, explain it and score the answer."""
    return [scored_case(draw_concealed(seed))]


def run_mill(seed: int) -> list[ScoredCase]:
    """Draw the milled cut of a seed, explain its waveform and score the answer."""
    return [scored_case(draw_planned_mill(seed))]


def scored_case(case: Case) -> ScoredCase:
    """Explain a case and score the answer.

    A case whose effects cannot show as clearly as wanted is kept, marked, without an answer.
    """
    truth = unanswered(case)
    if not case.reached:
        return truth
    recording, simulation = tables(case)
    try:
        explained = explain(recording, simulation, includes=list(case.includes))
    except UnusableInput as error:
        return replace(truth, refused=str(error))
    answers = explained.explanation.channels
    step = 1.0 if case.table else 0.0
    shared = None
    if case.interval is not None:
        shared = overlap(stretches(answers), case.interval, step=step)
    return replace(
        truth,
        named=answer_entries(answers),
        overlap=shared,
        recovery=answer_recovery(case, explained),
    )


def tables(case: Case) -> tuple[Recording | CutTable, Recording | CutTable]:
    """Return recording and simulation of a case as they are read from files."""
    paths = Path(f"case-{case.seed}.csv"), Path(f"case-{case.seed}-simulation.csv")
    if isinstance(case, MillCase):
        side = SideFile.model_validate(case.side)
        return Recording(paths[0], case.channels, side=side), Recording(paths[1], case.simulation)
    if not case.table:
        return Recording(paths[0], case.channels), Recording(paths[1], case.simulation)
    texts = {"operation": ["turn"] * len(case.channels["cut"])}
    return CutTable(paths[0], case.channels, texts), CutTable(paths[1], case.simulation)
