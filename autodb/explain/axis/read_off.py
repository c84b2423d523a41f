"""The terms that a simulation has, read off it by regression: it has no noise of its own.

It does have a motion that it was computed with, which is not the one that is derived here: over
which speed its friction turns and how its acceleration was filtered is found out beside its terms.
"""

from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property, partial

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize_scalar, nnls

from autodb import signals
from autodb.explain.axis.tilt import CONSTANT, own_tilt
from autodb.files.channels import ROTARY_AXES, place_channel
from autodb.records.tables import Recording
from autodb.sensing.drives.moves.motion import noise_sd, top_speed
from autodb.terms.drive import tilt
from autodb.terms.friction import direction

Array = NDArray[np.float64]
Inputs = Mapping[str, Array]

OWN_SHARE = 0.005
"""A term of which the simulation has less than this share is not in it."""
BLURRED_SHARE = 0.02
"""The same where motion is known within a dead band only. Chosen."""
READ_OFF = frozenset({"coulomb", "viscous", "inertia", "gravity"})
"""Terms that a simulation is read off with."""
READ_WELL = 0.99
"""Share of a simulation that its terms give from which on they are said with their values."""
SIGNED = frozenset({"coulomb", "viscous", "inertia"})
"""Terms that are not negative."""
WIDTHS = tuple(float(share) for share in np.geomspace(1e-4, 0.05, 10))
"""Speeds, as shares of the top speed, over which a simulation's friction may turn."""
WRITTEN = 1e-12
"""Share of a simulation's sum of squares that six written digits leave: nothing leaves less."""
BETTER = 0.98
"""A width is taken that leaves less than this share of what a simpler one does. Chosen."""
HALVED = 0.5
"""The same of another motion than the one that is known best. Chosen."""
EXACT = 1e-4
"""Share left from which on other motions are tried. Chosen."""
ROWS = 8_000
"""Rows that are looked at. Chosen."""
HIGHEST, LOWEST_HZ, APART, FILTERS = 0.45, 1.5, 1.7, 10
"""Cutoffs of filters that are tried: from this share of the rate down. Chosen."""


@dataclass(frozen=True)
class SimulatedMotion:
    """A velocity and an acceleration that a simulation may have been computed with, (n,) each.

    ``cutoff_hz``: of the filter that they were derived with; that of the recording's own: infinite.
    """

    velocity: Array
    acceleration: Array
    cutoff_hz: float = float("inf")


@dataclass(frozen=True)
class OwnTerms:
    """What a simulation is read to have.

    ``sense`` (n,): the direction as its friction turns; ``columns`` (n,) by term, ``had`` their
    coefficients; ``share`` of the simulation's sum of squares that they give, about its mean where
    they have a constant; ``phase_deg``: the angle at which a rotary axis' weight is largest;
    ``cutoff_hz``: of the filter that its motion was derived with, where it is another than the
    recording's own; ``velocity`` and ``acceleration`` (n,) of that motion;
    ``constant``: the constant load beside the weight of a rotary axis.
    """

    sense: Array
    columns: dict[str, Array]
    had: dict[str, float]
    share: float
    phase_deg: float = 0.0
    cutoff_hz: float = float("inf")
    velocity: Array | None = None
    acceleration: Array | None = None
    constant: float = 0.0

    @property
    def motion(self) -> dict[str, Array]:
        """The motion that the simulation was computed with, (n,) each, as its laws take it."""
        moves = {"velocity": self.velocity, "acceleration": self.acceleration}
        known = {name: values for name, values in moves.items() if values is not None}
        return {"direction": self.sense, **known}


Turning = Callable[[SimulatedMotion], Array]
"""How friction turns with a motion, (n,)."""


@dataclass(frozen=True)
class _Fit:
    """Columns fitted to a simulation, by term, and the sum of squares that they leave.

    ``turning``: how its friction turns, None: as the recording's direction.
    """

    motion: SimulatedMotion
    turning: Turning | None
    values: dict[str, Array]
    left: float


