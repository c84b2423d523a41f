"""Two plans of one part beside each other: what of each a planner weighs."""

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

from autodb.cli._common import show, table

if TYPE_CHECKING:
    from autodb.agent.answer.predicting import JobAnswer
    from autodb.forward.prediction import Interval, Moment, Peaks, PredictedCut

UNKNOWN = "not known: no length"


def show_beside(answers: "Sequence[JobAnswer]") -> None:
    """Print times, volumes, energies, largest loads and limits of jobs, a column each."""
    rows = table("Beside each other", "", *(f">{answer.job.name}" for answer in answers))
    for what, said in ROWS.items():
        rows.add_row(what, *(said(answer) for answer in answers))
    show(rows)


def _sum(value: float | None, unit: str) -> str:
    return UNKNOWN if value is None else f"{value:.1f} {unit}"


def _energy(answer: "JobAnswer") -> str:
    return UNKNOWN if answer.totals.energy_kJ is None else _interval(answer.totals.energy_kJ, "kJ")


def _largest(unit: str, of: "Callable[[PredictedCut | Peaks | Moment], Interval]") -> "_Says":
    def said(answer: "JobAnswer") -> str:
        some = [of(cut.peaks or cut) for cut in answer.cuts]
        return _interval(max(some, key=lambda one: abs(one.value)), unit)

    return said


def _interval(one: "Interval", unit: str) -> str:
    return f"{one.value:.1f} ({one.low:.1f} to {one.high:.1f}) {unit}"


def _limits(standing: str) -> "_Says":
    def said(answer: "JobAnswer") -> str:
        return ", ".join(one.words for one in answer.limits if one.standing == standing) or "none"

    return said


_Says = Callable[["JobAnswer"], str]
ROWS: dict[str, _Says] = {
    "cuts": lambda answer: f"{len(answer.cuts)}",
    "time": lambda answer: _sum(answer.totals.time_s, "s"),
    "removed": lambda answer: _sum(answer.totals.removed_cm3, "cm³"),
    "energy": _energy,
    "largest torque": _largest("N·m", lambda some: some.torque_N_m),
    "largest power": _largest("W", lambda some: some.power_W),
    "limits exceeded": _limits("exceeded"),
    "limits not entered": _limits("not entered"),
}
"""What is compared, and what it is of a job."""
