"""Columns that the forces of a cut table can be made of, all components stacked.

Rows of the stack are component by component; each is divided by its standard deviation
√(a² + b²F²), so that the stack is white.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import nnls

from autodb.errors import UnusableInput
from autodb.explain.fit import estimate
from autodb.explain.search import Block
from autodb.records import EDGE, CutTable
from autodb.terms.process import edge_force, tool_wear

Array = NDArray[np.float64]

GLITCH = 300.0
"""A force this many times the median is damage, not a cut."""
EDGE_SHARE = 0.02
"""A simulation has an edge force when it gives this share of its output, read by regression."""


@dataclass(frozen=True)
class Conditions:
    """What is known of every cut, (n,); depth is 1 where it was not recorded."""

    number: Array
    depth_mm: Array
    feed_mm: Array | None
    speed_m_min: Array | None
    edge: Array | None
    edge_label: dict[float, str]
    cutting_time_s: Array | None

    @property
    def edges(self) -> Array:
        """The edges in use."""
        return np.unique(self.edge) if self.edge is not None else np.array([])


@dataclass
class Stack:
    """Components stacked: difference, simulation and sd (C·n,), in the order of ``names``."""

    names: list[str]
    conditions: Conditions
    recording: Array
    simulation: Array
    sd: Array

    @property
    def difference(self) -> Array:
        """White difference, (C·n,)."""
        return (self.recording - self.simulation) / self.sd

    def per_component(self, column: Array) -> Array:
        """Return white columns (C·n, C): the column (n,) of each cut for each component alone."""
        n, count = len(column), len(self.names)
        block = np.zeros((n * count, count))
        for i in range(count):
            block[i * n : (i + 1) * n, i] = column
        return block / self.sd[:, None]

    def each(self, columns: Array) -> Array:
        """Return white columns (C·n, C·p) of columns (n, p), free for each component."""
        return np.column_stack([self.per_component(column) for column in columns.T])

    def simulated(self) -> Array:
        """Return the white simulation as one column (C·n, 1): the shared factor of shear."""
        return (self.simulation / self.sd)[:, None]


def conditions(table: CutTable) -> Conditions:
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
                f"{table.path}: {name}, row {row + 1} (cut {table.cut[row]:g}): {values[row]:g} is "
                "no cut; the table without it would work"
            )
    depth, edge = known("cutting.depth"), known(EDGE)
    labels = table.texts.get(EDGE) or ([] if edge is None else [f"{e:g}" for e in edge])
    return Conditions(
        number=table.cut,
        depth_mm=np.ones(len(table)) if depth is None else depth,
        feed_mm=known("cutting.feed"),
        speed_m_min=known("cutting.speed"),
        edge=edge,
        edge_label={} if edge is None else dict(zip(edge.tolist(), labels, strict=True)),
        cutting_time_s=known("tool.cutting_time") if edge is not None else None,
    )


def stack(table: CutTable, simulation: dict[str, Array]) -> Stack:
    """Stack the components; the standard deviations come from what a rich model leaves.

    Raises UnusableInput when the cuts are fewer than its columns allow.
    """
    known = conditions(table)
    if len(table) < 8:
        raise UnusableInput(f"{table.path}: {len(table)} cuts are too few to explain; 8 would work")
    for name, force in simulation.items():
        _check(table, name, force)
    sd = [_sd(table[name], simulation[name], known) for name in simulation]
    return Stack(
        names=list(simulation),
        conditions=known,
        recording=np.concatenate([table[name] for name in simulation]),
        simulation=np.concatenate(list(simulation.values())),
        sd=np.concatenate(sd),
    )


def _check(table: CutTable, name: str, simulation: Array) -> None:
    if not np.any(simulation):
        raise UnusableInput(f"{name} of the simulation is zero in every cut: nothing to re-tune")
    usual = max(float(np.median(np.abs(table[name]))), 1e-12)
    row = int(np.argmax(np.abs(table[name])))
    if abs(table[name][row]) > GLITCH * usual:
        raise UnusableInput(
            f"{table.path}: {name}, row {row + 1} (cut {table.cut[row]:g}): "
            f"{table[name][row]:.3g} N is {GLITCH:g} times the usual; without it it would work"
        )


def _sd(recording: Array, simulation: Array, known: Conditions) -> Array:
    """Return √(a² + b²F²) (n,), a and b from the squares that a rich model leaves."""
    n = len(recording)
    columns = [simulation, known.depth_mm]
    if known.cutting_time_s is not None:
        wear = tool_wear(known.depth_mm, known.cutting_time_s)
        columns += [wear, wear * known.cutting_time_s]
        if n > 10 * len(known.edges):
            columns += [wear * (known.edge == edge) for edge in known.edges[1:]]
    if n > 40:
        columns += [known.depth_mm * c for c in _bumps(known.number, 5).T]
        if known.speed_m_min is not None:
            columns += [simulation * c for c in _bumps(np.log(known.speed_m_min), 4).T]
    design = np.column_stack(columns)
    difference = recording - simulation
    left = difference - design @ estimate(design, difference).coefficients
    square = left**2 * n / max(1, n - np.linalg.matrix_rank(design))
    (a2, b2), _ = nnls(np.column_stack([np.ones(n), simulation**2]), square)
    sd = np.sqrt(a2 + b2 * simulation**2)
    floor = 1e-6 * float(np.max(np.abs(recording))) + 1e-12
    return np.asarray(np.maximum(sd, floor), dtype=np.float64)


def _bumps(values: Array, count: int) -> Array:
    """Return ``count`` Gaussian bumps over the values' range, (n, count)."""
    low, high = float(values.min()), float(values.max())
    width = (high - low) / max(1, count - 1) or 1.0
    centres = np.linspace(low, high, count)
    return np.asarray(np.exp(-0.5 * ((values[:, None] - centres) / width) ** 2))


