"""Cases with an effect of known size in a real recording; what else it holds stays in."""

from collections.abc import Callable
from functools import cache

import numpy as np

from autodb.proofs.cases.real.full_models import FULL_MODELS, FittedModel, full_model
from autodb.proofs.cases.real.held_out import held_out
from autodb.proofs.cases.real.real_axis import Array, RealAxis
from autodb.proofs.cases.real.real_case import MISTUNED_BY, RealCase, RealSpec
from autodb.proofs.cases.real.real_effects import EFFECTS, NEEDED, Effect, effect_on
from autodb.proofs.cases.real.real_sources import READERS, real_axis
from autodb.proofs.cases.real.rival_names import rivals_of

SEED = 20
STRENGTHS = {"weak": 0.5, "strong": 2.0}
"""Rms of what the simulation's own columns cannot follow, in held-out errors of the full model."""
LEAST_SEEN = 0.3
LEAST_GAINED = 1.02
"""By how much the held-out error is larger without the effect, where it counts as seen."""
TUNINGS = ("exact", "mistuned", "refitted")
BESIDE_ANOTHER = ("smart-x", "smart-y", "tx40-j1", "tx40-j4")
"""Recordings in which another axis is recorded too."""
INJECTED_INTO = tuple(name for name in READERS if name != "emps-loaded")
"""One recording of moves each: those of `emps-loaded` are those of `emps-pulses`."""


def injectable(recording: str) -> tuple[str, ...]:
    """Return the terms that can be injected: which its full model lacks, and which can act."""
    own = FULL_MODELS[recording].terms
    return tuple(
        term
        for term in EFFECTS
        if term not in own
        and (term not in NEEDED or any(one in own for one in NEEDED[term]))
        and (term != "cross_coupling" or recording in BESIDE_ANOTHER)
    )


def injected_case(spec: RealSpec) -> RealCase:
    """Make a case: the effect is sized by what of it is left beside the model's own columns."""
    axis, model, rms = fitted_axis(spec.recording)
    effect = effect_on(spec.term, axis, model, effect_draws(spec))
    beside = Beside(model.columns)
    change = effect.change(_sized(effect, beside, STRENGTHS[spec.strength] * rms))
    changed = axis.with_effort(axis.effort + change)
    simulated, retuned = tuned_simulation(model, spec.recording, spec.variant, changed.effort)
    rms_full = held_out(np.vstack([model.columns, change]), changed.effort).rms
    without = model.held_out(changed.effort).rms
    seen = beside.rms(change) >= LEAST_SEEN * rms and without >= LEAST_GAINED * rms_full
    rivals = rivals_of(spec.term, changed, model, simulated, rms_full) if seen else {}
    return RealCase(
        spec, changed, simulated, model, rms_full, spec.term,
        {spec.term: float(np.max(np.abs(change)))} | rivals, seen, model.terms,
        {term: float(np.max(np.abs(model.part(term)))) for term in model.terms}, retuned,
    )  # fmt: skip


@cache
def fitted_axis(recording: str) -> tuple[RealAxis, FittedModel, float]:
    """Return a recording, its full model, and that model's held-out error."""
    axis = real_axis(recording)
    model = full_model(axis)
    return axis, model, model.held_out(axis.effort).rms


def tuned_simulation(
    model: FittedModel, recording: str, tuning: str, effort: Array
) -> tuple[Array, tuple[str, ...]]:
    """Return what a model says (n,) under a tuning, and the terms that this makes wrong."""
    if tuning == "exact":
        return model.whole, ()
    if tuning == "refitted":
        return model.refitted(effort).whole, model.terms
    rng = np.random.default_rng([SEED, list(READERS).index(recording)])
    term = str(rng.choice(model.terms))
    share = float(rng.choice((-MISTUNED_BY, MISTUNED_BY)))
    return model.mistuned(term, share).whole, (term,)


class Beside:
    """What of a change (n,) own columns (k, n) cannot follow."""

    def __init__(self, columns: Array) -> None:
        """Make an orthonormal basis of the columns."""
        scale = np.linalg.norm(columns, axis=1)
        scale[scale == 0.0] = 1.0
        left, values, _ = np.linalg.svd((columns / scale[:, None]).T, full_matrices=False)
        self.basis = left[:, values > 1e-9 * values[0]]

    def rms(self, change: Array) -> float:
        """Return the rms of what is left."""
        left = change - self.basis @ (self.basis.T @ change)
        return float(np.sqrt(np.mean(left**2)))


def _sized(effect: Effect, beside: Beside, wanted: float) -> float:
    """Return the size at which as much is left as is ``wanted``, at most the effect's most."""
    from scipy.optimize import brentq

    def missing(size: float) -> float:
        return beside.rms(effect.change(size)) - wanted

    if missing(effect.most) <= 0.0:
        return effect.most
    least = 1e-6 * effect.most
    if missing(least) >= 0.0:
        return effect.most  # a sign that is lost has one size
    return _root(brentq, missing, least, effect.most)


def _root(
    brentq: Callable[..., float], missing: Callable[[float], float], low: float, high: float
) -> float:
    return float(brentq(missing, low, high, rtol=1e-4, xtol=1e-9 * high))


def effect_draws(spec: RealSpec) -> np.random.Generator:
    """Return what draws an effect: the same at both strengths and in every tuning."""
    return np.random.default_rng(
        [SEED, list(READERS).index(spec.recording), EFFECTS.index(spec.term)]
    )
