"""Reference forces from a dynamometer: repeated cuts become a protocol of standard cuts.

A reference is the mean of the repeats with its 95 % interval by Student's t: mean ± t(0.975, n−1)
s/√n. The interval is that of the mean on the machine where it was measured, with the dynamometer's
own error left out: neither shows in repeats.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import get_args

import numpy as np
from numpy.typing import NDArray

from autodb.errors import UnusableInput, near_words
from autodb.files.channels import FORCES
from autodb.files.side import Operation
from autodb.records import source as records
from autodb.records.plausible import refuse_doubtful
from autodb.records.summary import summary_of
from autodb.records.tables import CutTable
from autodb.sensing.ranges.recorded.raw import cut_of_recording
from autodb.standard import CutProtocol, ReferenceForce, StandardCut, rows_of_cut
from autodb.standard.protocol import HOLES
from autodb.wording import listed, localized, phrase

Array = NDArray[np.float64]
FEWEST = 2
PER_TOOTH = ("slot", "side-up", "side-down", "ramp", "pocket")
"""Operations whose feed in a cut table is per tooth."""


@dataclass
class _Group:
    """Rows that are one standard cut: the forces of each component, one value a repeat."""

    cut: StandardCut
    forces_N: dict[str, list[float]] = field(default_factory=dict)

    def take(self, table: CutTable, free: NDArray[np.bool_]) -> NDArray[np.bool_]:
        """Add the measured forces of the free rows that are this cut, and return which they are."""
        rows = _is(table, self.cut) & free
        for name in FORCES:
            force = table.get(name)
            if force is not None:
                known = force[rows & np.isfinite(force)].tolist()
                self.forces_N.setdefault(name.removeprefix("force."), []).extend(known)
        return rows


@dataclass(frozen=True)
class MeasuredProtocol:
    """A protocol with the references that were measured, and what got none and why."""

    protocol: CutProtocol
    without: tuple[str, ...]


def read_measured(path: Path, *, columns: Path | None = None) -> CutTable:
    """Read a table of cuts, or a recording of one cut as a table of one row, with forces.

    Raises UnusableInput where no force was measured.
    """
    found = records.read(path, columns=columns)
    refuse_doubtful(path, summary_of(found), found.side)
    table = found if isinstance(found, CutTable) else cut_of_recording(found).table
    if not any(name in table for name in FORCES):
        raise UnusableInput(
            phrase(
                "{file}: no channel force.x, force.y or force.z{near}",
                file=path,
                near=table.near("force.z"),
            )
        )
    return table


def with_references(
    protocol: CutProtocol, tables: Sequence[CutTable], *, date: str
) -> MeasuredProtocol:
    """Return a protocol with a reference for each of its cuts that was measured repeatedly.

    Components that were not measured keep what they had. Raises UnusableInput where a row is two of
    its cuts, or none is one.
    """
    groups = [_Group(cut) for cut in protocol.cut]
    others = 0
    for table in tables:
        hits = np.array([_is(table, cut) for cut in protocol.cut])
        _refuse_two_in_one(table, protocol, hits)
        others += int((~hits.any(axis=0)).sum())
        for group in groups:
            group.take(table, np.ones(len(table), dtype=np.bool_))
    if not any(any(group.forces_N.values()) for group in groups):
        raise UnusableInput(
            phrase(
                "{file}: no row is a standard cut of '{protocol}'",
                file=tables[0].path,
                protocol=protocol.name,
            )
        )
    done = _measured(protocol, groups, tables, date)
    left = (
        (phrase("{others} rows are none of the protocol's cuts", others=others),) if others else ()
    )
    return MeasuredProtocol(done.protocol, (*done.without, *left))


def _refuse_two_in_one(table: CutTable, protocol: CutProtocol, hits: NDArray[np.bool_]) -> None:
    """Raise UnusableInput for the first row, shape (cuts, rows), that is more than one cut."""
    twice = np.flatnonzero(hits.sum(axis=0) > 1)
    if twice.size:
        found = np.flatnonzero(hits[:, twice[0]])
        names = listed((f"'{protocol.cut[i].name}'" for i in found[:2]), phrase(" and "))
        raise UnusableInput(
            phrase(
                "{file}: row {twice} is {names}; use recordings whose side files state "
                "feed_direction_deg",
                file=table.path,
                twice=twice[0] + 1,
                names=names,
            )
        )


def new_protocol(name: str, tables: Sequence[CutTable], *, date: str) -> MeasuredProtocol:
    """Return a protocol of the cuts that were repeated: equal within MATCH is the same cut.

    Raises UnusableInput without any, and where material or tool are not one and known.
    """
    groups: list[_Group] = []
    for table in tables:
        free = np.ones(len(table), dtype=np.bool_)
        for group in groups:
            free &= ~group.take(table, free)
        while free.any():
            first = int(np.argmax(free))
            groups.append(_Group(_cut_of(table, first)))
            free &= ~groups[-1].take(table, free)
            free[first] = False
    again = [group for group in groups if max(map(len, group.forces_N.values()), default=0) > 1]
    if not again:
        raise UnusableInput(
            phrase(
                "{file}: no cut was made twice; repeat cuts at equal speed, feed and depth",
                file=tables[0].path,
            )
        )
    protocol = CutProtocol(
        name=name,
        material=_only(tables, "work.material"),
        tool=_only(tables, "tool"),
        cut=tuple(group.cut for group in again),
    )
    done = _measured(protocol, again, tables, date)
    once = len(groups) - len(again)
    left = (phrase("{once} cuts made once: no repeats, no interval", once=once),) if once else ()
    return MeasuredProtocol(done.protocol, (*done.without, *left))


def _is(table: CutTable, cut: StandardCut) -> NDArray[np.bool_]:
    """Return which rows are a cut; a side file may say the direction, which tables do not."""
    said = table.side.cut.feed_direction_deg
    same = said is None or cut.feed_direction_deg is None
    same = same or abs((said - cut.feed_direction_deg + 180) % 360 - 180) < 1.0  # type: ignore[operator]
    return rows_of_cut(table, cut) & same


def _cut_of(table: CutTable, row: int) -> StandardCut:
    """Return a row's conditions as a standard cut; `turn` where it does not say its operation."""
    operation = table.texts.get("operation", ["turn"] * len(table))[row] or "turn"
    known = get_args(Operation)
    if operation not in known:
        raise UnusableInput(
            phrase(
                "{file}: column 'operation', row {row}: no operation '{operation}'{hint}",
                file=table.path,
                row=row + 1,
                operation=operation,
                hint=near_words(operation, known),
            )
        )
    speed_rpm, feed_mm = _number(table, "spindle.speed", row), _number(table, "cutting.feed", row)
    per = "feed_mm_tooth" if operation in PER_TOOTH else "feed_mm_rev"
    deep = {} if operation in HOLES else {"depth_mm": _number(table, "cutting.depth", row)}
    conditions = ", ".join(f"{value:g} mm" for value in (feed_mm, *deep.values()))
    direction_deg = table.side.cut.feed_direction_deg
    where = "" if direction_deg is None else f", {direction_deg:g} deg"
    return StandardCut.model_validate(
        {
            "name": f"{operation} {speed_rpm:g} rpm, {conditions}{where}",
            "operation": operation,
            "speed_rpm": speed_rpm,
            per: feed_mm,
            **deep,
            "feed_direction_deg": direction_deg,
            "repeats": 1,
        }
    )


