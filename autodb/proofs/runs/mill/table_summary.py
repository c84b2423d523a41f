"""What reference tables showed: P4's model as published, autodb's and an oracle beside it."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from autodb.proofs.runs.found import Check, CheckedScore, TextTable, percent, ratio
from autodb.proofs.runs.mill.published_table import AIR, ALONG, REPEATS, SIDEWAYS, WITHIN
from autodb.proofs.runs.run_file import Finished, Origin
from autodb.proofs.runs.score import coverage_limits

PUBLISHED, OURS, KNOWN = "P4's model", "autodb", "the table's own forms"
"""Every way; the last one knows the table, and fits how hot it became."""
LAWS, WEIGHED, LEFT_IN = "the generator's laws", ", the work weighed", "left as it is read"
"""Who knows by what laws a table is drawn, not what was drawn; moves without the work beside those
with it; and a resonance or a drift that nothing is done about."""
COMPONENTS, ENVELOPES = ("x", "y", "z"), ("lower", "upper")
SETUPS = ("upright, repeated", "−20°, 31°", "−35°, −57°")
RATIO = 0.25
"""Times the error of P4's model that ours may have in tilted cuts, sideways and along."""
MASS = 0.005
"""Share by which the mass on the sensor may be off: in the median, and with the work weighed on the
worst of the machines."""
MASS_WAYS = (PUBLISHED, OURS, LAWS, OURS + WEIGHED, LAWS + WEIGHED)
RINGS = 0.25
"""Times the error of a dynamometer that rings, as it is read, that ours may have."""


@dataclass(frozen=True)
class TableGate:
    """Mean absolute error of P4's model from the mean of upright cuts, over P4's range: as printed.

    ``setup``: 0 for upright repeats; ``envelope`` 0 lower, 1 upper; ``component`` 0 to 2.
    """

    setup: int
    envelope: int
    component: int
    share: float


@dataclass(frozen=True)
class TableOff:
    """Mean absolute error of one way from the true force's envelope in a tilted cut, N."""

    way: str
    setup: int
    envelope: int
    component: int
    off_N: float


@dataclass(frozen=True)
class TableAir:
    """Mean absolute error of one way without a cut, over the range that was read."""

    way: str
    component: int
    share: float


@dataclass(frozen=True)
class TableIdentified:
    """A quantity that was identified, its standard deviation, and the truth; kg or m."""

    name: str
    truth: float
    value: float
    sd: float


@dataclass(frozen=True)
class TableHeld:
    """Share of a tilted cut's rows within 95 % intervals, whose median half width is ``width_N``.

    All three components together: a recording counts as one run.
    """

    setup: int
    share: float
    width_N: float


@dataclass(frozen=True)
class TableMass:
    """Share by which one way's mass on the sensor is off."""

    mass_way: str
    share: float


@dataclass(frozen=True)
class TableRinging:
    """Root mean square error of one way's force in a cut on a dynamometer that rings, N."""

    ringing_way: str
    component: int
    off_N: float


@dataclass(frozen=True)
class TableDrift:
    """Root mean square error of one way's drift of z in a long cut, N, and by how many time
    constants.
    """

    drift_way: str
    off_N: float
    times: int


Judged = (
    TableGate
    | TableOff
    | TableAir
    | TableIdentified
    | TableHeld
    | TableMass
    | TableRinging
    | TableDrift
)


@dataclass(frozen=True)
class MassRow:
    """One way to the mass: share by which it is off, the median and the worst of the machines."""

    way: str
    median: float
    worst: float


@dataclass(frozen=True)
class OffRow:
    """One way in tilted cuts: mean of both set-ups and envelopes, median of the machines, N."""

    way: str
    off_N: tuple[float, ...]

    @property
    def sideways_N(self) -> float:
        """Mean of x and y."""
        return (self.off_N[0] + self.off_N[1]) / 2.0


