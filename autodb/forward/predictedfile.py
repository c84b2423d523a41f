"""A prediction as a table: one row a cut, each quantity with its 95 % interval and its limit.

Columns: docs/formats.md, "Predictions". Numbers are written with six digits; what a cut or the
machine has not is empty.
"""

from collections.abc import Mapping, Sequence
from itertools import chain

from autodb.files import csvtext
from autodb.files.job import Job
from autodb.files.job_words import job_in_words
from autodb.files.machine import AxisLimits
from autodb.forward.cut_figures import cut_figures
from autodb.forward.limits import (
    QUANTITIES,
    SPINDLE,
    PredictedQuantity,
    fastest_rpm,
    limit_standing,
)
from autodb.forward.prediction import Interval, PredictedCut

ENDS = ("", ".low", ".high")
FIGURES = (
    *("feed.speed", "time", "removal"),
    *(f"{name}{end}" for name in ("specific.force", "energy") for end in ENDS),
    *("Fp", "Fc", "Ff", "passive"),
)
"""Feed mm/min, time s, removal rate cm³/min, specific force N/mm², energy kJ; the channels that are
the passive, the cutting and the feed force, and the component that is known from the law alone."""
STATISTICS = ("", ".start", ".end", ".peak")
"""What is known of a quantity over the time of a cut; first its mean."""


def prediction_as_csv(
    cuts: Sequence[PredictedCut], limits: Mapping[str, AxisLimits], *, asked: Job | None = None
) -> str:
    """Return predicted cuts as CSV; ``limits``: of the machine's axes by name.

    ``asked``: the job, whose material, tool and cuts in words each row ends with.
    """
    columns = [
        *("cut", "name", "operation", "spindle.speed", "spindle.speed.limit", "cutting.speed"),
        *FIGURES,
        *chain.from_iterable(_columns(one) for one in QUANTITIES),
    ]
    rows = [_row(number, cut, limits) for number, cut in enumerate(cuts, start=1)]
    if asked is not None:
        words = list(job_in_words(asked)) if asked.program is None else [cut.name for cut in cuts]
        for row, said in zip(rows, words, strict=True):
            row += [asked.material, asked.tool, said]
        columns += ["work.material", "tool", "asked"]
    return csvtext.rows_as_csv([columns, *rows])


def _columns(one: PredictedQuantity) -> list[str]:
    known = (f"{one.channel}{of}{end}" for of in STATISTICS for end in ENDS)
    return [*known, *(f"{one.channel}.{what}" for what in ("limit", "chance", "standing"))]


def _row(number: int, cut: PredictedCut, limits: Mapping[str, AxisLimits]) -> list[str]:
    fastest = fastest_rpm(limits.get(SPINDLE, AxisLimits()))
    speeds = [_number(cut.speed_rpm), _number(fastest), _number(cut.speed_m_min), *_figures(cut)]
    cells = [_cells(one, cut, limits) for one in QUANTITIES]
    return [f"{number}", cut.name, cut.operation, *speeds, *chain.from_iterable(cells)]


def _cells(
    one: PredictedQuantity, cut: PredictedCut, limits: Mapping[str, AxisLimits]
) -> list[str]:
    """Return mean, ends, peak, limit, the probability that the peak, or mean, exceeds it, and how
    it stands, where the machine has such an axis.
    """
    known = (_ends(one.of(some)) for some in (cut, cut.start, cut.end, cut.peaks))
    limit = one.limit(limits, cut)
    chance = one.chance(cut, limit)
    stands = limit_standing(chance) if one.axis in (*limits, SPINDLE) else ""
    return [*chain.from_iterable(known), _number(limit), _number(chance), stands]


def _figures(cut: PredictedCut) -> list[str]:
    """Return the cells of FIGURES."""
    its = cut_figures(cut)
    intervals = chain.from_iterable(map(_ends, (its.specific_N_mm2, its.energy_kJ)))
    channels = {role: its.roles.get(role, "") for role in ("Fp", "Fc", "Ff")}
    feeds = _number(cut.feed_mm_min), _number(its.time_s), _number(its.removal_cm3_min)
    return [*feeds, *intervals, *channels.values(), "" if cut.passive is None else cut.passive]


def _ends(interval: Interval | None) -> list[str]:
    if interval is None:
        return ["", "", ""]
    return [_number(value) for value in (interval.value, interval.low, interval.high)]


def _number(value: float | None) -> str:
    return "" if value is None else f"{value:.6g}"
