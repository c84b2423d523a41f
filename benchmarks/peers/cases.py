"""A concealed case as a problem: what a user has, inputs derived as autodb does, no truth."""

import numpy as np

from autodb.proofs.cases.base.case import Array, Case
from autodb.proofs.runs.explain.left_out import tables
from autodb.records.tables import Recording
from autodb.sensing.drives.moves.motion import axis_motion
from autodb.sensing.drives.moves.protocol import default_protocol
from benchmarks.peers.problem import Problem

AXES = ("x", "y")
COLUMNS = {
    "cut": "number",
    "t": "t",
    "cutting.speed": "speed",
    "cutting.feed": "feed",
    "cutting.depth": "depth",
    "work.diameter": "diameter",
    "spindle.speed": "rpm",
    "tool.cutting_time": "used",
    "z.position": "z",
    "tool.edge": "edge",
}
"""Names of a table's columns in formulas."""


def problem_of(case: Case) -> Problem:
    """Return a case as every method sees it."""
    recording, _ = tables(case)
    n = case.measured.shape[-1]
    return Problem(
        names=case.explained,
        measured=case.measured.reshape(-1, n),
        simulated=case.simulated.reshape(-1, n),
        inputs=_moves(recording) if isinstance(recording, Recording) else _cuts(case),
        rate_hz=recording.rate_hz if isinstance(recording, Recording) else 0.0,
        recording=case.channels,
        simulation=case.simulation,
    )


def _moves(recording: Recording) -> dict[str, Array]:
    """Time, position, velocity, acceleration and direction; of another axis the first three."""
    cutoff_hz = default_protocol(recording.rate_hz).cutoff_hz
    x, y = (axis_motion(recording, axis, cutoff_hz=cutoff_hz) for axis in AXES)
    signals = {
        "t": recording.t_s,
        "x": x.position,
        "v": x.velocity,
        "a": x.acceleration,
        "s": x.direction,
        "y": y.position,
        "yv": y.velocity,
        "ya": y.acceleration,
    }
    return {name: values for name, values in signals.items() if np.ptp(values) > 0}


def _cuts(case: Case) -> dict[str, Array]:
    return {short: case.channels[name] for name, short in COLUMNS.items() if name in case.channels}