@dataclass(frozen=True)
class _Simulation:
    """A simulation (n,), what of it further terms add, and the rows of it that are looked at.

    ``signed``: terms whose coefficients are not negative.
    """

    simulation: Array
    known: Array
    inputs: Inputs
    terms: frozenset[str]
    rows: NDArray[np.intp]
    rotary: bool
    signed: frozenset[str] = SIGNED

    @cached_property
    def whole(self) -> Array:
        """The simulation at the rows, (m,)."""
        return self.simulation[self.rows]

    @cached_property
    def right(self) -> Array:
        """What is to be read at the rows, (m,)."""
        return self.whole - self.known[self.rows]

    @cached_property
    def squares(self) -> float:
        """The sum of squares of what is to be read."""
        return float(np.sum(self.right**2))

    @cached_property
    def varied(self) -> float:
        """The same about its mean where a constant is among the terms."""
        mean = float(self.right.mean()) if "gravity" in self.terms else 0.0
        return float(np.sum((self.right - mean) ** 2))

    @cached_property
    def top(self) -> float:
        """The top speed of the recording."""
        return top_speed(self.inputs["velocity"], noise_sd(self.inputs["velocity"]))

    def columns(self, motion: SimulatedMotion, sense: Array) -> dict[str, Array]:
        """Return the columns (m, k) of each term at the rows."""
        here = {"position": self.inputs["position"], **_moves(motion)}
        kept = {name: values[self.rows] for name, values in here.items()}
        made = _term_columns(sense[self.rows], kept, rotary=self.rotary)
        return {name: block for name, block in made.items() if _stem(name) in self.terms}

    def sense(self, motion: SimulatedMotion, turning: Turning | None) -> Array:
        """Return the direction (n,) as friction turns."""
        return self.inputs["direction"] if turning is None else turning(motion)

    def fitted(
        self, motion: SimulatedMotion, turning: Turning | None, without: Collection[str] = ()
    ) -> _Fit:
        """Return the fit of all terms but some."""
        columns = self.columns(motion, self.sense(motion, turning))
        blocks = {n: b for n, b in columns.items() if n not in without}
        if not blocks:
            return _Fit(motion, turning, {}, self.squares)
        signs = [name in self.signed for name, block in blocks.items() for _ in block.T]
        matrix = np.column_stack(list(blocks.values()))
        found, left = _non_negative(matrix, self.right, np.array(signs, dtype=bool))
        ends = np.cumsum([block.shape[1] for block in blocks.values()])
        parts = dict(zip(blocks, np.split(found, ends[:-1]), strict=True))
        return _Fit(motion, turning, parts, left + WRITTEN * self.squares)

    def over_widths(self, motion: SimulatedMotion) -> _Fit:
        """Return the fit with the width over which friction turns that leaves least."""
        best = self.fitted(motion, None)
        if "coulomb" not in self.terms or not self.top:
            return best
        for kind in (_smooth, _sharp):
            tried = [self.fitted(motion, partial(kind, width=w * self.top)) for w in WIDTHS]
            at = int(np.argmin([fit.left for fit in tried]))
            if tried[at].left < BETTER * best.left:
                best = self._finer(motion, kind, WIDTHS[at] * self.top)
        return best

    def _finer(self, motion: SimulatedMotion, kind: Callable[..., Array], width: float) -> _Fit:
        ratio = float(np.log(WIDTHS[1] / WIDTHS[0]))

        def fit(log_ratio: float) -> _Fit:
            return self.fitted(motion, partial(kind, width=width * float(np.exp(log_ratio))))

        found = minimize_scalar(lambda x: fit(x).left, bounds=(-ratio, ratio), method="bounded")
        return min(fit(0.0), fit(float(found.x)), key=lambda one: one.left)


