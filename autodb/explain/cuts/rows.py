"""The cuts of a table in the order in which they were made, and columns that some of them lack.

What drifts, wears or steps goes with the order of cuts in time. A file may be in another: sorted by
its settings, say.
"""

from collections.abc import Collection, Iterator
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from autodb.explain.answer import ChannelTrace
from autodb.explain.cuts.stack import FLANK_WEAR, VARIABLES
from autodb.records.tables import CutTable
from autodb.wording import localized, stored_msgid

Array = NDArray[np.float64]
Rows = NDArray[np.intp]

LACKS = stored_msgid(
    "{file}: {name} has no value in {n} of {cuts} cuts, the first of them cut {first}, and is not "
    "used; fill it in, or remove those cuts"
)


def made_in_order(table: CutTable) -> Rows:
    """Return the rows of a table in the order of their clock, (n,); of cut numbers without one."""
    clock = table.get("t")
    if clock is None or not np.isfinite(clock).all():
        clock = table.cut
    return np.asarray(np.argsort(clock, kind="stable"), dtype=np.intp)


def rows_of_table(table: CutTable, rows: Rows) -> CutTable:
    """Return some rows (m,) of a table as a table."""
    return replace(
        table,
        channels={name: values[rows] for name, values in table.channels.items()},
        texts={name: [words[row] for row in rows] for name, words in table.texts.items()},
    )


def in_table_order(trace: ChannelTrace, rows: Rows) -> ChannelTrace:
    """Return a trace of some rows (n,), all of the table's, in the table's own order."""
    back = np.argsort(rows)
    return replace(
        trace,
        x=trace.x[back],
        recording=trace.recording[back],
        simulation=trace.simulation[back],
        corrected=trace.corrected[back],
        regime_signals={name: values[back] for name, values in trace.regime_signals.items()},
    )


def complete(table: CutTable, simulation: dict[str, Array]) -> dict[str, Array]:
    """Return the simulated components (n,) that the table and the simulation have in every cut."""
    return {
        name: force
        for name, force in simulation.items()
        if np.isfinite(force).all() and np.isfinite(table[name]).all()
    }


def lacking(table: CutTable, simulation: dict[str, Array]) -> Iterator[str]:
    """Say of which components and conditions some cut has no value, so that none is used."""
    used = complete(table, simulation)
    for name, force in simulation.items():
        if name not in used:
            yield _line(table, name, ~np.isfinite(force) | ~np.isfinite(table[name]))
    for name in _conditions(table):
        missing = ~np.isfinite(table[name])
        if missing.any() and not missing.all():
            yield _line(table, name, missing)


def _conditions(table: CutTable) -> Collection[str]:
    return [name for name in ("t", *VARIABLES, FLANK_WEAR) if name in table]


def _line(table: CutTable, name: str, missing: NDArray[np.bool_]) -> str:
    return LACKS.format(
        file=table.path,
        name=name,
        n=int(np.count_nonzero(missing)),
        cuts=len(table),
        first=localized(f"{table.cut[np.argmax(missing)]:g}"),
    )