@dataclass(frozen=True)
class TableForcesSummary(CheckedScore):
    """What was found: medians of the machines, and coverage.

    ``gate``: by set-up, envelope and component, shares of the range; ``sideways`` and ``along``:
    the largest of a machine's tilted cuts; ``air``: shares of the range by way and component.
    """

    origin: Origin
    seeds: tuple[int, int]
    gate: tuple[TableGate, ...]
    sideways: float
    along: float
    off: tuple[OffRow, ...]
    air: tuple[TableAir, ...]
    mass_off: float
    masses: tuple[MassRow, ...]
    ringing: tuple[OffRow, ...]
    drift: tuple[tuple[str, float], ...]
    two_times: int
    identified_held: float
    identified: int
    rows_held: float
    recordings: int
    width_N: float

    def checks(self) -> list[Check]:
        """Return what is checked, what it is, what it must be, and whether it is."""
        by_way = {row.way: row for row in self.off}
        published, ours = by_way[PUBLISHED], by_way[OURS]
        sideways = ours.sideways_N / published.sideways_N
        along = ours.off_N[2] / published.off_N[2]
        low, high = ALONG - WITHIN, ALONG + WITHIN
        found = [
            (
                "gate: P4's model in tilted cuts, largest of x and y", percent(self.sideways),
                f"≤ {percent(SIDEWAYS)}", self.sideways <= SIDEWAYS,
            ),
            (
                "gate: the same in z", percent(self.along), f"{percent(low)} to {percent(high)}",
                low <= self.along <= high,
            ),
            ("tilted cuts: x and y, × P4's", ratio(sideways), f"≤ {RATIO}", sideways <= RATIO),
            ("tilted cuts: z, × P4's", ratio(along), f"≤ {RATIO}", along <= RATIO),
            (
                "mass on the sensor, off by", percent(self.mass_off), f"≤ {percent(MASS)}",
                self.mass_off <= MASS,
            ),
        ]  # fmt: skip
        mass = next(row.worst for row in self.masses if row.way == OURS + WEIGHED)
        found.append((
            "mass on the sensor, the work weighed, the worst machine", percent(mass),
            f"≤ {percent(MASS)}", mass <= MASS,
        ))  # fmt: skip
        rings = {row.way: row for row in self.ringing}
        for k, name in enumerate(COMPONENTS):
            share = rings[OURS].off_N[k] / rings[LEFT_IN].off_N[k]
            found.append((
                f"dynamometer that rings: {name}, × as it is read", ratio(share), f"≤ {RINGS}",
                share <= RINGS,
            ))  # fmt: skip
        for one in self.air:
            if one.way == OURS:
                what = f"turning in air, {COMPONENTS[one.component]}"
                limit = AIR[one.component]
                found.append((what, percent(one.share), f"≤ {percent(limit)}", one.share <= limit))
        for what, share, runs in (
            ("mass and lever arm within 95 % intervals", self.identified_held, self.identified),
            ("rows of tilted cuts within 95 % intervals", self.rows_held, self.recordings),
        ):
            least, most = coverage_limits(runs)
            limits = f"{percent(least)} to {percent(most)}"
            found.append((what, percent(share), limits, least <= share <= most))
        return found

    def tables(self) -> tuple[TextTable, ...]:
        """Return what must be, the gate as P4 prints it, and every way."""
        gate = tuple(
            (
                f"{COMPONENTS[k]}, {ENVELOPES[e]}",
                *(
                    percent(one.share)
                    for one in self.gate
                    if (one.component, one.envelope) == (k, e)
                ),
                percent(REPEATS[k][e]),
            )
            for k in range(3)
            for e in range(2)
        )
        air = {(one.way, one.component): one.share for one in self.air}
        off = tuple(
            (
                row.way, *(f"{one:.1f}" for one in row.off_N),
                *(percent(air.get((row.way, k))) for k in range(3)),
            )
            for row in self.off
        )  # fmt: skip
        return (
            self.limits("Limits"),
            TextTable(
                "P4's model from the mean of upright cuts, over the range, as P4's Table 2",
                ("envelope", *(f">{one}" for one in SETUPS), ">P4, upright"), gate,
            ),
            TextTable(
                "Error from the truth: N of envelopes in tilted cuts; of the range in air",
                ("way", ">x", ">y", ">z", ">air x", ">air y", ">air z"), off,
            ),
            TextTable(
                "Mass on the sensor: share by which it is off",
                ("way", ">median", ">the worst machine"),
                tuple((row.way, *map(hundredths, (row.median, row.worst))) for row in self.masses),
            ),
            TextTable(
                "A dynamometer that rings: rms error up to 1000 Hz in a tilted cut, N",
                ("way", ">x", ">y", ">z"),
                tuple((row.way, *(f"{one:.1f}" for one in row.off_N)) for row in self.ringing),
            ),
            TextTable(
                "Drift of z in long cuts: rms error, N",
                ("way", ">"),
                tuple((way, f"{off_N:.1f}") for way, off_N in self.drift),
            ),
            TextTable(
                "Beside them",
                ("", ">"),
                (
                    ("median half width of a force's 95 % interval", f"{self.width_N:.1f} N"),
                    ("long cuts whose drift has two time constants", f"{self.two_times}"),
                ),
            ),
        )  # fmt: skip


