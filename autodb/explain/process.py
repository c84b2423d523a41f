"""Explain the forces of a table of cuts, all components together."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from autodb.explain import cuts, search
from autodb.explain.answer import Cause, ChannelAnswer, Considered, FitQuality, Trace, Value, Where
from autodb.explain.causes import ALIKE, NORMAL_95
from autodb.explain.cuts import Stack
from autodb.explain.fit import Estimate, estimate, rms
from autodb.explain.locate import regimes
from autodb.records import CutTable
from autodb.sensing.axis_model import term_called
from autodb.terms.process import tool_wear

Array = NDArray[np.float64]

THIN_CHIP_MM = 0.03
"""Uncut chip thickness below which edge force and size effect differ (physics of section 8)."""
FOLDS = 5
BLOCKS = 20


@dataclass
class _Search:
    stacked: Stack
    own: dict[str, Array]
    blocks: dict[str, search.Block]
    active: list[str] = field(default_factory=list)
    chosen: dict[str, dict[str, float]] = field(default_factory=dict)
    first: dict[str, float] = field(default_factory=dict)
    shape: Array | None = None
    bend: Array = field(default_factory=lambda: np.empty(0))

    def columns(self, keys: list[str]) -> Array:
        """Return named or unnamed blocks, then the own columns, (C·n, p)."""
        return np.column_stack([*(self.blocks[k].columns for k in keys), *self.own.values()])

    def all_columns(self, keys: list[str]) -> Array:
        """Return the same and the shape of wear, where it is kept."""
        return np.column_stack([self.columns(keys), *self._shape()])

    def gram(self, *, shape: bool) -> search.Gram:
        """Return the inner products; ``shape`` frees the shape of wear, while others are sought."""
        own = np.column_stack([*self.own.values(), *(self._shape() if shape else ())])
        return search.Gram(own, list(self.blocks.values()), self.stacked.difference)

    def _shape(self) -> list[Array]:
        return [] if self.shape is None else [self.shape]


def explain_cuts(
    table: CutTable, simulation: dict[str, Array], includes: list[str] | None
) -> dict[str, tuple[ChannelAnswer, Trace]]:
    """Say what the simulation of a cut table's forces leaves out, by channel.

    ``simulation``: force channel → (n,) in the table's order of cuts.
    """
    stacked = cuts.stack(table, simulation)
    own = cuts.own_columns(stacked, includes)
    found = _Search(stacked, own, {b.key: b for b in cuts.blocks(stacked, own)})
    _run(found)
    keys = [k for k in found.active if found.blocks[k].term != "unknown"]
    keys += [k for k in found.active if found.blocks[k].term == "unknown"]
    fitted = estimate(found.columns(keys), stacked.difference)
    part = found.columns(keys) @ fitted.coefficients
    found.bend = _bend(found, stacked.difference - part)
    return {name: _channel(found, keys, fitted, i, table) for i, name in enumerate(stacked.names)}


def _bend(found: _Search, left: Array) -> Array:
    """Return what the shape of wear adds to the straight lines, white, (C·n,); fitted second."""
    if found.shape is None:
        return np.zeros_like(left)
    return found.shape @ estimate(found.shape, left).coefficients


def _run(found: _Search) -> None:
    for _ in range(search.MAX_STEPS):
        now = found.all_columns(found.active)
        difference = found.stacked.difference
        left = difference - now @ estimate(now, difference).coefficients
        if "run of cuts" not in found.active:
            found.blocks["run of cuts"] = cuts.run_block(found.stacked, left)
        step = search.step(found.gram(shape=True), found.active, list(found.blocks.values()))
        if step is None:
            break
        found.first = found.first or step.evidence
        if not step.accepted:
            break
        key = step.best.key
        found.active.append(key)
        found.chosen[key] = step.evidence
        if key == "tool_wear":
            found.shape = cuts.wear_shape(found.stacked)
    gram = found.gram(shape=False)
    found.active = search.eliminate(gram, found.active, list(found.blocks.values()))
    _veto(found)


def _veto(found: _Search) -> None:
    """Keep what predicts cuts left out of the fit: the shape of wear, and the causes as a whole."""
    with_shape, shape = _held_out(found, found.active), found.shape
    found.shape = None
    without = _held_out(found, found.active)
    if "tool_wear" in found.active and with_shape < without:
        found.shape = shape
    if min(with_shape, without) >= rms(found.stacked.difference):
        found.active, found.shape = [], None


def _held_out(found: _Search, keys: list[str]) -> float:
    return rms(_held_out_rows(found, keys))


def _held_out_rows(found: _Search, keys: list[str]) -> Array:
    """Return the white residual of cuts whose block of neighbours was left out of the fit."""
    difference, columns = found.stacked.difference, found.all_columns(keys)
    n, count = len(found.stacked.conditions.number), len(found.stacked.names)
    fold = np.tile((np.arange(n) * min(BLOCKS, n) // n) % FOLDS, count)
    norm = np.linalg.norm(columns, axis=0)
    left = np.empty_like(difference)
    for number in range(FOLDS):
        test = fold == number
        fitted = estimate(columns[~test], difference[~test], norm=norm, weakest=1e-5)
        left[test] = difference[test] - columns[test] @ fitted.coefficients
    return left


def _channel(
    found: _Search, keys: list[str], fitted: Estimate, index: int, table: CutTable
) -> tuple[ChannelAnswer, Trace]:
    """Return the answer of one component and its traces."""
    stacked = found.stacked
    n = len(stacked.conditions.number)
    rows = slice(index * n, (index + 1) * n)
    causes = _causes(found, keys, fitted, index)
    recording, simulation, sd = (
        a[rows] for a in (stacked.recording, stacked.simulation, stacked.sd)
    )
    part = (found.columns(keys) @ fitted.coefficients + found.bend)[rows] * sd
    correction = part if causes else np.zeros(n)
    held = _held_out_rows(found, keys)[rows] * sd if causes else recording - simulation
    answer = ChannelAnswer(
        unit=table.unit(stacked.names[index]),
        mismatch=bool(causes),
        where=Where(
            intervals=_runs(found, keys, causes),
            regime=tuple(regimes(correction, _signals(stacked)) if causes else ()),
        ),
        missing=tuple(causes),
        fit=FitQuality(
            rms_before=rms(recording - simulation),
            rms_after=rms(recording - simulation - correction),
            heldout_before=rms(recording - simulation),
            heldout_after=rms(held),
            noise_floor=rms(sd),
        ),
    )
    trace = Trace(
        x_name="cut",
        x=stacked.conditions.number,
        recording=recording,
        simulation=simulation,
        corrected=simulation + correction,
        regime_signals=_signals(stacked),
        considered=tuple(
            Considered(k, v, "accepted" if k in keys else "not needed")
            for k, v in sorted(found.first.items(), key=lambda item: -item[1])
        ),
    )
    return answer, trace


def _signals(stacked: Stack) -> dict[str, Array]:
    known = stacked.conditions
    return {
        name: values
        for name, values in (
            ("tool.cutting_time", known.cutting_time_s),
            ("cutting.feed", known.feed_mm),
            ("cutting.speed", known.speed_m_min),
        )
        if values is not None and float(np.ptp(values)) > 0
    }


def _runs(found: _Search, keys: list[str], causes: list[Cause]) -> tuple[tuple[float, float], ...]:
    if "run of cuts" not in keys or not causes:
        return ()
    n = len(found.stacked.conditions.number)
    inside = np.flatnonzero(found.blocks["run of cuts"].columns[:n, 0])
    number = found.stacked.conditions.number
    return ((float(number[inside[0]]), float(number[inside[-1]])),)


def _causes(found: _Search, keys: list[str], fitted: Estimate, index: int) -> list[Cause]:
    """Return the causes seen in one component: those whose coefficient there is not nothing."""
    causes: list[Cause] = []
    shapes = [k for k in keys if found.blocks[k].term == "unknown"]
    for at, key in enumerate(k for k in keys if k not in shapes):
        place = at * len(found.stacked.names) + index
        value, sd = float(fitted.coefficients[place]), float(fitted.sd[place])
        if abs(value) > NORMAL_95 * sd:
            causes.append(_named(found, key, fitted, place, index))
    if shapes:
        causes.append(_unknown(found, shapes, fitted, keys, index))
    return [*causes, *_mistuned(found, keys, fitted, index)]


def _named(found: _Search, key: str, fitted: Estimate, place: int, index: int) -> Cause:
    """Return the entry of a term in component ``index``, whose coefficient is at ``place``."""
    term, known = term_called(key), found.stacked.conditions
    if key == "tool_wear":
        parameters = _rates(found, index)
        alternatives = () if len(known.edges) > 1 else ("sensor_drift",)
    else:
        half = NORMAL_95 * float(fitted.sd[place])
        parameters = {"coefficient": _value(float(fitted.coefficients[place]), half, "N/mm")}
        thin = known.feed_mm is not None and float(known.feed_mm.min()) <= THIN_CHIP_MM
        alternatives = () if thin else ("size_effect",)
    size = _size(found, key, fitted, place, index)
    return Cause(
        term=term.name,
        kind="missing",
        confidence=_sure(found, key, alternatives),
        statement=(
            f"{term.statement} The simulation leaves it out: up to {size.value:.0f} N "
            f"({size.low:.0f} to {size.high:.0f})."
        ),
        parameters={"size": size, **parameters},
        alternatives=alternatives,
        variables=found.blocks[key].variables,
        to_tell_apart=f"Make {term.excited_by}." if alternatives else None,
    )


def _size(found: _Search, key: str, fitted: Estimate, place: int, index: int) -> Value:
    """Return the largest contribution, with the free shape of wear in it."""
    stacked = found.stacked
    n = len(stacked.conditions.number)
    rows = slice(index * n, (index + 1) * n)
    column = found.blocks[key].columns[rows, index] * stacked.sd[rows]
    force = fitted.coefficients[place] * column
    if key == "tool_wear":
        force = force + found.bend[rows] * stacked.sd[rows]
    at = int(np.argmax(np.abs(force)))
    half = NORMAL_95 * float(fitted.sd[place]) * abs(float(column[at]))
    return _value(abs(float(force[at])), half, "N")


def _sure(found: _Search, key: str, alternatives: tuple[str, ...]) -> float:
    return search.confidence(found.chosen[key], key) / (1 + len(alternatives))


def _value(value: float, half: float, unit: str) -> Value:
    return Value(value=value, low=value - half, high=value + half, unit=unit)


def _rates(found: _Search, index: int) -> dict[str, Value]:
    """Return the mean wear rate and each edge's own, at the mean depth, as straight lines."""
    known = found.stacked.conditions
    assert known.edge is not None
    assert known.cutting_time_s is not None
    wear = tool_wear(known.depth_mm, known.cutting_time_s)
    usable = [e for e in known.edges if np.ptp(known.cutting_time_s[known.edge == e]) > 0]
    by_edge = [wear * (known.edge == edge) for edge in usable]
    rates = {"rate": _straight(found, wear[:, None], index)[0]}
    if len(usable) > 1:
        values = _straight(found, np.column_stack(by_edge), index)
        rates |= {
            f"rate edge {known.edge_label[float(e)]}": v
            for e, v in zip(usable, values, strict=True)
        }
    return rates


