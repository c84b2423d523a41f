"""The forces of a cut table with what is known of every cut, all components together.

Components share cuts and laws, so that they are fitted jointly: arrays are (C, n), component by
component, and white rows (C·n,) are what least squares sees.
"""

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from autodb.errors import UnusableInput
from autodb.records.tables import EDGE, CutTable
from autodb.wording import localized, phrase, significant

if TYPE_CHECKING:
    from autodb.explain.cuts.simulated_wear import SimulatedWear

Array = NDArray[np.float64]

GLITCH = 300.0
"""A force this many times the median is damage, not a cut."""
FEWEST = 6
NEVER_TURNED = frozenset({"slot", "side-up", "side-down", "ramp", "pocket", "drill"})
EDGE_SHARE = 0.02
"""A simulation has an edge force when it gives this share of its output, read by regression."""
ROUNDINGS_MM = (0.0, 0.003, 0.006, 0.01, 0.015, 0.02, 0.025, 0.03, 0.035, 0.04)
"""Thickness over which the edge of a simulation begins to plough; 0: at once."""
POWERS = np.linspace(0.5, 1.0, 51)
"""Powers of feed that the chip's part of a simulation may follow."""
THIN_CHIP_MM = 0.03
"""Uncut chip thickness below which edge force and size effect differ. Chosen."""
CHUNK = 4096
"""Cuts at a time: bounds the memory whatever the length of the table."""
VARIABLES = (
    "cutting.speed", "cutting.feed", "cutting.depth", "cutting.width", "work.diameter",
    "chip.thickness", "z.position", "tool.cutting_time",
)  # fmt: skip

FLANK_WEAR = "tool.flank_wear"
SETTINGS = ("cutting.speed", "cutting.feed", "cutting.depth", "cutting.width", "work.diameter")
CUTS_A_LEVEL = 6
"""Cuts that a level of a setting has, in the mean at least, where the table is a design. Chosen."""
FOLLOWS = 0.9
"""Share of a course over the cuts that settings explain where it follows them. Chosen."""


@dataclass(frozen=True)
class Conditions:
    """What is known of every cut, (n,); depth is 1 where it was not recorded.

    ``cutting_time_s``: of the edge before the cut; where that was not recorded, the clock since the
    edge's first cut, of one edge if none was recorded (``by_clock``). ``land_mm``: the flank wear
    measured in each cut, where no cutting time was recorded. ``turns``: whether the cuts are
    turned, as far as known.
    ``other``: every recorded variable that varies by its channel's name, those above included;
    ``recorded`` the names of all that were recorded.
    """

    number: Array
    t_s: Array
    depth_mm: Array
    thickness_mm: Array | None
    speed_m_min: Array | None
    edge: Array | None
    edge_label: dict[float, str]
    cutting_time_s: Array | None
    other: dict[str, Array] = field(default_factory=dict)
    recorded: frozenset[str] = frozenset()
    by_clock: bool = False
    turns: bool = True
    land_mm: Array | None = None

    def __len__(self) -> int:
        return len(self.number)

    @property
    def edges(self) -> Array:
        """The edges in use."""
        return np.unique(self.edge) if self.edge is not None else np.array([])

    @property
    def by_land(self) -> bool:
        """Whether wear is known by the flank wear, which differs from cut to cut."""
        return self.land_mm is not None and bool(np.ptp(self.land_mm) > 0)


