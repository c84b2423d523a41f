"""The parameters that effects and own terms of a milled waveform have, the rest left free."""

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass
from functools import cached_property, partial

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize_scalar

from autodb.explain.answer import Cause, IntervalValue
from autodb.explain.engine.candidates import CandidateForm, Choice
from autodb.explain.engine.confidence import Mistuned, of_mistuned
from autodb.explain.engine.entries import own_term_entries
from autodb.explain.engine.standing import Standing
from autodb.explain.waves.candidates import OWN_WAYS, nudged, off_axis
from autodb.explain.waves.fit import BesideWaves, WavesFit, WhitenedNoise, WhiteWaves
from autodb.explain.waves.look import FoundInWaves
from autodb.explain.waves.scans import harder_stretch
from autodb.explain.waves.sensors import HEATED, heated_sensor, in_one
from autodb.explain.waves.teeth import StandsOut, contrasts
from autodb.explain.waves.world import SimulatedWaves, on_each, shape_columns
from autodb.fitting.gaussian import NORMAL_95

Array = NDArray[np.float64]

WIDE = 0.05
"""Half width, as a share of the range looked through, over which a curvature is taken."""
SENSED = 0.2
"""Share of its largest force above which a component is looked at for its scale."""
LEAST = 0.01
"""Change of a term, as a share of itself, below which it is not called mistuned."""
OWN_TERMS = ("shear", "edge_force", "runout")


@dataclass(frozen=True)
class EffectInWaves:
    """One effect of a set, with what stands beside it."""

    world: SimulatedWaves
    bench: WhiteWaves
    quiet: WhitenedNoise
    choice: Choice
    others: tuple[Choice, ...]
    repeats: float = 1.0

    @cached_property
    def beside(self) -> BesideWaves:
        """White rows without own terms and the other effects."""
        return BesideWaves(self.bench, self.others, self.quiet, repeats=self.repeats)

    @property
    def work_s(self) -> float:
        """Time in the work."""
        inside = self.world.waves.t_s[self.world.engaged > 0.0]
        return float(inside[-1] - inside[0])

    def plain(self, name: str, **shape: float) -> CandidateForm:
        """Return the plain law with a first parameter, of some shape, that fits best."""
        forms = [
            one
            for one in self.choice.candidate.forms
            if one.names[:1] == (name,) and shape.items() <= one.shape.items()
        ]
        return max(forms, key=lambda one: self.beside.gain(shape_columns(one)))


Read = Callable[[EffectInWaves], dict[str, IntervalValue]]
ReadOne = Callable[[EffectInWaves, int], dict[str, IntervalValue]]


def shared(effect: EffectInWaves) -> dict[str, IntervalValue]:
    """Return the parameters that an effect has in all components alike."""
    read = SHARED.get(effect.choice.candidate.term)
    return read(effect) if read else {}


def of_one(effect: EffectInWaves, component: int) -> dict[str, IntervalValue]:
    """Return the parameters that it has in one component by itself."""
    read = OF_ONE.get(effect.choice.candidate.term)
    return read(effect, component) if read else {}


def interval_value(middle: float, sd: float, unit: str) -> IntervalValue:
    """Return a value with its 95 % interval."""
    return IntervalValue.around(middle, NORMAL_95 * sd, unit)


def _values(
    effect: EffectInWaves, columns: Array, names: tuple[str, ...], unit: str, *, scale: float = 1.0
) -> dict[str, IntervalValue]:
    """Return the coefficients of columns by name, times a scale."""
    found, covariance = effect.beside.fitted(columns)
    sd = np.sqrt(np.diag(covariance))
    pairs = zip(names, scale * found, abs(scale) * sd, strict=True)
    return {name: interval_value(float(one), float(spread), unit) for name, one, spread in pairs}


def _profiled(gain: Callable[[float], float], low: float, high: float, unit: str) -> IntervalValue:
    """Return the value between limits that fits best; its spread is from the curvature there."""
    found = minimize_scalar(lambda at: -gain(float(at)), bounds=(low, high), method="bounded")
    half = WIDE * (high - low)
    around = [gain(float(found.x) + step) for step in (-half, 0.0, half)]
    curvature = (2.0 * around[1] - around[0] - around[2]) / half**2
    sd = float(np.sqrt(2.0 / curvature)) if curvature > 0.0 else high - low
    return interval_value(float(found.x), min(sd, high - low), unit)


def _edge_force(effect: EffectInWaves) -> dict[str, IntervalValue]:
    form = effect.plain("coefficient")
    return _values(effect, shape_columns(form), form.names, "N/mm")


def _wear(effect: EffectInWaves) -> dict[str, IntervalValue]:
    """Return how fast the force on the engaged edge of a tooth grows, evenly over the work."""
    form = effect.plain("rate", power=1.0)
    scale = effect.world.waves.teeth.mill.depth_mm / effect.work_s
    names = ("rate", "radial_rate", "axial_rate")
    return _values(effect, shape_columns(form), names, "N/s", scale=scale)


