"""Two plans of one part beside each other: what of each a planner weighs."""

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

from autodb.cli._common import show, table
from autodb.cli._reader import interval
from autodb.wording import amount_words, listed, msgid, phrase, shop_amount

if TYPE_CHECKING:
    from autodb.agent.answer.predicting import JobAnswer
    from autodb.forward.prediction import Interval, Moment, Peaks, PredictedCut

UNKNOWN = msgid("not known: no length")


def show_beside(answers: "Sequence[JobAnswer]") -> None:
    """Print times, volumes, energies, largest loads and limits of jobs, a column each."""
    rows = table(phrase("Beside each other"), "", *(f">{answer.job.name}" for answer in answers))
    for what, said in ROWS.items():
        rows.add_row(phrase(what), *(said(answer) for answer in answers))
    show(rows)


def _sum(value: float | None, unit: str) -> str:
    return phrase(UNKNOWN) if value is None else amount_words(value, unit, ".1f")


def _energy(answer: "JobAnswer") -> str:
    its = answer.totals.energy_kJ
    return phrase(UNKNOWN) if its is None else _with_unit(its, "kJ")


def _largest(unit: str, of: "Callable[[PredictedCut | Peaks | Moment], Interval]") -> "_Says":
    def said(answer: "JobAnswer") -> str:
        some = [of(cut.peaks or cut) for cut in answer.cuts]
        return _with_unit(max(some, key=lambda one: abs(one.value)), unit)

    return said


def _with_unit(one: "Interval", unit: str) -> str:
    return f"{interval(one, unit, 1)} {shop_amount(1.0, unit)[1]}"


def _limits(standing: str) -> "_Says":
    def said(answer: "JobAnswer") -> str:
        some = [one.words for one in answer.limits if one.standing == standing]
        return listed(some) or phrase("none")

    return said


_Says = Callable[["JobAnswer"], str]
ROWS: dict[str, _Says] = {
    msgid("cuts"): lambda answer: f"{len(answer.cuts)}",
    msgid("time"): lambda answer: _sum(answer.totals.time_s, "s"),
    msgid("removed"): lambda answer: _sum(answer.totals.removed_cm3, "cm³"),
    msgid("energy"): _energy,
    msgid("largest torque"): _largest("N·m", lambda some: some.torque_N_m),
    msgid("largest power"): _largest("W", lambda some: some.power_W),
    msgid("limits exceeded"): _limits("exceeded"),
    msgid("limits not entered"): _limits("not entered"),
}
"""What is compared, and what it is of a job."""
