"""Cases in which a term of a recording's own full model is left out."""

import numpy as np

from autodb.proofs.cases.real.full_models import FULL_MODELS
from autodb.proofs.cases.real.injected import fitted_axis
from autodb.proofs.cases.real.real_case import RealCase, RealSpec
from autodb.proofs.cases.real.rival_names import rivals_of

LEFT_OUT_OF = (
    "emps", "emps-pulses", "emps-loaded", "odrive-slow", "odrive-slow-fed", "odrive-beside",
    "odrive-beside-fed", "odrive-pull", "odrive-pull-fed", "odrive-pull-fast",
    "odrive-pull-fast-fed",
)  # fmt: skip
"""Recordings of which nobody has left out anything yet."""
VARIANTS = ("kept", "refit")
WORSE = 1.2
"""Held-out error without a term, of that with it, from which it can be decided."""


def left_out_specs() -> list[RealSpec]:
    """Return a case of each term of each recording: the others kept, and refitted."""
    return [
        RealSpec("left out", recording, term, "", variant)
        for variant in VARIANTS
        for recording in LEFT_OUT_OF
        for term in FULL_MODELS[recording].terms
    ]


def left_out_case(spec: RealSpec) -> RealCase:
    """Make a case: ``seen`` says whether the model is decidably better with the term."""
    axis, model, rms_full = fitted_axis(spec.recording)
    less = model.without(spec.term)
    refitted = less.refitted(axis.effort)
    fitted = refitted if spec.variant == "refit" else less
    seen = refitted.held_out(axis.effort).rms >= WORSE * rms_full
    simulated = fitted.whole
    rivals = rivals_of(spec.term, axis, less, simulated, rms_full) if seen else {}
    return RealCase(
        spec, axis, simulated, less, rms_full, spec.term,
        {spec.term: float(np.max(np.abs(model.part(spec.term))))} | rivals, seen, less.terms,
        {term: float(np.max(np.abs(model.part(term)))) for term in less.terms},
        less.terms if spec.variant == "refit" else (), FULL_MODELS[spec.recording].reason,
    )  # fmt: skip