def _size_effect(effect: EffectInWaves) -> dict[str, IntervalValue]:
    """Return m of a force that goes with h^(1 − m) where the simulation's goes with h."""
    form = effect.plain("exponent")
    return _values(effect, shape_columns(form), form.names, "1", scale=-1.0)


def _runout(effect: EffectInWaves) -> dict[str, IntervalValue]:
    """Return how far the axis is off, and how far each tooth stands out of their mean."""
    world = effect.world
    z = world.waves.teeth.mill.teeth
    out = world.out or StandsOut((0.0,) * z)
    shape = contrasts(z)
    beside = BesideWaves(
        effect.bench,
        effect.others,
        effect.quiet,
        minus=world.stands_out,
        repeats=effect.repeats,
    )
    more, covariance = beside.fitted(nudged(world, out) @ shape)
    mm, spread = np.array(out.mm) + shape @ more, shape @ covariance @ shape.T
    axis = off_axis(z) * 2.0 / z if z > 2 else off_axis(z) / z
    along, of_axis = axis.T @ mm, axis.T @ spread @ axis
    offset = float(np.linalg.norm(along))
    sd = float(np.sqrt(along @ of_axis @ along)) / max(offset, 1e-300)
    teeth = {
        f"tooth {j}": interval_value(float(mm[j]), float(np.sqrt(spread[j, j])), "mm")
        for j in range(z)
    }
    return {"offset": interval_value(offset, sd, "mm"), **teeth}


def _chatter(effect: EffectInWaves) -> dict[str, IntervalValue]:
    world, at = effect.world, effect.choice.shape.shape["frequency"]
    t = world.waves.t_s

    def gain(frequency_Hz: float) -> float:
        angle = 2.0 * np.pi * frequency_Hz * t
        waves = np.column_stack([np.cos(angle), np.sin(angle)]) * world.engaged[:, None]
        return effect.beside.gain(on_each(world, waves))

    line = 1.0 / effect.work_s
    return {"frequency": _profiled(gain, at - line, at + line, "Hz")}


def _hard_spot(effect: EffectInWaves) -> dict[str, IntervalValue]:
    world, shape = effect.world, effect.choice.shape.shape
    number = effect.choice.form
    start, end = shape["start"], shape["end"]
    near = 0.2 * (end - start)

    def of_start(at: float) -> float:
        return effect.beside.gain(harder_stretch(world, at, end, number))

    first = _profiled(of_start, start - near, start + near, "s")

    def of_end(at: float) -> float:
        return effect.beside.gain(harder_stretch(world, first.value, at, number))

    last = _profiled(of_end, end - near, end + near, "s")
    more = _values(effect, harder_stretch(world, first.value, last.value, number), ("factor",), "1")
    change = more["factor"]
    factor = IntervalValue(
        value=1.0 + change.value, low=1.0 + change.low, high=1.0 + change.high, unit="1"
    )
    return {"factor": factor, "start": first, "end": last}


def _depth(effect: EffectInWaves) -> dict[str, IntervalValue]:
    form = effect.choice.shape
    return _values(effect, shape_columns(form), form.names, "mm")


def _deflection(effect: EffectInWaves) -> dict[str, IntervalValue]:
    """Return the share of the force that is lost where it is greatest, by a spring."""
    spring = shape_columns(effect.choice.candidate.forms[0])
    return _values(effect, spring, ("share",), "1", scale=-1.0)


def _mass(effect: EffectInWaves) -> dict[str, IntervalValue]:
    form = effect.choice.shape
    unit = "kg" if len(form.names) == 1 else "kg m"
    return _values(effect, shape_columns(form), form.names, unit)


def _heat(effect: EffectInWaves) -> dict[str, IntervalValue]:
    world = effect.world

    def gain(share: float) -> float:
        course = heated_sensor(world.waves.t_s, world.engaged, share)
        return effect.beside.gain(on_each(world, course[:, None]))

    found = _profiled(gain, 0.5 * HEATED[0], 2.0 * HEATED[-1], "1")
    seconds = (effect.work_s * one for one in (found.value, found.low, found.high))
    middle, low, high = seconds
    return {"time_constant": IntervalValue(value=middle, low=max(low, 0.0), high=high, unit="s")}


def _drift(effect: EffectInWaves, component: int) -> dict[str, IntervalValue]:
    world, t = effect.world, effect.world.waves.t_s
    line = np.column_stack([world.time, np.ones(len(t))])
    columns = in_one(world, line, component)
    values = _values(effect, columns, ("rate", "level"), "N/s", scale=1.0 / float(t[-1] - t[0]))
    return {"rate": values["rate"]}


