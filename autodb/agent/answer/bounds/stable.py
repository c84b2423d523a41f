"""To what depth the cuts of a job are stable, beside what the machine's limits allow."""

from collections.abc import Sequence
from dataclasses import dataclass

from autodb.agent.answer.bounds.largest import Largest, largest_value
from autodb.agent.answer.prediction_basis import PredictionBasis
from autodb.errors import UnusableInput
from autodb.files.job import Job
from autodb.forward.limits import fastest_rpm
from autodb.forward.stability.depths import StableDepth, stable_depth
from autodb.forward.stability.dynamics import ToolPoint

SURE = 0.95
"""How surely a machine's limits are kept at the depth that is named beside."""


@dataclass(frozen=True)
class StableCut:
    """A cut's stable depth, and beside it the largest that its loads allow; ``why`` none is known.

    ``loads``: with 95 % probability within the machine's limits.
    """

    stable: StableDepth
    loads: Largest | None
    why: str


def stability_lines(found: Sequence[StableCut]) -> tuple[str, ...]:
    """Say what is known of each cut, and once why no depth by the limits is known of any."""
    whys = why_of_all(found)
    lines: list[str] = []
    for one in found:
        lines += [one.stable.words, *loads_words(one, whys), *one.stable.notes]
    return (*lines, *whys)


def loads_words(one: StableCut, known: Sequence[str] = ()) -> tuple[str, ...]:
    """Say the depth that a cut's loads allow, or why none is known; ``known``: said elsewhere."""
    said = one.why if one.loads is None else one.loads.statement
    return () if said in known else (said,)


def why_of_all(found: Sequence[StableCut]) -> tuple[str, ...]:
    """Say why no depth by the limits is known, where the reason is the same for all cuts."""
    whys = {one.why for one in found}
    return tuple(whys - {""}) if len(whys) == 1 else ()


def stable_cuts(basis: PredictionBasis, job: Job, point: ToolPoint) -> tuple[StableCut, ...]:
    """Return what depths a job's cuts are stable to.

    Raises UnusableInput where the job has a program, or a cut no depth.
    """
    if job.program is not None:
        raise UnusableInput(
            f"job '{job.name}' has a program; list its cuts as [[cut]] to ask for their stability"
        )
    basis = basis.of_lot(job.lot)
    spindle = basis.limits.get("spindle")
    fastest = None if spindle is None else fastest_rpm(spindle)
    found = []
    for cut in job.cut:
        known = basis.known
        stable = stable_depth(known.posterior, known.tool, cut, point, fastest_rpm=fastest)
        try:
            loads, why = largest_value(basis, cut, "depth", share=1.0, sure=SURE), ""
        except UnusableInput as error:
            loads, why = None, str(error)
        found.append(StableCut(stable, loads, why))
    return tuple(found)