@dataclass(frozen=True)
class Stack:
    """Recording and simulation (C, n); ``chip`` the part of the simulation that a chip gives.

    ``wear``: that of the simulation, None where it has none or it was not read off; ``exponents``
    (C,): those of its softening with speed, None where it has none.

    ``edge_N_mm`` (C,): the edge force that the simulation has, ``edge_mm`` (C, n) the length that
    it acts on; ``sd`` (C, n); ``mixing`` (C, C) makes the components of one cut, each over its sd,
    independent. ``like``: the table that these cuts follow, where they are others: scales, knots
    and signs are taken from it.
    """

    names: tuple[str, ...]
    known: Conditions
    recording: Array
    simulation: Array
    edge_N_mm: Array
    edge_mm: Array
    sd: Array
    mixing: Array
    like: "Stack | None" = None
    wear: "SimulatedWear | None" = None
    exponents: Array | None = None

    @property
    def frame(self) -> "Stack":
        """The table that scales, knots and signs are taken from."""
        return self if self.like is None else self.like

    @property
    def wear_goes_with(self) -> Array | None:
        """What wear grows with, (n,): the cutting time or, where the table is by it, the land."""
        return self.known.land_mm if self.frame.known.by_land else self.known.cutting_time_s

    @property
    def row(self) -> Array:
        """Number of each cut's row in the table, those that follow it counted on, (n,)."""
        first = 0 if self.like is None else len(self.like.known)
        return np.arange(first, first + len(self.known), dtype=np.float64)

    @property
    def chip(self) -> Array:
        """Simulated force without that of the edge and of its wear, (C, n)."""
        return self.simulation - self.edge_N_mm[:, None] * self.edge_mm - self.worn

    @property
    def worn(self) -> Array:
        """Simulated force that wear has added, (C, n)."""
        none = np.zeros_like(self.simulation)
        return none if self.wear is None else self.wear.force(self.known)

    @property
    def sign(self) -> Array:
        """Direction in which each component's simulation points, (C,)."""
        signs = np.sign(np.median(self.frame.simulation, axis=1))
        return np.asarray(np.where(signs == 0, 1.0, signs), dtype=np.float64)

    @property
    def chunks(self) -> list[slice]:
        """Rows of the table, so many at a time."""
        n = len(self.known)
        return [slice(start, min(start + CHUNK, n)) for start in range(0, n, CHUNK)]

    def white(self, raw: Array, rows: slice = slice(None)) -> Array:
        """Return white rows (C·m, p) of raw columns (C, m, p) [N] of some cuts."""
        scaled = raw / self.sd[:, rows, None]
        mixed = np.tensordot(self.mixing, scaled, axes=1)
        return np.asarray(mixed.reshape(raw.shape[0] * raw.shape[1], raw.shape[2]))

    @property
    def difference(self) -> Array:
        """White difference, (C·n,)."""
        return self.white((self.recording - self.simulation)[:, :, None])[:, 0]


def tells_edge_from_size(known: Conditions) -> bool:
    """Return whether some chip is so thin that an edge's force and a size effect differ."""
    return known.thickness_mm is not None and float(known.thickness_mm.min()) <= THIN_CHIP_MM


def table_conditions(table: CutTable) -> Conditions:
    """Return the conditions of a table's cuts; one that some cut lacks is not used.

    Raises UnusableInput where a depth, feed or speed is not above zero.
    """

    def known(name: str) -> Array | None:
        values = table.get(name)
        return None if values is None or not np.isfinite(values).all() else values

    for name in ("cutting.depth", "cutting.feed", "cutting.speed"):
        values = known(name)
        if values is not None and values.min() <= 0:
            row = int(np.argmin(values))
            raise UnusableInput(
                phrase(
                    "{file}: {name}, row {row} (cut {cut}): {values} is not a cut; remove that row",
                    file=table.path,
                    name=name,
                    row=row + 1,
                    cut=localized(f"{table.cut[row]:g}"),
                    values=localized(f"{values[row]:g}"),
                )
            )
    depth, edge, feed = known("cutting.depth"), known(EDGE), known("cutting.feed")
    thickness, clock = known("chip.thickness"), known("t")
    time = known("tool.cutting_time")
    by_clock = time is None and clock is not None
    land = known(FLANK_WEAR) if time is None else None
    if edge is None and EDGE not in table and (time is not None or by_clock):
        edge = np.zeros(len(table))
    if time is None and clock is not None and edge is not None:
        time = _since_first_cut(clock, edge)
    labels = table.texts.get(EDGE) or ([] if edge is None else [f"{e:g}" for e in edge])
    other = {name: values for name in VARIABLES if (values := known(name)) is not None}
    other |= {} if land is None else {FLANK_WEAR: land}
    return Conditions(
        number=table.cut,
        t_s=table.cut if clock is None else clock,
        depth_mm=np.ones(len(table)) if depth is None else depth,
        thickness_mm=feed if thickness is None or thickness.min() <= 0 else thickness,
        speed_m_min=known("cutting.speed"),
        edge=edge,
        edge_label={} if edge is None else dict(zip(edge.tolist(), labels, strict=True)),
        cutting_time_s=time if edge is not None else None,
        other={name: values for name, values in other.items() if np.ptp(values) > 0},
        recorded=frozenset([*other, *([] if clock is None else ["t"])]),
        by_clock=by_clock,
        turns=not NEVER_TURNED.intersection(table.texts.get("operation", ())),
        land_mm=land,
    )


def _since_first_cut(clock_s: Array, edge: Array) -> Array:
    """Return the time since the first cut of each cut's edge (n,)."""
    first = {one: float(clock_s[edge == one].min()) for one in np.unique(edge).tolist()}
    return np.asarray(clock_s - np.array([first[one] for one in edge.tolist()]))