def _straight(found: _Search, wear: Array, index: int) -> list[Value]:
    """Return the rates of wear columns (n, p) in one component, beside the own columns."""
    stacked = found.stacked
    columns = np.column_stack([stacked.each(wear), *found.own.values()])
    fitted = estimate(columns, stacked.difference)
    depth, count = float(stacked.conditions.depth_mm.mean()), len(stacked.names)
    places = [at * count + index for at in range(wear.shape[1])]
    return [
        _value(
            float(fitted.coefficients[place]) * depth,
            NORMAL_95 * float(fitted.sd[place]) * depth,
            "N/s",
        )
        for place in places
    ]


def _unknown(
    found: _Search, shapes: list[str], fitted: Estimate, keys: list[str], index: int
) -> Cause:
    stacked = found.stacked
    n = len(stacked.conditions.number)
    rows = slice(index * n, (index + 1) * n)
    before = sum(found.blocks[k].columns.shape[1] for k in keys if k not in shapes)
    columns = np.column_stack([found.blocks[k].columns for k in shapes])
    part = (columns @ fitted.coefficients[before : before + columns.shape[1]])[rows]
    force = part * stacked.sd[rows]
    difference = (stacked.recording - stacked.simulation)[rows]
    share = 1.0 - float(np.sum((difference - force) ** 2) / np.sum(difference**2))
    peak = float(np.max(np.abs(force)))
    variables = tuple(dict.fromkeys(v for k in shapes for v in found.blocks[k].variables))
    return Cause(
        term="unknown",
        kind="missing",
        confidence=max(search.confidence(found.chosen[k], k) for k in shapes),
        statement=(
            f"{100 * max(0.0, share):.0f} % of the error depends on {' and '.join(shapes)}; "
            f"no named law fits it. It reaches {peak:.0f} N."
        ),
        parameters={"size": Value(value=peak, low=peak, high=peak, unit="N")},
        alternatives=tuple(dict.fromkeys(a for k in shapes for a in ALIKE.get(k, ()))),
        variables=variables,
    )


