"""Proposed channels of moves over time: names first, and the physics that speaks for them."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from autodb.files.channels import FORCES, is_channel, place_channel
from autodb.records.convert import LARGEST
from autodb.records.proposed.chains import Chain, chains, nameless
from autodb.records.proposed.cut_names import has_unit_of, of_a_cut
from autodb.records.proposed.missing import missing_of_moves
from autodb.records.proposed.motion import FOLLOWS, Array, SlopeOf, share_followed
from autodb.records.proposed.names import NameSays, is_time, said_by
from autodb.records.proposed.one_motor import of_one_motor
from autodb.wording import listed, localized, phrase

Row = tuple[str, str, str, str]
"""Column, channel, unit and reason."""
STEPS_S = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9, "day": 86_400.0}
DAYS = (20_000.0, 80_000.0)
"""Numbers that spreadsheets give to the days of 1954 to 2119: a stamp among them may be in days."""
SLOWEST_HZ, FASTEST_HZ = 2.0, 2e5
"""Rates of drive recorders and sensors lie between these. Chosen."""
MANY_STEPS = 100
"""Steps that a rate is taken over. Chosen: of 1 ms a stamp is off by half of it in all of them."""
EVEN = 0.99
"""Share of steps above zero for a column to be time. Chosen: clocks are set back now and then."""
RATES_IN: dict[str, float] = {"mm/min": 60.0, "m/s": 1e-3, "m/min": 0.06, "um/s": 1000.0}
"""Units of a velocity by how many times the slope of a position in mm it is."""
NEAR = 0.1
SPARE = ("x", "y", "z", "u", "v", "w")


@dataclass
class ProposedMoves:
    """Proposals for moves, and what is missing."""

    found: list[Row] = field(default_factory=list)
    missing: tuple[str, ...] = ()

    @property
    def channels(self) -> set[str]:
        """Channels that are proposed."""
        return {channel for _, channel, _, _ in self.found}

    def add(self, column: str, channel: str, unit: str, because: str) -> None:
        """Propose a column where its channel is none yet and has units of its kind."""
        fits = is_channel(channel) and (not unit or channel == "t" or has_unit_of(channel, unit))
        if fits and channel not in self.channels:
            self.found.append((column, channel, unit, because))


def proposed_moves(
    numbers: Mapping[str, Array], dates: Sequence[str], units: Mapping[str, str]
) -> ProposedMoves:
    """Return what columns (n,) of moves may be; ``dates``: columns of moments as text."""
    made = ProposedMoves()
    t_s = _time(made, numbers, dates, units)
    others = {
        name: values
        for name, values in numbers.items()
        if name not in _columns(made) and not np.any(np.abs(values) > LARGEST)
    }
    said = {name: said_by(name, others) for name in others}
    units = {n: units.get(n) or said[n].unit for n in others}
    found = chains(others, said, t_s)
    if not found:
        free = {
            name: v for name, v in others.items() if said[name] == NameSays(unit=said[name].unit)
        }
        pair = nameless(free, t_s)
        found = [] if pair is None else [pair[0]]
    axes = _axes(found, said)
    for chain, axis in zip(found, axes, strict=True):
        _add_chain(made, chain, axis, units, named=any(said[c].axis for c in chain.columns))
    moving = {
        axis: _velocity(others, chain, t_s) for chain, axis in zip(found, axes, strict=True) if axis
    }
    _add_efforts(made, others, said, units, velocities=moving, t_s=t_s)
    _add_named(made, others, said, units)
    if made.channels <= {"t"}:
        for row in of_one_motor(said, units):
            made.add(*row)
    _add_step(made, found, said)
    made.missing = tuple(missing_of_moves(made.channels))
    return made


def _add_step(made: ProposedMoves, found: Sequence[Chain], said: Mapping[str, NameSays]) -> None:
    """Propose the time of a row where velocities and positions tell it, in mm/s and mm."""
    named = [
        c for c in found if c.velocity and said[c.place].quantity and said[c.velocity].quantity
    ]
    steps = [1.0 / abs(chain.links[chain.velocity][1].factor) for chain in named]
    if "t" in made.channels or not steps:
        return
    step_s = float(np.median(steps))
    alike = max(abs(step / step_s - 1.0) for step in steps) < NEAR
    if alike and SLOWEST_HZ <= 1.0 / step_s <= FASTEST_HZ:
        why = phrase("velocities are the slopes of positions if a row takes this long")
        made.found.insert(0, ("*", "t", f"{step_s:.3g}", why))


def _columns(made: ProposedMoves) -> set[str]:
    return {column for column, _, _, _ in made.found}


def _time(
    made: ProposedMoves,
    numbers: Mapping[str, Array],
    dates: Sequence[str],
    units: Mapping[str, str],
) -> Array:
    """Propose the column of time, and return it in s; rows where there is none."""
    if dates:
        made.add(dates[0], "t", "", phrase("moments written as dates"))
    rising = [name for name, values in numbers.items() if rises(values)]
    named = [name for name in rising if name == "t" or is_time(name)]
    even = sorted(
        (name for name in rising if steps_evenly(numbers[name])),
        key=lambda name: float(np.median(np.diff(numbers[name]))) == 1.0,
    )
    choice = (named or even or _first_rising(numbers))[:1]
    if not choice or dates:
        return np.arange(len(next(iter(numbers.values()), ())), dtype=np.float64)
    (name,) = choice
    step = float(np.median(np.diff(numbers[name])))
    unit = units.get(name) or _unit_of_steps(step, float(numbers[name][0]))
    counted = step == 1.0 and not named
    if counted:
        return numbers[name]
    between = _mean_step(numbers[name])
    rate = localized(f"{1.0 / (between * STEPS_S.get(unit, 1.0)):.4g}")
    why = phrase("the first column rises on every row")
    if named or even:
        why = phrase("its name, and it rises") if named else phrase("it rises by even steps")
    said = "" if unit == "s" and not units.get(name) else unit
    made.add(name, "t", said, phrase("{why}: {rate} Hz", why=why, rate=rate))
    return numbers[name] * STEPS_S.get(unit, 1.0)


def _first_rising(numbers: Mapping[str, Array]) -> list[str]:
    """Return the first column where it is without a name and rises on each of many rows."""
    first = next(iter(numbers), "")
    values = numbers.get(first, np.zeros(0))
    nameless = said_by(first) == NameSays() and len(numbers) > 1
    return [first] if nameless and len(values) >= MANY_STEPS and np.all(np.diff(values) > 0) else []


def _mean_step(values: Array) -> float:
    """Return the usual step of a column (n,), over many of them: stamps may be rounded."""
    over = max(1, min(MANY_STEPS, len(values) // 2))
    return float(np.median(values[over:] - values[:-over])) / over


def rises(values: Array) -> bool:
    """Say whether nearly all steps of a column (n,) go up."""
    steps = np.diff(values)
    return len(steps) > 1 and bool(np.isfinite(values).all()) and float(np.mean(steps > 0)) >= EVEN


def steps_evenly(values: Array) -> bool:
    """Say whether nearly all steps of a rising column (n,) are about alike."""
    steps = np.diff(values)
    return float(np.mean(np.abs(steps / np.median(steps) - 1.0) < 0.5)) >= EVEN


def _unit_of_steps(step: float, first: float) -> str:
    """Return the unit in which a step makes a rate that recorders have; ``first``: a stamp."""
    units = [unit for unit in STEPS_S if unit != "day" or DAYS[0] <= first <= DAYS[1]]
    able = (u for u in units if SLOWEST_HZ <= 1.0 / (step * STEPS_S[u]) <= FASTEST_HZ)
    return next(able, "s")


def _axes(found: Sequence[Chain], said: Mapping[str, NameSays]) -> list[str]:
    """Return the axis of each chain: as names say, else the next letter that is free."""
    named = [next((a for c in chain.columns if (a := said[c].axis)), "") for chain in found]
    free = (letter for letter in SPARE if letter not in named)
    return [axis or next(free, "") for axis in named]


def _add_chain(
    made: ProposedMoves, chain: Chain, axis: str, units: Mapping[str, str], *, named: bool
) -> None:
    guess = [] if named else [phrase("which axis it is no number says")]
    ends = {chain.place: place_channel(axis), chain.velocity: f"{axis}.velocity",
            chain.acceleration: f"{axis}.acceleration"}  # fmt: skip
    if axis == "spindle":
        ends = {chain.place: "spindle.angle", chain.velocity: "spindle.speed"}
    followed = chain.links.get(chain.velocity)
    why = phrase("its name") if named else phrase("another column follows its motion")
    if followed is not None:
        why = phrase("'{column}' is its slope", column=chain.velocity)
    why = listed([why, *guess], "; ")
    made.add(chain.place, ends[chain.place], units.get(chain.place, ""), why)
    for column in (chain.velocity, chain.acceleration):
        if column and column in ends:
            of, link = chain.links[column]
            unit = units.get(column, "") or _unit_of_rate(link.factor, column == chain.velocity)
            made.add(column, ends[column], unit, listed([_slope(of, link), *guess], "; "))


def _slope(of: str, link: SlopeOf) -> str:
    """Return that a column is the slope of another, by how much it is larger and how surely."""
    factor, alike = localized(f"{link.factor:.3g}"), localized(f"{link.correlation:.3f}")
    if abs(link.factor - 1.0) < NEAR:
        return phrase("d('{of}')/dt, correlation {alike}", of=of, alike=alike)
    return phrase(
        "d('{of}')/dt times {factor}, correlation {alike}", of=of, factor=factor, alike=alike
    )


def _unit_of_rate(factor: float, is_velocity: bool) -> str:
    if not is_velocity:
        return ""
    able = (unit for unit, times in RATES_IN.items() if abs(abs(factor) / times - 1.0) < NEAR)
    return next(able, "")


def _add_efforts(
    made: ProposedMoves,
    columns: Mapping[str, Array],
    said: Mapping[str, NameSays],
    units: Mapping[str, str],
    *,
    velocities: Mapping[str, Array],
    t_s: Array,
) -> None:
    """Propose the efforts that follow a motion most, those whose names say so first.

    ``velocities``: by axis.
    """
    shares: list[tuple[float, str, str, str]] = []
    for name in columns:
        says = said[name]
        if name in _columns(made) or says.quantity not in ("current", "torque", "force", ""):
            continue
        if not np.isfinite(columns[name]).all():
            continue
        follows = {a: share_followed(columns[name], v, t_s) for a, v in velocities.items()}
        best = max(follows, key=lambda a: follows[a], default="")
        if best and follows[best] >= FOLLOWS and says.axis in ("", best):
            followed = phrase(
                "it follows the motion of {axis}: {share} % of its variance",
                axis=best,
                share=f"{100 * follows[best]:.0f}",
            )
            shares.append((follows[best], name, best, followed))
    for _, name, axis, why in sorted(shares, key=lambda one: (not said[one[1]].quantity, -one[0])):
        quantity = said[name].quantity or "current"
        ending = {"torque": "drive_torque", "force": "drive_force"}.get(quantity, "current")
        doubt = phrase("current, torque or force no number says")
        reason = why if said[name].quantity else listed([why, doubt], "; ")
        made.add(name, f"{axis}.{ending}", units.get(name, ""), reason)


def _velocity(columns: Mapping[str, Array], chain: Chain, t_s: Array) -> Array:
    if chain.velocity:
        return columns[chain.velocity]
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.asarray(np.gradient(columns[chain.place], t_s), dtype=np.float64)


def _add_named(
    made: ProposedMoves,
    columns: Mapping[str, Array],
    said: Mapping[str, NameSays],
    units: Mapping[str, str],
) -> None:
    """Propose what names alone say, of columns that hold a number."""
    for name, values in columns.items():
        if name in _columns(made) or said[name].commanded or said[name].foreign:
            continue
        if not np.isfinite(values).any():
            continue
        channel = name if is_channel(name) else _channel(said[name]) or _force_of_cutting(name)
        if channel:
            moved = channel.endswith(".current") and channel[0] in SPARE
            doubt = [phrase("no motion of that axis speaks for it")] if moved else []
            why = listed([phrase("its name"), *doubt], "; ")
            made.add(name, channel, units.get(name, ""), why)


def _force_of_cutting(name: str) -> str:
    """Return the force that a name says by what it does in turning: cutting, feed, passive."""
    channel = of_a_cut(name)
    return channel if channel in FORCES else ""


def _channel(says: NameSays) -> str:
    """Return the channel that a name says; empty where it says too little."""
    axis, quantity = says.axis, says.quantity
    if quantity == "force":
        return f"force.{axis}" if axis in ("x", "y", "z") else ""
    if axis == "spindle":
        return {"velocity": "spindle.speed", "current": "spindle.current",
                "power": "spindle.power", "torque": "torque.spindle", "angle": "spindle.angle",
                "temperature": "spindle.temperature"}.get(quantity, "")  # fmt: skip
    ending = {"torque": "drive_torque"}.get(quantity, quantity)
    return f"{axis}.{ending}" if axis and is_channel(f"{axis}.{ending}") else ""
