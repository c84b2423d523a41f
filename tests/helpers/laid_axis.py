"""An axis laid out by hand, in place of a recording: known terms, known noise."""

from functools import cache

import numpy as np

from autodb.proofs.cases.real.full_models import FittedModel, full_model
from autodb.proofs.cases.real.real_axis import Array, RealAxis
from autodb.proofs.cases.real.real_case import RealCase, RealSpec

NOISE = 0.05
KNOWN = {"inertia": 0.002, "viscous": 0.01, "coulomb": 1.2, "asymmetry": 0.002}
"""The terms of the model of `emps`, whose name the axis bears."""


def laid_axis(name: str = "emps", *, seconds: float = 24.0, one_way: bool = False) -> RealAxis:
    """Return an axis at 100 Hz that moves at several speeds, stands, and turns round."""
    t = np.arange(round(100.0 * seconds)) / 100.0
    speed = 40.0 * np.sin(1.3 * t) + 25.0 * np.sin(3.1 * t + 1.0)
    speed = np.where((t % 8.0) > 7.0, 0.0, speed)
    v = np.abs(speed) + 5.0 if one_way else speed
    v = np.convolve(v, np.ones(15) / 15.0, mode="same")
    x, a = np.cumsum(v) / 100.0, np.gradient(v, t)
    bare = RealAxis(name, "laid", "x", "x.current", t, x, np.zeros(len(t)), 20.0, v, a)
    return bare.with_effort(law_of(bare) + NOISE * np.random.default_rng(7).normal(size=len(t)))


def law_of(axis: RealAxis) -> Array:
    """Return the effort (n,) of the known terms, A."""
    return np.asarray(
        KNOWN["inertia"] * axis.a
        + KNOWN["viscous"] * axis.v
        + KNOWN["coulomb"] * axis.direction
        + KNOWN["asymmetry"] * np.abs(axis.v)
    )


@cache
def fitted_laid_axis(name: str) -> tuple[RealAxis, FittedModel, float]:
    """Return the axis, its full model and that model's held-out error, as of a recording."""
    axis = laid_axis(name)
    model = full_model(axis)
    return axis, model, model.held_out(axis.effort).rms


def hand_case(
    concealed: str | None = "coulomb", *, fair: tuple[str, ...] = (), kind: str = "left out",
    variant: str = "kept", strength: str = "", seen: bool = True,
) -> RealCase:  # fmt: skip
    """Return a case of the laid-out axis with one of its own terms left out, or none."""
    axis, model, rms_full = fitted_laid_axis("emps")
    less = model if concealed is None else model.without(concealed)
    sizes = {}
    if concealed is not None:
        peak = float(np.max(np.abs(model.part(concealed))))
        sizes = dict.fromkeys((concealed, *fair), peak)
    return RealCase(
        RealSpec(kind, "emps", concealed or "", strength, variant), axis, less.whole, less,
        rms_full, concealed, sizes, seen, less.terms,
        {term: float(np.max(np.abs(model.part(term)))) for term in less.terms},
    )  # fmt: skip