def _mistuned(found: _Search, keys: list[str], fitted: Estimate, index: int) -> list[Cause]:
    """Return the simulation's own terms that the recording contradicts: each judged as a whole."""
    causes: list[Cause] = []
    place = sum(found.blocks[k].columns.shape[1] for k in keys)
    for name, columns in found.own.items():
        width = columns.shape[1]
        at = place + (index if width > 1 else 0)
        place += width
        change = _value(float(fitted.coefficients[at]), NORMAL_95 * float(fitted.sd[at]), "")
        if _worth(found, keys, name) > search.MARGIN and change.low * change.high > 0:
            causes.append(_retuned(found, name, change, index))
    return causes


def _worth(found: _Search, keys: list[str], name: str) -> float:
    """Return the evidence that an own term is re-tuned, as for a candidate of its columns."""
    rows, difference = len(found.stacked.difference), found.stacked.difference
    rest = [c for own, c in found.own.items() if own != name]
    blocks = [found.blocks[k].columns for k in keys]
    without = np.column_stack([np.empty((rows, 0)), *blocks, *rest])
    left = rms(difference - without @ estimate(without, difference).coefficients)
    full = found.columns(keys)
    best = rms(difference - full @ estimate(full, difference).coefficients)
    gain = 2.0 * rows * float(np.log(left / max(best, 1e-9 * left, 1e-300)))
    width = int(found.own[name].shape[1])
    return gain - width * float(np.log(rows)) - 2.0 * float(np.log(len(found.blocks)))


def _retuned(found: _Search, name: str, change: Value, index: int) -> Cause:
    """Return the entry of an own term whose coefficient changes by ``change``."""
    stacked, term = found.stacked, term_called(name)
    n = len(stacked.conditions.number)
    columns = found.own[name][index * n : (index + 1) * n]
    column = columns[:, index if columns.shape[1] > 1 else 0] * stacked.sd[index * n :][:n]
    peak, half = float(np.max(np.abs(column))), change.high - change.value
    had = 1.0 if name == "shear" else float(cuts.edge_read_off(stacked)[index])
    now = _value(had + change.value, half, term.parameters[0].unit.replace("U", "N"))
    if name == "shear" and now.value < 0:
        text = "Recording and simulation have opposite signs: look at the sensor's sign first."
    else:
        text = term.statement
    return Cause(
        term=name,
        kind="mistuned",
        confidence=0.99,
        statement=(
            f"{text} The simulation has {term.parameters[0].name} {had:.3g}; the recording says "
            f"{now.value:.3g} ({now.low:.3g} to {now.high:.3g})."
        ),
        parameters={
            "size": _value(abs(change.value) * peak, half * peak, "N"),
            term.parameters[0].name: now,
        },
    )
