"""Forward: a pair's parameters become forces, torque and power of cuts not yet made."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from autodb.cutting import law, turning
from autodb.fitting import NORMAL_95
from autodb.inverse import Parameters
from autodb.jobs import JobCut

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Interval:
    """A predicted value with its 95 % interval, in the unit that the holder names."""

    value: float
    low: float
    high: float


@dataclass(frozen=True)
class PredictedCut:
    """What one cut will take; None where the machine has not felt that component.

    Speeds, torque and power are those at the largest diameter of the cut.
    """

    name: str
    speed_rpm: float
    speed_m_min: float
    force_x_N: Interval | None
    force_y_N: Interval | None
    force_z_N: Interval | None
    torque_N_m: Interval | None
    power_W: Interval | None


def force_N(feed_mm: Array, depth_mm: Array, parameters: Parameters) -> tuple[Array, Array]:
    """Return the mean force and the standard deviation of the next cut's force, each (n,).

    Variance = design · covariance · designᵀ + misfit² + (process share · F)²: parameters (which
    hold the calibration's common error), misfit of the law, process scatter. Sensing noise is not
    in it: it is the force that is predicted, not its next reading.
    """
    design = law.design(feed_mm, depth_mm)
    mean = design @ parameters.belief.mean
    variance = np.einsum("ni,ij,nj->n", design, parameters.belief.covariance, design)
    process = (parameters.process_share * mean) ** 2
    return mean, np.sqrt(variance + parameters.misfit_N**2 + process)


def predict(cut: JobCut, parameters: dict[str, Parameters]) -> PredictedCut:
    """Predict one job cut from the pair's parameters in its operation, by component (x, y, z)."""
    feed, depth = np.array([cut.feed_mm_rev]), np.array([cut.depth_mm])
    forces = {
        component: _interval(*force_N(feed, depth, known))
        for component, known in parameters.items()
    }
    tangential = forces.get("y")
    facing = np.array([cut.operation == "face"])
    largest = np.array([cut.largest_diameter_mm])
    radius_mm = turning.effective_radius_mm(largest, depth, facing=facing)
    speed = _speeds(cut)
    return PredictedCut(
        name=cut.name,
        speed_rpm=speed[0],
        speed_m_min=speed[1],
        force_x_N=forces.get("x"),
        force_y_N=tangential,
        force_z_N=forces.get("z"),
        torque_N_m=_scaled(tangential, float(radius_mm[0]) / 1000.0),
        power_W=_scaled(tangential, speed[1] / 60.0),
    )


def _speeds(cut: JobCut) -> tuple[float, float]:
    """Return spindle speed [rpm] and cutting speed [m/min] at the largest diameter."""
    per_rev_m = float(np.pi) * cut.largest_diameter_mm / 1000.0
    if cut.speed_rpm is not None:
        return cut.speed_rpm, cut.speed_rpm * per_rev_m
    assert cut.speed_m_min is not None  # the job file's check
    return cut.speed_m_min / per_rev_m, cut.speed_m_min


def _interval(mean: Array, sd: Array) -> Interval:
    value, half = float(mean[0]), NORMAL_95 * float(sd[0])
    return Interval(value, value - half, value + half)


def _scaled(interval: Interval | None, factor: float) -> Interval | None:
    if interval is None:
        return None
    return Interval(interval.value * factor, interval.low * factor, interval.high * factor)
