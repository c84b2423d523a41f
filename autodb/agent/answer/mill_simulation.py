"""A mill's forces over time as its work-tool pair's posterior expects them."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from sqlalchemy.orm import Session

from autodb.agent.learn.known import KnownPair, known_of
from autodb.agent.rows.machines import owner_of
from autodb.errors import UnusableInput
from autodb.explain.waves.teeth import TABLE, Mill, table_angles
from autodb.explain.waves.waves import heard, mill_of
from autodb.files.channels import FORCES
from autodb.forward.prediction import ToolOf
from autodb.forward.waveform import waves_N
from autodb.pairs.engaged import DEPTH, DIRECTION, FEED, RPM, WIDTH
from autodb.pairs.posterior import PairPosterior
from autodb.records.tables import Recording
from autodb.signals import by_piece, flagged_runs
from autodb.store import models
from autodb.wording import phrase

Array = NDArray[np.float64]

HAS = ("shear", "edge_force")
"""Terms that a posterior's forces over time have."""
CUTS = 0.25
"""Share of a turn's usual power of force above which its rows are taken as in the work. Chosen."""
WHOLLY = 0.95
"""Share of the power of force in the work above which the whole of the arc is. Chosen."""
TURNS = 20
"""Turns of the spindle that have to be wholly in the work."""
PHASES = 96
"""Angles within a tooth's pitch, finer by STEPS rounds, among which the teeth are searched for."""
STEPS = 3
CURVE, NUDGE_RAD = 4, 0.01
"""Degree of the curve by which an angle that was not recorded is off; by what teeth are turned to
see what that changes."""
ROWS = 2000
"""Rows from which angles are estimated."""
TURNED = 0.5
"""Share of the squares left as recorded below which the teeth are taken to be elsewhere."""


@dataclass(frozen=True)
class ExpectedWaves:
    """Rows of a recording that are wholly in the work, and what is expected of their forces.

    With the spindle's angle at which it is expected.
    """

    measured: Recording
    forces_N: dict[str, Array]
    notes: tuple[str, ...]


def known_pair(session: Session, owner: models.Machine, recording: Recording) -> KnownPair:
    """Return what a machine has learnt of the pair that a recording of forces is of.

    Raises UnusableInput where the recording does not say it, or the machine has not learnt it.
    """
    material, tool = recording.side.recording.work, recording.side.tool.name
    if material is None or tool is None:
        raise UnusableInput(
            phrase(
                "{file}: its work-tool pair is not known; use --simulation FILE with force.*, "
                "or a side file with [recording] work and [tool] name",
                file=recording.path,
            )
        )
    known = known_of(session, owner_of(owner), material, tool)
    if not known.own:
        raise UnusableInput(
            phrase(
                "{file}: {owner} has no parameters of {material} / {tool}; use --simulation "
                "FILE with force.*, or import cuts of this pair and run 'autodb refresh'",
                file=recording.path,
                owner=owner.name,
                material=material,
                tool=tool,
            )
        )
    return known


def expected_waves(known: KnownPair, recording: Recording) -> ExpectedWaves:
    """Return what the posterior of a recording's pair expects of its forces.

    Only where the mill is wholly in the work: on its way in and out the arc is another. Where the
    angle of the spindle was not recorded the passing of teeth gives it; where it was and the teeth
    are elsewhere, its zero is taken from them, and a note says so.

    Raises UnusableInput where the side file says too little of tool and cut.
    """
    mill, rpm = mill_of(recording), _rpm(recording)
    operation = recording.side.cut.operation
    if operation is None:
        raise UnusableInput(
            phrase(
                "{file}: the operation is not stated; state [cut] operation in a side file",
                file=recording.path,
            )
        )
    rows = _wholly_inside(recording, rpm, mill.feed_mm * mill.teeth * rpm / 60.0)
    inside = _at(recording, rows)
    wave = _Wave(known.posterior, known.tool, operation, _conditions(inside, rpm))
    angle_rad, notes = _turned(inside, mill, wave)
    begin, *_, end = inside.t_s
    said = f"explained from {begin:.3g} to {end:.3g} s, where the mill is wholly in the work"
    turned = inside.channels | {"spindle.angle": np.degrees(angle_rad)}
    return ExpectedWaves(
        replace(inside, channels=turned),
        wave.at(inside, angle_rad),
        (f"{recording.path}: {said}", *notes),
    )


def _turned(recording: Recording, mill: Mill, wave: "_Wave") -> tuple[Array, tuple[str, ...]]:
    """Return the angle of tooth 0 (n,), rad, and what to say of it."""
    pitch = 2.0 * np.pi / mill.teeth
    angle = recording.get("spindle.angle")
    if angle is None:
        ones = np.ones(len(recording))
        heard_at = heard(recording, mill, np.array([*_forces(recording).values()]), ones, ones)
        heard_at += wave.phase(recording, heard_at, pitch)[0]
        return wave.in_step(recording, heard_at, degree=CURVE), ()
    recorded = np.radians(angle)
    off, share = wave.phase(recording, recorded, pitch)
    if share >= TURNED:
        return recorded, ()
    said = f"teeth cut {np.degrees(off):.0f}° from where spindle.angle has them"
    turned = wave.in_step(recording, recorded + off, degree=0)
    return turned, (f"{recording.path}: {said}; its zero is taken from them",)


def _rpm(recording: Recording) -> float:
    speed = recording.get("spindle.speed")
    rpm = recording.side.cut.speed_rpm if speed is None else float(np.median(speed))
    if rpm is None:
        raise UnusableInput(
            phrase(
                "{file}: no spindle.speed, and no speed_rpm in its side file; record one of "
                "them or state it there",
                file=recording.path,
            )
        )
    return rpm