def table_summary_of(runs: Sequence[Finished[Judged]], origin: Origin) -> TableForcesSummary:
    """Return the summary of finished runs in the order of their seeds."""
    gates = [[one for one in run.judged if isinstance(one, TableGate)] for run in runs]
    identified = [one for run in runs for one in run.judged if isinstance(one, TableIdentified)]
    held = [one for run in runs for one in run.judged if isinstance(one, TableHeld)]
    drifts = [one for run in runs for one in run.judged if isinstance(one, TableDrift)]
    masses = tuple(_mass(way, runs) for way in MASS_WAYS)
    return TableForcesSummary(
        origin=origin,
        seeds=(runs[0].seed, runs[-1].seed),
        gate=tuple(_gate(s, e, k, gates) for s in range(3) for e in range(2) for k in range(3)),
        sideways=_largest(gates, (0, 1)),
        along=_largest(gates, (2,)),
        off=tuple(_off(way, runs) for way in (PUBLISHED, OURS, KNOWN)),
        air=tuple(_air(way, k, runs) for way in (PUBLISHED, OURS, KNOWN) for k in range(3)),
        mass_off=next(row.median for row in masses if row.way == OURS),
        masses=masses,
        ringing=tuple(_ringing(way, runs) for way in (LEFT_IN, OURS, KNOWN)),
        drift=tuple(
            (way, float(np.median([one.off_N for one in drifts if one.drift_way == way])))
            for way in (LEFT_IN, OURS, KNOWN)
        ),
        two_times=sum(one.times == 2 for one in drifts),
        identified_held=float(np.mean([abs(o.value - o.truth) <= 1.96 * o.sd for o in identified])),
        identified=len(identified),
        rows_held=float(np.mean([one.share for one in held])),
        recordings=len(held),
        width_N=float(np.median([one.width_N for one in held])),
    )


def _gate(
    setup: int, envelope: int, component: int, gates: Sequence[Sequence[TableGate]]
) -> TableGate:
    key = (setup, envelope, component)
    shares = [o.share for run in gates for o in run if (o.setup, o.envelope, o.component) == key]
    return TableGate(setup, envelope, component, float(np.median(shares)))


def _largest(gates: Sequence[Sequence[TableGate]], components: tuple[int, ...]) -> float:
    """Return the median of what is largest in a machine's tilted cuts."""
    return float(
        np.median(
            [max(o.share for o in run if o.setup and o.component in components) for run in gates]
        )
    )


def _off(way: str, runs: Sequence[Finished[Judged]]) -> OffRow:
    means = [
        [
            np.mean(
                [
                    o.off_N
                    for o in run.judged
                    if isinstance(o, TableOff) and (o.way, o.component) == (way, k)
                ]
            )
            for k in range(3)
        ]
        for run in runs
    ]
    return OffRow(way, tuple(float(one) for one in np.median(means, axis=0)))


def _air(way: str, component: int, runs: Sequence[Finished[Judged]]) -> TableAir:
    shares = [
        o.share
        for run in runs
        for o in run.judged
        if isinstance(o, TableAir) and (o.way, o.component) == (way, component)
    ]
    return TableAir(way, component, float(np.median(shares)))


def hundredths(share: float) -> str:
    """Return a share in percent, two decimals."""
    return f"{100.0 * share:.2f} %"


def _mass(way: str, runs: Sequence[Finished[Judged]]) -> MassRow:
    shares = [
        o.share for run in runs for o in run.judged
        if isinstance(o, TableMass) and o.mass_way == way
    ]  # fmt: skip
    return MassRow(way, float(np.median(shares)), max(shares))


def _ringing(way: str, runs: Sequence[Finished[Judged]]) -> OffRow:
    each = [
        [o.off_N for o in run.judged if isinstance(o, TableRinging) and o.ringing_way == way]
        for run in runs
    ]
    return OffRow(way, tuple(float(one) for one in np.median(each, axis=0)))
