"""How wide must an interval be where the law of friction is not known?

`python -m benchmarks.free_law`: widths as a ratio to the oracle's of docs/proofs/axes.md, for an
oracle that knows noise and reversal of the drawn axes but has a free spline in each direction in
place of the law. No estimator that must find the law can be narrower and right. 60 axes, seeds of
their own.
"""

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import BSpline

from autodb.proofs.machines.axis.axes import AxisRun, axis_columns, draw_run
from autodb.proofs.machines.axis.curves import reversal
from autodb.proofs.machines.axis.quantities import NAMES, TrueQuantity, quantities

Array = NDArray[np.float64]

SEEDS = range(200_001, 200_061)
LAW = ("coulomb", "viscous", "stribeck", "asymmetry")
KNOTS = (6, 9)
TOP_MM_S = 200.0


def spline(speed_mm_s: Array, count: int) -> Array:
    """Return ``count`` cubic B-splines (n, count) over the logarithm of speed."""
    top = float(np.log1p(TOP_MM_S))
    inner = np.linspace(0.0, top, count - 2)[1:-1]
    knots = np.concatenate([[0.0] * 4, inner, [top] * 4])
    inside = np.clip(np.log1p(speed_mm_s), 0.0, top)
    return np.asarray(BSpline.design_matrix(inside, knots, 3).toarray(), dtype=np.float64)


def free(velocity_mm_s: Array, direction: Array, count: int) -> Array:
    """Return columns of a spline for each direction, (n, 2 · count)."""
    over = spline(np.abs(velocity_mm_s), count)
    return np.column_stack([direction[:, None] * over, np.abs(direction)[:, None] * over])


def covariance(design: Array, run: AxisRun) -> Array:
    """Return the covariance (p, p) of generalised least squares with the noise known."""
    rho = run.axis.noise_rho
    white = (design[1:] - rho * design[:-1]) / (run.axis.noise_A * np.sqrt(1.0 - rho**2))
    scale = np.linalg.norm(white, axis=0)
    _, s, vt = np.linalg.svd(white / scale, full_matrices=False)
    return np.asarray((vt.T / s**2) @ vt / np.outer(scale, scale), dtype=np.float64)


def velocity_of(asked: TrueQuantity) -> float | None:
    """Return the velocity that a quantity is asked at, None where it is at none."""
    if " mm/s" not in asked.name:
        return None
    return float(asked.name.removesuffix(" mm/s").replace(",", " ").split()[-1])


def ratios(run: AxisRun, count: int) -> dict[str, float]:
    """Return how many times the oracle's width every quantity's has without the law."""
    axis, motion = run.axis, run.motion
    own = axis_columns(axis, x_mm=motion.x, v_mm_s=motion.v, a_mm_s2=motion.a)
    kept = [i for i, column in enumerate(own) if column.term not in LAW]
    known = covariance(np.column_stack([column.values for column in own]), run)
    direction = reversal(motion.v, axis.reversal_mm_s)
    without = [own[i].values for i in kept]
    loose = covariance(np.column_stack([*without, free(motion.v, direction, count)]), run)
    found = {}
    for asked in quantities(axis, motion):
        v = velocity_of(asked)
        part = np.zeros(2 * count)
        if v is not None:
            part = free(np.array([v]), np.sign([v]), count)[0]
        row = np.concatenate([asked.row[kept], part])
        found[asked.name] = float(np.sqrt((row @ loose @ row) / (asked.row @ known @ asked.row)))
    return found


def main() -> None:
    """Print the median ratio of every quantity."""
    for count in KNOTS:
        each = [ratios(draw_run(seed), count) for seed in SEEDS]
        print(f"{count} knots in each direction:")
        for name in NAMES:
            values = [one[name] for one in each if name in one]
            print(f"  {name}: {np.median(values):.2f} x the oracle's width")


if __name__ == "__main__":
    main()
