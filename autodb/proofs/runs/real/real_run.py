"""Proof: an explanation of a real axis names what its simulation left out, whatever else is in it.

A case is a place in a plan that is fixed; what is drawn of it is fixed by its name.
"""

from dataclasses import replace

from autodb.errors import UnusableInput
from autodb.proofs.cases.real import (
    friction_states,
    full_models,
    held_out,
    injected,
    left_out_terms,
    real_axis,
    real_case,
    real_cases,
    real_columns,
    real_effects,
    real_nulls,
    real_sources,
    rival_names,
    shown_cases,
)
from autodb.proofs.cases.real.real_case import RealCase, RealSpec
from autodb.proofs.cases.real.real_cases import made_case, real_specs
from autodb.proofs.cases.real.real_nulls import twin_of
from autodb.proofs.cases.real.real_sources import NoRecordingsError
from autodb.proofs.cases.real.shown_cases import recording_of
from autodb.proofs.runs.real.idle_names import idle_names
from autodb.proofs.runs.real.real_answers import RealAnswer, explained_real
from autodb.proofs.runs.real.real_peers import PEERS, greedy
from autodb.proofs.runs.real.real_score import (
    JudgedReal,
    judged_answer,
    peer_score,
    sure_names,
    unjudged,
)

REAL_GENERATOR = (
    friction_states, full_models, held_out, injected, left_out_terms, real_axis, real_case,
    real_cases, real_columns, real_effects, real_nulls, real_sources, rival_names, shown_cases,
)  # fmt: skip
"""All modules that make cases."""
REAL_RUNS = len(real_specs())


def run_real(seed: int) -> list[JudgedReal]:
    """Make the case of a place in the plan, ask about it, and judge the answer.

    Raises UnusableInput beyond the plan's end, and where the recordings are not here.
    """
    try:
        case = made_case(planned(seed))
    except NoRecordingsError as error:
        raise UnusableInput(str(error)) from None
    if not case.seen:
        return [unjudged(case, case.axis.name)]
    judged = _judged_beside_twin(case, explained_real(case))
    peers = {name: peer_score(case, greedy(case, names)) for name, names in PEERS.items()}
    return [replace(judged, peers=peers)]


def planned(seed: int) -> RealSpec:
    """Return the case of a place in the plan, from 1 on; raises UnusableInput beyond its end."""
    specs = real_specs()
    if seed > len(specs):
        raise UnusableInput(f"--runs {seed}: the plan has {len(specs)} cases; ask for fewer")
    return specs[seed - 1]


def _judged_beside_twin(case: RealCase, answer: RealAnswer) -> JudgedReal:
    if case.concealed is None:
        return judged_real(case, answer, RealAnswer())
    twin = _twin(case)
    judged = judged_real(case, answer, _answer_to(twin))
    if not judged.false_name:
        return judged
    return replace(judged, false_idle=bool(idle_names(twin, (case.concealed,))))


def judged_real(case: RealCase, answer: RealAnswer, twin: RealAnswer) -> JudgedReal:
    """Judge an answer; of a null also which of its names do no work."""
    judged = judged_answer(case, case.axis.name, answer, twin)
    if case.concealed is not None or answer.error:
        return judged
    return replace(judged, idle=idle_names(case, sure_names(answer)))


def _twin(case: RealCase) -> RealCase:
    """Return the same recording without the effect."""
    if case.kind != "shown":
        return twin_of(case)
    null = f"{recording_of(case.spec.recording)}-null"
    return made_case(RealSpec("shown", null, variant="null"))


TWINS: dict[RealSpec, RealAnswer] = {}
"""Answers to twins that were asked already: each is asked once."""


def _answer_to(twin: RealCase) -> RealAnswer:
    if twin.spec not in TWINS:
        TWINS[twin.spec] = explained_real(twin)
    return TWINS[twin.spec]
