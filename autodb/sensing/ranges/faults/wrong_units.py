"""A channel in a wrong unit: which one and which unit, from what the channels state together.

Where a relation is broken, each unit that is mixed up in shops is tried: what mends every relation
is a candidate, and where there is one candidate it is named.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from autodb.files.units import RAW
from autodb.records.mistaken import CONDITIONS, LOADS, Mistake
from autodb.records.tables import CutTable
from autodb.sensing.ranges.faults.check import DataCheck
from autodb.sensing.ranges.faults.relations import KnownOfCuts, Relation, channels_stated, relations
from autodb.wording import listed, phrase

CLOSE = 100.0
"""Another unit is a candidate where its likelihood is within this factor of the best one's."""
ROUNDING = 1e-12


def units(
    table: CutTable, axes: Sequence[str], heard: Sequence[str], known: KnownOfCuts | None = None
) -> DataCheck:
    """Return whether a table's channels are in the units of their names.

    ``heard``: the axes whose current responds to the load. The statistic counts the relations that
    are broken. Factors that every relation leaves room for (all forces in daN without references)
    are not seen.
    """

    def stated(mistake: Mistake) -> list[Relation]:
        return relations(mended(table, mistake), axes, heard, known or KnownOfCuts())

    found = relations(table, axes, heard, known or KnownOfCuts())
    broken = [relation for relation in found if not relation.holds]
    tried = {m: stated(m) for m in mistakes(table, axes)} if broken else {}
    mends = [m for m, made in tried.items() if all(relation.holds for relation in made)]
    usual = [m for m in mends if all(relation.is_usual for relation in tried[m])]
    if not mends:
        broken = [relation for relation in broken if not relation.by_unit]
    sentence = _sentence(broken, likeliest(table, usual or mends)) if broken else ""
    return DataCheck("units", len(broken), "<=", 0, sentence)


def _sentence(broken: list[Relation], mends: list[Mistake]) -> str:
    if not mends:
        return phrase(
            "{names}: several channels are in another unit, or no cut was made; state "
            "their units in the side file",
            names=listed(map(str, broken[:3]), "; "),
        )
    what = " or ".join(str(m) for m in mends)
    remedy = mends[0].remedy if len(mends) == 1 else phrase("its unit in the side file")
    return phrase("{broken}, as if {what}; {remedy}", broken=broken[0], what=what, remedy=remedy)


def mistakes(table: CutTable, axes: Sequence[str]) -> list[Mistake]:
    """Return the units that may be mixed up in a table, restricted to the channels that it has."""
    currents = [(f"{a}.current", f"{a}.current.range", f"{a}.current.air") for a in axes]
    candidates = [
        *CONDITIONS,
        *LOADS,
        *(Mistake(names, "mA") for names in (*currents, sum(currents, ()))),
        *(Mistake((name,), "mA") for names in currents for name in names[1:]),
    ]
    found: dict[tuple[tuple[str, ...], str], Mistake] = {}
    for candidate in candidates:
        names = tuple(n for n in candidate.channels if n in table and table.unit(n) != RAW)
        if names:
            found.setdefault((names, candidate.unit), replace(candidate, channels=names))
    return list(found.values())


def mended(table: CutTable, mistake: Mistake) -> CutTable:
    """Return the table as it would be if its channels were in the mistaken unit."""
    return replace(table, channels=mistake.mended(table.channels))


def likeliest(table: CutTable, mends: list[Mistake]) -> list[Mistake]:
    """Return the mistakes under which force.y follows depth and feed best, among ``mends``.

    ln force.y is a line over ln depth and ln feed with normal scatter; a constant factor leaves its
    fit alone, a feed a minute does not. Kept is what is within a likelihood ratio of CLOSE.
    """
    likelihood = np.array([_power_law_likelihood(mended(table, mend)) for mend in mends])
    near = likelihood > likelihood.max(initial=-np.inf) - np.log(CLOSE)
    return [mend for mend, kept in zip(mends, near, strict=True) if kept]


def _power_law_likelihood(table: CutTable) -> float:
    """Return the log likelihood of force.y as a power law of depth and feed; 0 where unknown."""
    parts = channels_stated(table, "force.y", "cutting.depth", "cutting.feed")
    if parts is None:
        return 0.0
    with np.errstate(divide="ignore"):  # a cut may state zero
        logs = np.log(np.abs(np.column_stack(parts)))
    logs = logs[np.isfinite(logs).all(axis=1)]
    dof = len(logs) - 3
    if dof < 1:
        return 0.0
    design = np.column_stack([np.ones(len(logs)), logs[:, 1:]])
    left = logs[:, 0] - design @ np.linalg.lstsq(design, logs[:, 0], rcond=None)[0]
    return float(-0.5 * dof * np.log(np.mean(left**2) + ROUNDING))