def own_terms_of(
    simulation: Array,
    inputs: Inputs,
    recording: Recording,
    axis: str,
    known: Array,
    *,
    includes: Collection[str] | None = None,
) -> OwnTerms:
    """Return the terms of ``READ_OFF`` that a simulation (n,) has; of ``includes`` where given.

    ``known`` (n,): what of it further terms add. Rows that were not measured say nothing.
    """
    measured = recording.timing.placed
    terms = READ_OFF if includes is None else READ_OFF & set(includes)
    rows = np.arange(len(simulation)) if measured is None else np.flatnonzero(measured)
    rows = rows[:: max(1, len(rows) // ROWS)]
    sim = _Simulation(simulation, known, inputs, terms, rows, axis in ROTARY_AXES)
    fit = _in_its_motion(sim, recording, axis)
    if fit.left > EXACT * sim.varied:
        as_written = replace(sim, signed=frozenset())
        free = _in_its_motion(as_written, recording, axis)
        if free.left < min(HALVED * fit.left, (1.0 - READ_WELL) * sim.varied):
            sim, fit = as_written, free
    share = OWN_SHARE if measured is None else BLURRED_SHARE
    return _told(sim, _lasting(sim, fit, share**2 * sim.squares))


def _in_its_motion(sim: _Simulation, recording: Recording, axis: str) -> _Fit:
    """Return the fit in the recording's motion, or in another that it leaves half as much in."""
    fit = sim.over_widths(SimulatedMotion(sim.inputs["velocity"], sim.inputs["acceleration"]))
    if sim.terms - {"gravity"} and fit.left > EXACT * sim.varied and sim.top:
        others = (sim.fitted(motion, fit.turning) for motion in _motions(recording, axis))
        best = min(others, key=lambda one: one.left)
        if best.left < HALVED * fit.left:
            return sim.over_widths(best.motion)
    return fit


def _lasting(known: _Simulation, fit: _Fit, level: float) -> _Fit:
    """Return the fit without terms whose squares, the others fitted anew, are below a level."""
    gone: list[str] = []
    while fit.values:
        tried = {n: known.fitted(fit.motion, fit.turning, [*gone, n]) for n in fit.values}
        least = min(tried, key=lambda name: tried[name].left)
        if tried[least].left - fit.left > level:
            break
        gone.append(least)
        fit = tried[least]
    return fit


def _told(known: _Simulation, fit: _Fit) -> OwnTerms:
    """Return what a fit says that a simulation has."""
    sense = known.sense(fit.motion, fit.turning if "coulomb" in fit.values else None)
    inputs = {"position": known.inputs["position"], **_moves(fit.motion)}
    phase_deg, values = 0.0, {n: float(found[0]) for n, found in fit.values.items()}
    if known.rotary and "gravity" in fit.values:
        cosine, sine = fit.values["gravity"]
        values["gravity"] = float(np.hypot(cosine, sine))
        phase_deg = float(np.degrees(np.arctan2(sine, cosine)))
    columns = own_terms(sense, inputs, rotary=known.rotary, phase_deg=phase_deg)
    kept = {n: column for n, column in columns.items() if _kept(n, values)}
    had = {name: value for name, value in values.items() if name != CONSTANT}
    steady = CONSTANT in values or ("gravity" in values and not known.rotary)
    whole = float(np.sum((known.whole - steady * known.whole.mean()) ** 2))
    left = max(fit.left - WRITTEN * known.squares, 0.0)
    told = whole > WRITTEN * float(np.sum(known.whole**2))
    given = 1.0 - left / whole if told else 1.0
    return OwnTerms(
        sense=sense,
        columns=kept,
        had=had,
        share=given,
        phase_deg=phase_deg,
        cutoff_hz=fit.motion.cutoff_hz,
        velocity=fit.motion.velocity,
        acceleration=fit.motion.acceleration,
        constant=values.get(CONSTANT, 0.0),
    )


def _moves(motion: SimulatedMotion) -> dict[str, Array]:
    return {"velocity": motion.velocity, "acceleration": motion.acceleration}


def _kept(name: str, values: Mapping[str, float]) -> bool:
    """Whether a column is one of a term that was read off; a weight's other part goes with it."""
    return (name if name == CONSTANT else _stem(name)) in values


def _stem(name: str) -> str:
    """Return the term that a column is of."""
    return "gravity" if name == CONSTANT else name.partition(" ")[0]


def own_terms(
    sense: Array, inputs: Inputs, *, rotary: bool = False, phase_deg: float = 0.0
) -> dict[str, Array]:
    """Return the columns (n,) that a simulation is read off with, by term.

    On a rotary axis `gravity` turns with the angle from its ``phase_deg``; a part of it across that
    phase, and a constant load, are columns without a term.
    """
    made = _term_columns(sense, inputs, rotary=rotary)
    if rotary:
        made |= own_tilt(inputs["position"], phase_deg)
    return {name: block[:, 0] for name, block in made.items()}


def _term_columns(sense: Array, inputs: Inputs, *, rotary: bool) -> dict[str, Array]:
    """Return the columns (n, k) of each term."""
    made = {
        "coulomb": sense[:, None],
        "viscous": inputs["velocity"][:, None],
        "inertia": inputs["acceleration"][:, None],
        "gravity": tilt(inputs["position"]) if rotary else np.ones((len(sense), 1)),
    }
    return made | ({CONSTANT: np.ones((len(sense), 1))} if rotary else {})


def _smooth(motion: SimulatedMotion, width: float) -> Array:
    return np.asarray(np.tanh(motion.velocity / width))


def _sharp(motion: SimulatedMotion, width: float) -> Array:
    return direction(motion.velocity, standstill_mm_s=width)


def _non_negative(matrix: Array, right: Array, signed: NDArray[np.bool_]) -> tuple[Array, float]:
    """Return least-squares coefficients (k,), those ``signed`` not negative, and what is left."""
    size = np.sqrt(np.mean(matrix**2, axis=0))
    size = np.where(size > 0, size, 1.0)
    whole = np.column_stack([matrix / size, right])
    triangle = np.asarray(np.linalg.qr(whole, mode="r"), dtype=np.float64)
    count = matrix.shape[1]
    columns = triangle[:, :count]  # those that may be negative stand there twice
    found, left = nnls(np.column_stack([columns, -columns[:, ~signed]]), triangle[:, -1])
    found[:count][~signed] -= found[count:]
    return np.asarray(found[:count] / size, dtype=np.float64), float(left**2)


def _motions(recording: Recording, axis: str) -> Iterator[SimulatedMotion]:
    """Return motions that a simulation may have: of recorded velocity, then of position alone."""
    rate_hz = recording.timing.rate_hz
    cutoffs = [HIGHEST * rate_hz / APART**k for k in range(FILTERS)]
    for cutoff_hz in (rate_hz, *(one for one in cutoffs if one > LOWEST_HZ)):
        velocity = recording.get(f"{axis}.velocity")
        if velocity is not None:
            smooth = signals.lowpass_pieces(velocity, recording.timing, cutoff_hz=cutoff_hz)
            slope = signals.slope(smooth, recording.timing, recording.t_s)
            yield SimulatedMotion(velocity, slope, cutoff_hz)
            yield SimulatedMotion(smooth, slope, cutoff_hz)
        _, velocity, acceleration = signals.derivatives(
            recording.t_s,
            recording[place_channel(axis)],
            cutoff_hz=cutoff_hz,
            timing=recording.timing,
        )
        yield SimulatedMotion(velocity, acceleration, cutoff_hz)