def _number(table: CutTable, channel: str, row: int) -> float:
    value = float(table[channel][row])
    if not value > 0:
        raise UnusableInput(
            phrase(
                "{file}: column '{channel}', row {row}: {value}; a standard cut needs a number "
                "above 0",
                file=table.path,
                channel=channel,
                row=row + 1,
                value=localized(f"{value:g}"),
            )
        )
    return float(f"{value:.6g}")


def _measured(
    protocol: CutProtocol, groups: Sequence[_Group], tables: Sequence[CutTable], date: str
) -> MeasuredProtocol:
    files = ", ".join(dict.fromkeys(table.path.name for table in tables))
    cuts, without = [], []
    for group in groups:
        references = {
            component: _reference(np.array(forces_N), files, date)
            for component, forces_N in group.forces_N.items()
            if len(forces_N) >= FEWEST
        }
        most = max(map(len, group.forces_N.values()), default=0)
        if not references:
            why = phrase("cut once: no repeats, no interval") if most else phrase("not measured")
            without.append(f"'{group.cut.name}' {why}")
        repeats = most if references and group.cut.repeats == 1 else group.cut.repeats
        both = {**group.cut.reference, **references}
        cuts.append(group.cut.model_copy(update={"reference": both, "repeats": repeats}))
    return MeasuredProtocol(protocol.model_copy(update={"cut": tuple(cuts)}), tuple(without))


def _reference(forces_N: Array, files: str, date: str) -> ReferenceForce:
    """Return mean and 95 % interval by Student's t of repeats, shape (n,), n at least 2."""
    from scipy import stats

    n = len(forces_N)
    mean = float(np.mean(forces_N))
    half = float(stats.t.ppf(0.975, n - 1) * np.std(forces_N, ddof=1) / np.sqrt(n))
    return ReferenceForce(
        value=_short(mean),
        lower=_short(mean - half),
        upper=_short(mean + half),
        source=f"{files}, dynamometer, {n} repeats, mean and its 95 % interval by Student's t",
        status="measured, one machine",
        date=date,
    )


def _short(force_N: float) -> float:
    return round(force_N, 2)


def _only(tables: Sequence[CutTable], channel: str) -> str:
    """Return the one text that all rows have; raises UnusableInput for none or several."""
    found = dict.fromkeys(text for table in tables for text in table.texts.get(channel, []) if text)
    if len(found) != 1:
        said = f"several: {', '.join(found)}" if found else phrase("not stated")
        raise UnusableInput(
            phrase(
                "{file}: {channel}: {said}; use cuts of one material and tool, and state them "
                "in a column '{channel}' or in a side file",
                file=tables[0].path,
                channel=channel,
                said=said,
            )
        )
    return next(iter(found))
