"""The load of each axis as its samples come: effort less what moving takes, nothing filtered.

What moving takes is worked out from tables: it is f(v) + g(x) + x·h(v) for each direction of
friction, and linear between them, z of Dahl's presliding among them, and in accelerations. Friction
after a reversal depends on the way since it and on what the moves before left: both are remembered,
so that blocks give what the whole gives.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from autodb.errors import UnusableInput
from autodb.sensing.drives.fit.axis_model import stored_parts
from autodb.sensing.drives.moves.motion import NOISE_BAND, noise_sd
from autodb.sensing.drives.reconstruct import DriveModel
from autodb.terms.channel import ChannelPart, predicted_channel
from autodb.terms.friction import STANDSTILL_MM_S, direction, presliding_state, since_reversal

Array = NDArray[np.float64]
Channels = Mapping[str, Array]

SPEEDS, PLACES = 4001, 8001
"""Nodes of the tables over speed, closer where it is slow, and over the travel."""
SLOW_MM_S = 0.01
"""Speed around which the table's nodes are closest."""
BEYOND = 0.5
"""Parts of what was seen by which tables reach beyond it."""
ALIKE = 1e-3
"""Share of its size by which a table may be off the model."""
MOTION = ("position", "velocity", "acceleration")
FRESH = ("direction", "position", "velocity", "acceleration")
"""What the terms that tables hold may take, beside accelerations of other axes."""


def standstill_of(velocities: Sequence[Array]) -> float:
    """Return the speed below which an axis counts as standing: what noise and steps of its log are.

    ``velocities``: as recorded, (n,) each.
    """
    noise = float(np.median([noise_sd(one) for one in velocities]))
    return max(STANDSTILL_MM_S, NOISE_BAND * noise)


@dataclass(frozen=True)
class MovingLoads:
    """What moving takes at accelerations of 0, for directions of friction −1, 0 and 1.

    ``over_speed`` (SPEEDS, 3, 2): at both ends of the travel, less that at the first speed;
    ``over_place`` (PLACES, 3): at the first speed.
    """

    speed_mm_s: Array
    place_mm: Array
    over_speed: Array
    over_place: Array

    def __call__(self, v_mm_s: Array, x_mm: Array) -> Array:
        """Return the effort (n, 3) of each direction."""
        low, high = self.place_mm[0], self.place_mm[-1]
        share = ((x_mm - low) / (high - low))[:, None]
        ends = _between(self.speed_mm_s, self.over_speed, v_mm_s)
        placed = _between(self.place_mm, self.over_place, x_mm)
        return np.asarray(placed + ends[..., 0] * (1.0 - share) + ends[..., 1] * share)


def _between(nodes: Array, values: Array, at: Array) -> Array:
    """Return values (k, ...) at nodes (k,) between them, at places (n,), the last ones beyond."""
    right = np.minimum(np.maximum(np.searchsorted(nodes, at), 1), len(nodes) - 1)
    left = right - 1
    share = (at - nodes[left]) / (nodes[right] - nodes[left])
    share = np.minimum(np.maximum(share, 0.0), 1.0)
    share = share.reshape(-1, *(1,) * (values.ndim - 1))
    return np.asarray(values[left] * (1.0 - share) + values[right] * share)


@dataclass(frozen=True)
class SeenAxis:
    """How an axis moves in recordings: the speed below which it stands, its travel and its fastest,
    beyond which tables do not reach.
    """

    name: str
    standstill_mm_s: float
    travel_mm: tuple[float, float]
    highest_mm_s: float

    @classmethod
    def of(cls, axis: str, recordings: Sequence[Channels]) -> "SeenAxis":
        """Return how an axis moves in recordings, and half of that beyond."""
        velocities = [one[f"{axis}.velocity"] for one in recordings]
        places = [one[f"{axis}.position"] for one in recordings]
        low, high = min(one.min() for one in places), max(one.max() for one in places)
        margin = BEYOND * max(high - low, 1.0)
        fastest = max(np.abs(one).max() for one in velocities)
        return cls(
            name=axis,
            standstill_mm_s=standstill_of(velocities),
            travel_mm=(float(low - margin), float(high + margin)),
            highest_mm_s=float((1.0 + BEYOND) * max(fastest, 1.0)),
        )


@dataclass(frozen=True)
class LoadedDrive:
    """The drive model of an axis, and the newtons that a unit of its effort is."""

    model: DriveModel
    newtons_per_unit: float


