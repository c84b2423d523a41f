"""`PEER/bin/python -m benchmarks.axis_peers.answer CASE.npz ANSWER.npz`: an axis, identified.

CASE.npz holds a recording in air, ``x`` [mm], ``v`` [mm/s], ``a`` [mm/s²] and ``current`` [A], each
(n,), and ``asked`` (k, 2), places and speeds. ANSWER.npz gets the currents (k,) of steady motion
there by each method, with its version and seconds. Nothing else of the axis is known to a method;
rows in which it stands (below SLOW_MM_S) are left out, as sign(v) says nothing there, and of the
others every k-th is taken, MOST_ROWS at most.
"""

import sys
import tempfile
import time
from collections.abc import Callable
from importlib.metadata import version
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from benchmarks.peers.problem import split

Array = NDArray[np.float64]
Predicted = Callable[[Array, Array, Array], Array]
"""Currents (k,) over place, speed and acceleration."""

SLOW_MM_S = 1.0
MOST_ROWS = 6000
GAP_ROWS = 20
DIPS_MM_S = (1.0, 3.0, 10.0, 30.0)
URDF = """<robot name="axis"><link name="base"><inertial><mass value="1"/>
<inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial></link>
<link name="slide"><inertial><mass value="1"/>
<inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial></link>
<joint name="x" type="prismatic"><parent link="base"/><child link="slide"/><axis xyz="1 0 0"/>
<limit lower="-9" upper="9" effort="9" velocity="9"/></joint></robot>"""


def figaroh(x: Array, v: Array, a: Array, current: Array) -> Predicted:
    """FIGAROH: a prismatic joint with friction, drive inertia and offset, by least squares."""
    from figaroh.backends.pinocchio import PinocchioBackend
    from figaroh.tools.regressor import RegressorBuilder, RegressorConfig
    from figaroh.tools.solver import LinearSolver

    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "axis.urdf").write_text(URDF)
        backend = PinocchioBackend(f"{folder}/axis.urdf")
    robot = type("Robot", (), {"model": backend.model, "backend": backend})()
    has = RegressorConfig(has_friction=True, has_actuator_inertia=True, has_joint_offset=True)
    builder = RegressorBuilder(robot, has)

    def rows(x: Array, v: Array, a: Array) -> Array:
        moved = (one[:, None] / 1000.0 for one in (x, v, a))
        return np.asarray(builder.build_basic_regressor(*moved, {"act_idxv": [0]}))

    found = LinearSolver("lstsq").solve(rows(x, v, a), current)
    return lambda x, v, a: rows(x, v, a) @ found


def stribeck(x: Array, v: Array, a: Array, current: Array) -> Predicted:  # noqa: ARG001
    """SciPy: Stribeck's curve, viscous friction, inertia and weight, by least squares."""
    from scipy.optimize import least_squares

    def effort(p: Array, v: Array, a: Array) -> Array:
        dip = p[1] * np.exp(-((v / p[2]) ** 2))
        return np.asarray(np.sign(v) * (p[0] + dip) + p[3] * v + p[4] * a + p[5])

    size = float(np.std(current))

    def left(p: Array) -> Array:
        return effort(p, v, a) - current

    scale = [size, size, 1.0, size / 100.0, size / 1000.0, size]
    begins = [np.array([size, 0.1 * size, speed, 0.0, 0.0, 0.0]) for speed in DIPS_MM_S]
    tried = [least_squares(left, p, x_scale=[*scale[:2], p[2], *scale[3:]]) for p in begins]
    best = min(tried, key=lambda one: one.cost).x
    return lambda x, v, a: effort(best, v, a)  # noqa: ARG005


def sindy(x: Array, v: Array, a: Array, current: Array) -> Predicted:
    """pysindy: STLSQ on laws of friction; its threshold and ridge by blocks held out."""
    from benchmarks.peers.stlsq import sparse

    middle = float(np.mean(x))

    def rows(x: Array, v: Array, a: Array) -> Array:
        s = np.sign(v)
        found = [
            np.ones_like(v),
            a,
            v,
            s,
            np.abs(v),
            v * np.abs(v),
            v**3,
            s * (x - middle),
            x - middle,
        ]
        found += [np.arctan(v / dip) for dip in DIPS_MM_S]
        found += [s * np.exp(-np.abs(v) / dip) for dip in DIPS_MM_S]
        found += [s * np.exp(-((v / dip) ** 2)) for dip in DIPS_MM_S]
        return np.column_stack(found)

    found = sparse(rows(x, v, a), current, split(len(x), gap=GAP_ROWS))
    return lambda x, v, a: rows(x, v, a) @ found


def frols(x: Array, v: Array, a: Array, current: Array) -> Predicted:
    """SysIdentPy: FROLS on products of up to three of x, v, a and sign(v), sizes held out."""
    from sysidentpy.basis_function import Polynomial

    from benchmarks.peers.forward import forward

    scale = [(float(np.mean(one)), float(np.std(one))) for one in (x, v, a)]

    def rows(x: Array, v: Array, a: Array) -> Array:
        even = [(one - mean) / sd for one, (mean, sd) in zip((x, v, a), scale, strict=True)]
        columns = np.column_stack([np.ones_like(v), *even, np.sign(v)])
        return np.asarray(Polynomial(degree=3).fit(columns, 0, 1, 1, "NFIR"))

    found = forward(rows(x, v, a), current, split(len(x), gap=GAP_ROWS))
    return lambda x, v, a: rows(x, v, a) @ found


def boosting(x: Array, v: Array, a: Array, current: Array) -> Predicted:
    """scikit-learn: boosted trees over x, v, a and sign(v), its own settings."""
    from sklearn.ensemble import HistGradientBoostingRegressor

    def rows(x: Array, v: Array, a: Array) -> Array:
        return np.column_stack([x, v, a, np.sign(v)])

    trees = HistGradientBoostingRegressor(random_state=0).fit(rows(x, v, a), current)
    return lambda x, v, a: np.asarray(trees.predict(rows(x, v, a)))


METHODS = {
    "figaroh": (figaroh, "figaroh"),
    "stribeck": (stribeck, "scipy"),
    "sindy": (sindy, "pysindy"),
    "frols": (frols, "sysidentpy"),
    "boosting": (boosting, "scikit-learn"),
}
"""How each identifies, and the package that it needs."""


def main(case: Path, out: Path) -> None:
    """Answer one case by every method and write the answers."""
    with np.load(case) as held:
        x, v, a, current, asked = (held[name] for name in ("x", "v", "a", "current", "asked"))
    moves = np.flatnonzero(np.abs(v) >= SLOW_MM_S)
    moves = moves[:: -(-len(moves) // MOST_ROWS)]
    found = dict[str, Array]()
    for name, (identified, package) in METHODS.items():
        begun = time.perf_counter()
        predicted = identified(*(one[moves] for one in (x, v, a, current)))
        found[f"{name}/seconds"] = np.array(time.perf_counter() - begun)
        found[f"{name}/current"] = predicted(asked[:, 0], asked[:, 1], np.zeros(len(asked)))
        found[f"{name}/version"] = np.array(f"{package} {version(package)}")
    np.savez(out, allow_pickle=False, **found)


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]))