def own_columns(stacked: Stack, includes: list[str] | None) -> dict[str, Array]:
    """Return the simulation's own columns: shear as a shared factor, edge force per component."""
    known = stacked.conditions
    own = {"shear": stacked.simulated()}
    has_edge = _has_edge(stacked) if includes is None else "edge_force" in includes
    if has_edge:
        own["edge_force"] = stacked.per_component(edge_force(known.depth_mm))
    if includes is not None and "tool_wear" in includes and known.cutting_time_s is not None:
        own["tool_wear"] = stacked.per_component(tool_wear(known.depth_mm, known.cutting_time_s))
    return own


def _has_edge(stacked: Stack) -> bool:
    known, edge = stacked.conditions, edge_read_off(stacked)
    n = len(known.depth_mm)
    sim = stacked.simulation.reshape(-1, n)
    return any(
        np.linalg.norm(k * known.depth_mm) > EDGE_SHARE * np.linalg.norm(part)
        for k, part in zip(edge, sim, strict=True)
    )


def edge_read_off(stacked: Stack) -> Array:
    """Return the edge coefficient [N/mm] that each component of the simulation has, (C,).

    Read by regression on a_p·f and a_p; zero where the feed is not known.
    """
    known = stacked.conditions
    if known.feed_mm is None:
        return np.zeros(len(stacked.names))
    design = np.column_stack([known.depth_mm * known.feed_mm, edge_force(known.depth_mm)])
    sim = stacked.simulation.reshape(-1, len(known.depth_mm))
    return np.array([np.linalg.lstsq(design, part, rcond=None)[0][1] for part in sim])


def blocks(stacked: Stack, own: dict[str, Array]) -> list[Block]:
    """Return the candidates: edge force, wear, and unnamed families over what was recorded."""
    known, found = stacked.conditions, []
    if "edge_force" not in own and known.feed_mm is not None:
        columns = stacked.per_component(edge_force(known.depth_mm))
        found.append(Block("edge_force", "edge_force", columns, ("cutting.feed", "cutting.depth")))
    if "tool_wear" not in own and known.cutting_time_s is not None and len(known.edges):
        columns = stacked.per_component(tool_wear(known.depth_mm, known.cutting_time_s))
        found.append(Block("tool_wear", "tool_wear", columns, ("tool.cutting_time", "tool.edge")))
    return [*found, *_families(stacked)]


def _families(stacked: Stack) -> list[Block]:
    known = stacked.conditions
    n, depth = len(known.depth_mm), known.depth_mm[:, None]
    sim = stacked.simulation.reshape(len(stacked.names), n)
    small = int(np.clip(n // 10, 2, 5))
    families = [
        ("cut number", stacked.each(depth * _bumps(known.number, small)), ("cut",)),
        ("offset over cuts", stacked.each(_bumps(known.number, small)), ("cut",)),
        ("component", _one_factor_each(stacked, sim, np.ones((n, 1))), ()),
    ]
    for label, name, values in (
        ("speed", "cutting.speed", known.speed_m_min),
        ("feed", "cutting.feed", known.feed_mm),
        ("depth", "cutting.depth", known.depth_mm),
    ):
        if values is not None and float(np.ptp(values)) > 0:
            bumps = _bumps(np.log(values), min(small, len(np.unique(values))))
            families.append((label, _one_factor_each(stacked, sim, bumps), (name,)))
    return [Block(key, "unknown", columns, variables) for key, columns, variables in families]


def _one_factor_each(stacked: Stack, sim: Array, factors: Array) -> Array:
    """Return white columns: each component's simulation times each factor (n, p)."""
    columns = []
    for i, component in enumerate(sim):
        for factor in factors.T:
            whole = np.zeros_like(sim)
            whole[i] = component * factor
            columns.append(whole.ravel() / stacked.sd)
    return np.column_stack(columns)


def run_block(stacked: Stack, left: Array) -> Block:
    """Return the run of cuts in which a factor on all forces explains most of what is left."""
    n = len(stacked.conditions.number)
    white = stacked.simulated()[:, 0].reshape(-1, n)
    product = np.concatenate([[0.0], np.cumsum(np.sum(white * left.reshape(-1, n), axis=0))])
    weight = np.concatenate([[0.0], np.cumsum(np.sum(white**2, axis=0))])
    with np.errstate(divide="ignore", invalid="ignore"):
        gain = (product[None, :] - product[:, None]) ** 2 / (weight[None, :] - weight[:, None])
    span = np.arange(n + 1)[None, :] - np.arange(n + 1)[:, None]
    gain[(span < 2) | (span > 0.8 * n)] = -np.inf
    start, end = np.unravel_index(int(np.argmax(gain)), gain.shape)
    inside = np.zeros(n)
    inside[start:end] = 1.0
    column = (white * inside).ravel()[:, None]
    return Block("run of cuts", "unknown", column, ("cut",), tries=n * n // 2, extra_parameters=2)


def wear_shape(stacked: Stack) -> Array:
    """Return free columns for what one straight wear line gets wrong: bow, each edge's rate."""
    known = stacked.conditions
    assert known.cutting_time_s is not None  # wear is only named where it was recorded
    wear = tool_wear(known.depth_mm, known.cutting_time_s)
    scale = max(float(known.cutting_time_s.max()), 1e-9)
    columns = [wear * (known.cutting_time_s / scale - 0.5)]
    if len(known.number) >= 8 * len(known.edges):
        columns += [wear * (known.edge == edge) for edge in known.edges[1:]]
    return stacked.each(np.column_stack(columns))