class AxisTables:
    """What moving an axis takes, as tables of its model."""

    def __init__(self, drive: LoadedDrive, seen: SeenAxis) -> None:
        model = drive.model
        parts, self._linear = stored_parts(model.terms)
        self.channel, self.axis, self.newtons_per_unit = (
            model.channel,
            model.axis,
            drive.newtons_per_unit,
        )
        self.standstill_mm_s = seen.standstill_mm_s
        self.slides_mm = [p.shape["distance"] for p in parts if p.term.name == "presliding"]
        self._parts = tuple(part for part in parts if part.term.name != "presliding")
        self._off_law = model.off_law
        _refuse_remembering(model, self._parts)
        self._others = tuple(dict.fromkeys(part.of for part in self._parts if part.of))
        nodes = np.linspace(-1.0, 1.0, SPEEDS)
        speed = SLOW_MM_S * np.sinh(nodes * np.arcsinh(seen.highest_mm_s / SLOW_MM_S))
        place = np.linspace(*seen.travel_mm, PLACES)
        made = [self._made(sense, speed, place) for sense in (-1.0, 0.0, 1.0)]
        over_speed, over_place = (np.stack(one, axis=1) for one in zip(*made, strict=True))
        self._tables = MovingLoads(speed, place, over_speed, over_place)
        self._per_acceleration = self._slope("acceleration")
        self._per_other = {o: self._slope(f"{o}.acceleration") for o in self._others}
        self._check()

    def moving(self, z: Array, channels: Channels) -> Array:
        """Return the effort (n,) that moving takes where friction has the direction ``z`` (n,)."""
        x, v, a = (channels[f"{self.axis}.{name}"] for name in MOTION)
        back, still, ahead = self._tables(v, x).T
        moving = still + np.abs(z) * (np.where(z > 0.0, ahead, back) - still)
        moving += self._per_acceleration * a
        for other, slope in self._per_other.items():
            moving += slope * channels[f"{other}.acceleration"]
        return np.asarray(moving)

    def _effort(self, z: Array, v: Array, x: Array, **accelerations: float) -> Array:
        inputs = {"direction": z, "velocity": v, "position": x}
        names = ("acceleration", *(f"{other}.acceleration" for other in self._others))
        inputs |= {name: np.full_like(x, accelerations.get(name, 0.0)) for name in names}
        told = predicted_channel(self._parts, self._linear, inputs)
        off = self._off_law
        return told if off is None else told + off.effort(self._parts, inputs)

    def _made(self, sense: float, speed: Array, place: Array) -> tuple[Array, Array]:
        """Return the tables of one direction, over speed (SPEEDS, 2) and place (PLACES,)."""
        first = np.full_like(place, speed[0])
        over_place = self._effort(np.full_like(place, sense), first, place)
        ends = [
            self._effort(np.full_like(speed, sense), speed, np.full_like(speed, end)) - at
            for end, at in ((place[0], over_place[0]), (place[-1], over_place[-1]))
        ]
        return np.column_stack(ends), over_place

    def _slope(self, name: str) -> float:
        one, none = np.ones(1), np.zeros(1)
        changed = self._effort(none, none, one, **{name: 1.0}) - self._effort(none, none, one)
        return float(changed[0])

    def _check(self) -> None:
        """Refuse a model that the tables do not hold."""
        speed, place = self._tables.speed_mm_s, self._tables.place_mm
        share = np.linspace(0.03, 0.97, 41)
        x = place[0] + share * (place[-1] - place[0])
        v = np.interp((7.0 * share) % 1.0, np.linspace(0.0, 1.0, SPEEDS), speed)
        sense = np.where(v < 0.0, -1.0, 1.0)
        back, _, ahead = self._tables(v, x).T
        told = np.where(sense > 0.0, ahead, back)
        model = self._effort(sense, v, x)
        if np.max(np.abs(told - model)) > ALIKE * np.max(np.abs(model)):
            raise UnusableInput(
                f"{self.channel}: a term of its model is not a sum over speed and place; use a "
                "model without it"
            )


class AxisLoad:
    """The load of one axis as its rows come, and what its last turn left."""

    def __init__(self, tables: AxisTables) -> None:
        self._tables = tables
        self._turn: tuple[float, float] = (0.0, 0.0)
        self._before = 0.0
        self._last_mm = 0.0

    def step(self, channels: Channels) -> Array:
        """Return the load (n,), N, of the next rows; positive where the motor pushes against it."""
        tables = self._tables
        x, v = (channels[f"{tables.axis}.{name}"] for name in ("position", "velocity"))
        if not len(x):
            return x
        moving = tables.moving(self._sense(v, x), channels)
        self._last_mm = float(x[-1])
        return np.asarray(tables.newtons_per_unit * (channels[tables.channel] - moving))

    def _sense(self, v: Array, x: Array) -> Array:
        """Return the direction of friction (n,), −1 to 1, and remember the last turn."""
        raw = direction(v, standstill_mm_s=self._tables.standstill_mm_s)
        if not self._tables.slides_mm:
            return raw
        sense, turned_mm = self._turn
        if sense and not np.any(sense * raw <= -1.0):
            way = np.abs(x - turned_mm) / self._tables.slides_mm[0]
            return np.asarray(sense * (1.0 - (1.0 - sense * self._before) * np.exp(-way)))
        return self._turning(raw, x)

    def _turning(self, raw: Array, x: Array) -> Array:
        """Return the same of rows among which the axis turns, or moves for the first time."""
        begun = self._turn[0] != 0.0
        # The axis may turn at the very first row: how far it was by then is of the rows before
        sense = np.concatenate([[self._turn[0]] * 2, raw]) if begun else raw
        place = np.concatenate([[self._turn[1], self._last_mm], x]) if begun else x
        z = presliding_state(
            sense, place, distance_mm=self._tables.slides_mm[0], before=self._before
        )
        turned, _ = since_reversal(sense, place)
        first = np.flatnonzero(np.diff(turned) != 0) + 1
        if len(first):
            self._before = float(z[first[-1] - 1])
            self._turn = (float(turned[-1]), float(place[first[-1]]))
        elif not begun and turned[-1] != 0.0:
            self._turn = (float(turned[-1]), float(place[0]))
        return z[2:] if begun else z


def _refuse_remembering(model: DriveModel, parts: Sequence[ChannelPart]) -> None:
    """Raise UnusableInput for terms that depend on more than the row, as warming and play do."""
    late = [
        part.term.name
        for part in parts
        if part.term.name == "backlash"
        or not {n for n in part.term.inputs if not n.startswith("other_")} <= set(FRESH)
    ]
    if late:
        raise UnusableInput(
            f"{model.channel}: {', '.join(late)} needs a longer history than a stream keeps; "
            "use a model without it"
        )