def recorded_and_simulated(table: CutTable, simulation: dict[str, Array]) -> tuple[Array, Array]:
    """Return recording and simulation (C, n).

    Raises UnusableInput for too few cuts, a simulation of zeros, and a force that is damage.
    """
    if len(table) < FEWEST:
        raise UnusableInput(
            phrase(
                "{file}: {n} cuts are too few to explain; use at least {fewest}",
                file=table.path,
                n=len(table),
                fewest=FEWEST,
            )
        )
    for name, force in simulation.items():
        _check(table, name, force)
    return np.stack([table[name] for name in simulation]), np.stack(list(simulation.values()))


def _check(table: CutTable, name: str, simulation: Array) -> None:
    if not np.any(simulation):
        raise UnusableInput(
            phrase("{name} of the simulation is zero in every cut: nothing to re-tune", name=name)
        )
    usual = max(float(np.median(np.abs(table[name]))), 1e-12)
    row = int(np.argmax(np.abs(table[name])))
    if abs(table[name][row]) > GLITCH * usual:
        raise UnusableInput(
            phrase(
                "{file}: {name}, row {row} (cut {cut}): {table} N is {glitch} times the "
                "median; remove that row",
                file=table.path,
                name=name,
                row=row + 1,
                cut=localized(f"{table.cut[row]:g}"),
                table=significant(table[name][row]),
                glitch=localized(f"{GLITCH:g}"),
            )
        )


def edge_read_off(
    simulation: Array, known: Conditions, softening: Array | None = None
) -> tuple[Array, Array]:
    """Return the edge coefficient [N/mm] of each component (C, n) of a simulation, and its shape.

    Read by regression on a_p·h^q s and a_p·(1 − e^(−h/h_p)) with the power q and the rounding h_p
    that fit best, s the chip's ``softening`` by the speed (C, n), 1 without; the shape (C, n) [mm]
    is a_p times what is in brackets. Zero where the thickness is not known or hardly varies.
    """
    thickness, count = known.thickness_mm, len(simulation)
    plain = np.tile(known.depth_mm, (count, 1))
    if thickness is None or float(np.ptp(np.log(thickness))) < 0.05:
        return np.zeros(count), plain
    factors = np.ones_like(simulation) if softening is None else softening
    found = [
        _edge_of(part, known.depth_mm, thickness, factor)
        for part, factor in zip(simulation, factors, strict=True)
    ]
    return np.array([value for value, _ in found]), np.array([shape for _, shape in found])


def _edge_of(
    simulation: Array, depth_mm: Array, thickness_mm: Array, softening: Array
) -> tuple[float, Array]:
    best, found, length = np.inf, 0.0, depth_mm
    for rounding in ROUNDINGS_MM:
        shape = depth_mm * (-np.expm1(-thickness_mm / rounding) if rounding else 1.0)
        for power in POWERS:
            design = np.column_stack([depth_mm * thickness_mm**power * softening, shape])
            inner = design.T @ design
            if np.linalg.cond(inner) > 1e12:
                continue
            coefficients = np.linalg.solve(inner, design.T @ simulation)
            left = float(np.sum((simulation - design @ coefficients) ** 2))
            if left < 0.9 * best:
                best, found, length = left, float(coefficients[1]), shape
    is_there = np.linalg.norm(found * length) > EDGE_SHARE * np.linalg.norm(simulation)
    if is_there and np.sign(found) == np.sign(simulation.sum()):
        return found, length
    return 0.0, depth_mm


@dataclass(frozen=True)
class CutDesign:
    """Settings of which the cuts of a table have a few: an orthonormal basis (n, q) of their
    levels, the mean among them.
    """

    basis: Array

    @property
    def levels(self) -> bool:
        """Say whether a setting has levels at all."""
        return bool(self.basis.shape[1] > 1)

    def holds(self, courses: Array) -> bool:
        """Say whether courses over the cuts (n, k) follow the settings."""
        apart = courses - courses.mean(axis=0)
        left = apart - self.basis @ (self.basis.T @ apart)
        return bool(np.sum(left**2) <= (1.0 - FOLLOWS) * np.sum(apart**2))


def designed(stack: Stack) -> CutDesign:
    """Return the settings of a table's cuts that have several cuts a level."""
    n, columns = len(stack.known), [np.ones((len(stack.known), 1))]
    for name in SETTINGS:
        values = stack.known.other.get(name)
        if values is not None:
            levels = np.unique(values)
            if len(levels) <= n / CUTS_A_LEVEL:
                columns.append(1.0 * (values[:, None] == levels))
    left, sizes, _ = np.linalg.svd(np.concatenate(columns, axis=1), full_matrices=False)
    return CutDesign(left[:, sizes > 1e-9 * sizes[0]])
