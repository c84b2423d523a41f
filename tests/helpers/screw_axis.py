"""A ball-screw axis in amperes that moves there and back, and a real one in newtons."""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from autodb.records.tables import Recording

Array = NDArray[np.float64]
RATE = 500.0
MASS_A, COULOMB_A, VISCOUS_A = 6e-4, 0.7, 1.1e-3
"""A s²/mm, A, A s/mm: a ball-screw axis in amperes."""
NOISE_A = 0.03


def _motion(seed: int, moves: int) -> tuple[Array, Array, Array]:
    """Return position, velocity and acceleration of moves there and back at several feeds."""
    rng = np.random.default_rng([seed, 0])
    velocity = [np.zeros(100)]
    for move in range(moves):
        top = rng.uniform(10.0, 180.0) * (1.0 if move % 2 == 0 else -1.0)
        ramp, run = np.linspace(0.0, top, 60), np.full(int(60.0 / abs(top) * RATE), top)
        velocity += [ramp, run, ramp[::-1], np.zeros(40)]
    v = np.concatenate(velocity)
    return np.cumsum(v) / RATE, v, np.gradient(v) * RATE


def screw_moves(
    seed: int, load_A: Array | None = None, *, moves: int = 16, friction: float = 1.0
) -> Recording:
    x, v, a = _motion(seed, moves)
    effort = MASS_A * a + friction * (COULOMB_A * np.sign(v) + VISCOUS_A * v)
    effort += NOISE_A * np.random.default_rng([seed, 1]).standard_normal(len(v))
    if load_A is not None:
        effort += load_A
    channels = {"t": np.arange(len(v)) / RATE, "z.position": x, "z.current": effort}
    return Recording(path=Path(f"moves-{seed}.csv"), channels=channels)


def emps_axis(path: Path, *, by_law: bool) -> tuple[Recording, Array]:
    """Return an EMPS file in N and mm, with the effort of the controller's law, and its pulses.

    The law and its gains are the data's own (EMPS_Description.pdf): kp kv (qg − qm) − kv v.
    """
    from scipy.io import loadmat

    table = loadmat(path)
    t, q, goal = (table[name].ravel().astype(np.float64) for name in ("t", "qm", "qg"))
    kp, kv, newtons_per_volt = 160.18, 243.45, 35.15065188
    law = kp * kv * (goal - q) - kv * np.gradient(q, t)
    volts = law if by_law else table["vir"].ravel().astype(np.float64)
    pulses = table["pulses_N"].ravel() if "pulses_N" in table else np.zeros_like(t)
    channels = {
        "t": t - t[0],
        "x.position": 1000.0 * q,
        "x.drive_force": newtons_per_volt * volts,
    }
    return Recording(path=path, channels=channels), 1.014 * newtons_per_volt * pulses


def write_moves(path: Path, recording: Recording) -> None:
    names = list(recording.channels)
    rows = np.column_stack([recording.channels[name] for name in names])
    np.savetxt(path, rows, delimiter=",", header=",".join(names), comments="", fmt="%.9g")


MACHINE = """
[axes.z]
carries = "tool"
screw_pitch_mm = 10
[axes.z.torque_constant_N_m_A]
value = 0.8
lower = 0.72
upper = 0.88
source = "data sheet"
status = "not verified"
date = "2026-01-15"
"""


def bare(text: str) -> float:
    return float(text.strip('"'))


TWO_AXES = "[axes.x]\n[axes.z]\n"