def _forces(recording: Recording) -> dict[str, Array]:
    return {name: recording[name] for name in FORCES if name in recording}


def _wholly_inside(recording: Recording, rpm: float, fed_mm_s: float) -> slice:
    """Return the rows of the longest stretch in the work, without a gap nor the ways in and out.

    On its way in a mill goes at most its radius, and is in when its force's power is the usual one.
    """
    power = np.sum(np.array([*_forces(recording).values()]) ** 2, axis=0)
    rate_hz, pieces = recording.timing.rate_hz, recording.pieces
    turn = max(2, round(60.0 / rpm * rate_hz))
    even = np.ones(turn) / turn
    smooth = by_piece(lambda own: np.convolve(own, even, mode="same"), power, pieces)
    cuts = smooth > CUTS * np.quantile(smooth, 0.75)
    longest = max(flagged_runs(cuts, pieces), key=lambda run: run.stop - run.start)
    first, last = longest.start, longest.stop
    piece = next(one for one in pieces if one.start <= first < one.stop)
    way = round(_radius_mm(recording) / fed_mm_s * rate_hz)
    usual = smooth > WHOLLY * np.median(smooth[first:last])
    if first > piece.start + turn:
        first += min(int(np.argmax(usual[first:])), way) + turn
    if last < piece.stop - turn:
        last -= min(int(np.argmax(usual[:last][::-1])), way) + turn
    if last - first < TURNS * turn:
        raise UnusableInput(
            phrase(
                "{file}: the mill is wholly in the work for less than {turns} turns; record a "
                "longer cut",
                file=recording.path,
                turns=TURNS,
            )
        )
    return slice(first, last)


def _radius_mm(recording: Recording) -> float:
    diameter_mm = recording.side.tool.diameter_mm
    assert diameter_mm is not None
    return 0.5 * diameter_mm


def _at(recording: Recording, rows: slice) -> Recording:
    """Return some rows of one piece of a recording."""
    count = rows.stop - rows.start
    return replace(
        recording,
        examined_as=replace(recording.timing, pieces=(slice(0, count),), rows=count, layout=None),
        as_written=None,
        channels={name: values[rows] for name, values in recording.channels.items()},
        texts={name: values[rows] for name, values in recording.texts.items()},
    )


def _conditions(recording: Recording, rpm: float) -> Mapping[str, float]:
    cut = recording.side.cut
    stated = {
        FEED: cut.feed_mm_tooth,
        DEPTH: cut.depth_mm,
        WIDTH: cut.width_mm,
        DIRECTION: cut.feed_direction_deg,
    }
    return {RPM: rpm} | {name: value for name, value in stated.items() if value is not None}


@dataclass(frozen=True)
class _Wave:
    """A posterior's forces of a cut over the spindle's angle."""

    posterior: PairPosterior
    tool: ToolOf
    operation: str
    conditions: Mapping[str, float]

    def at(self, recording: Recording, angle_rad: Array) -> dict[str, Array]:
        """Return the forces at angles (n,) in the recording's frame."""
        forces = waves_N(self.posterior, self.tool, self.operation, self.conditions, angle_rad).T
        if "a.angle" in recording or "c.angle" in recording:
            turned = TABLE.rotation(table_angles(recording))
            forces = np.einsum("ijn,jn->in", turned, forces)
        return {name: forces[FORCES.index(name)] for name in _forces(recording)}

    def phase(self, recording: Recording, angle_rad: Array, pitch: float) -> tuple[float, float]:
        """Return by which angle within a pitch teeth are off, and the squares left then, in shares
        of those left as it is.
        """
        some, rows = _examined(recording)

        def left(off: float) -> float:
            rest = [
                some[name] - values for name, values in self.at(some, angle_rad[rows] + off).items()
            ]
            return float(np.sum(np.array(rest) ** 2))

        step = pitch / PHASES
        best = min(np.arange(PHASES) * step, key=left)
        for _ in range(STEPS):
            best = min(best + step * np.linspace(-1.0, 1.0, 9), key=left)
            step /= 4.0
        off = float((best + 0.5 * pitch) % pitch - 0.5 * pitch)
        return off, left(off) / left(0.0)

    def in_step(self, recording: Recording, angle_rad: Array, *, degree: int) -> Array:
        """Return an angle (n,) that a curve of a degree puts in step with the recorded forces.

        Beside a factor on all of them, so that more force is not taken for another phase.
        """
        some, rows = _examined(recording)
        t = recording.t_s
        course = np.polynomial.legendre.legvander(2.0 * (t - t[0]) / (t[-1] - t[0]) - 1.0, degree)
        for _ in range(STEPS):
            early, now, late = (
                np.array([*self.at(some, angle_rad[rows] + by).values()])
                for by in (-NUDGE_RAD, 0.0, NUDGE_RAD)
            )
            slope = (late - early)[:, :, None] / (2.0 * NUDGE_RAD) * course[rows]
            columns = np.concatenate([slope, now[:, :, None]], axis=2).reshape(now.size, -1)
            rest = np.array([*_forces(some).values()]) - now
            off = np.linalg.lstsq(columns, rest.ravel(), rcond=1e-6)[0]
            angle_rad = angle_rad + course @ off[:-1]
        return angle_rad


def _examined(recording: Recording) -> tuple[Recording, NDArray[np.intp]]:
    """Return about ROWS rows of a recording, and which they are."""
    rows = np.arange(0, len(recording), max(1, len(recording) // ROWS))
    return replace(
        recording, channels={name: one[rows] for name, one in recording.channels.items()}, texts={}
    ), rows