def _gain(effect: EffectInWaves, component: int) -> dict[str, IntervalValue]:
    """Return the factor where it is furthest from 1."""
    columns = shape_columns(effect.choice.shape)
    found, covariance = effect.beside.fitted(columns)
    force = effect.world.sensed[component]
    rows = np.flatnonzero(np.abs(force) > SENSED * np.max(np.abs(force)))
    factor = columns[component, rows] / force[rows, None]
    change = factor @ found
    at = int(np.argmax(np.abs(change)))
    sd = float(np.sqrt(max(float(factor[at] @ covariance @ factor[at]), 0.0)))
    return {"factor": interval_value(1.0 + float(change[at]), sd, "1")}


def _crosstalk(effect: EffectInWaves, component: int) -> dict[str, IntervalValue]:
    """Return the share of each other component that one shows."""
    world = effect.world
    others = [j for j in range(world.components) if j != component]
    columns = np.concatenate(
        [in_one(world, world.shown[j][:, None], component) for j in others], axis=-1
    )
    names = tuple(f"share of {world.waves.names[j]}" for j in others)
    return _values(effect, columns, names, "1")


SHARED: dict[str, Read] = {
    "edge_force": _edge_force, "tool_wear": _wear, "size_effect": _size_effect,
    "runout": _runout, "chatter": _chatter, "hard_spot": _hard_spot, "depth_error": _depth,
    "deflection": _deflection, "table_gravity": _mass, "table_inertia": _mass,
    "thermal_drift": _heat,
}  # fmt: skip
OF_ONE: dict[str, ReadOne] = {"sensor_drift": _drift, "gain": _gain, "crosstalk": _crosstalk}


def mistuned_of_waves(looked: FoundInWaves) -> dict[str, Mistuned]:
    """Return how sure it is of each own term that it is off, in all components together."""
    return {term: _judged(looked, [term]) for term in OWN_TERMS if term in looked.bench.own}


def retuned_of_waves(
    looked: FoundInWaves,
    own: Mapping[str, Mistuned],
    fitted: WavesFit,
    component: int,
    *,
    beside: Collection[Cause],
) -> list[Cause]:
    """Return the own terms that are off in one component, as ``mistuned_of_waves``.

    ``beside``: what else is told of the component.
    """
    causes = {
        term: _cause(term, fitted, _places(looked, fitted, term), component, off.standing)
        for term, off in own.items()
    }
    changed = {term: cause for term, cause in causes.items() if cause is not None}
    return own_term_entries(own, changed, beside=beside, jointly=partial(_judged, looked))


def _judged(looked: FoundInWaves, terms: Collection[str]) -> Mistuned:
    """Return how sure it is that own terms are off, in one way or another."""
    own = [number for number, term in enumerate(looked.bench.own) if term in terms]
    places = None
    for choice in looked.found.choices:
        if choice.candidate.key == OWN_WAYS:
            at = looked.search.products.places[choice.key]
            names = [name for name, count in choice.shape.shape.items() for _ in range(int(count))]
            places = at[[name in terms for name in names]]
    return of_mistuned(looked.search, looked.found, own, ways=places)


def change_of_own(
    looked: FoundInWaves, fitted: WavesFit, terms: Collection[str], component: int
) -> Array:
    """Return what the re-tuning of own terms adds to one component, (n,)."""
    places = [at for term in dict.fromkeys(terms) for at in _places(looked, fitted, term)]
    return np.asarray(fitted.columns[component][:, places] @ fitted.coefficients[places])


def _places(looked: FoundInWaves, fitted: WavesFit, term: str) -> list[int]:
    """Return where the factor of an own term is among the coefficients, then those of its ways."""
    places = [k for k, name in enumerate(looked.bench.own) if name == term]
    for choice, at in zip(looked.found.choices, fitted.places, strict=True):
        if choice.candidate.key == OWN_WAYS and places:
            start = at.start
            for name, count in choice.shape.shape.items():
                places += range(start, start + int(count)) if name == term else []
                start += int(count)
    return places


def _cause(
    term: str, fitted: WavesFit, places: list[int], component: int, sure: Standing
) -> Cause | None:
    """Return the entry of an own term in one component; None where it hardly changes there."""
    columns = fitted.columns[component][:, places]
    change, spread = fitted.coefficients[places], fitted.covariance[np.ix_(places, places)]
    base, part = columns[:, 0], columns @ change
    share = base @ columns / max(float(base @ base), 1e-300)
    factor = interval_value(
        1.0 + float(share @ change), float(np.sqrt(share @ spread @ share)), "1"
    )
    off = abs(factor.value - 1.0)
    if off < max(LEAST, factor.high - factor.value):
        return None
    peak = int(np.argmax(np.abs(part)))
    sd = float(np.sqrt(max(float(columns[peak] @ spread @ columns[peak]), 0.0)))
    size = interval_value(abs(float(part[peak])), sd, "N")
    words = term.replace("_", " ")
    return Cause(
        term=term,
        kind="mistuned",
        confidence=sure.confidence,
        statement=(
            f"The recording has {factor.value:.3g} times the {words} of the simulation "
            f"({factor.low:.3g} to {factor.high:.3g})."
        ),
        parameters={"size": size, "factor": factor},
        alternatives=sure.near,
    )
