"""The physics of every channel: one term is one effect with named parameters.

Adding physics is one function and its test: write the function, list its term in ``TERMS``.
"""

from autodb.terms._term import (
    Belief,
    Contribution,
    Factor,
    InputChange,
    OutputChange,
    Parameter,
    Term,
)
from autodb.terms.drive import (
    COGGING,
    COMPLIANCE,
    CROSS_COUPLING,
    EXTERNAL_LOAD,
    FRICTION_RIPPLE,
    GRAVITY,
    INERTIA,
    SPRING,
    WARMUP,
    WINDAGE,
)
from autodb.terms.friction import (
    ASYMMETRY,
    BACKLASH,
    COULOMB,
    POSITION_FRICTION,
    PRESLIDING,
    STRIBECK,
    VISCOUS,
)
from autodb.terms.process import EDGE_FORCE, SHEAR, TOOL_WEAR
from autodb.terms.sensor import GAIN, LAG, LOST_SIGN, SATURATION, SENSOR_DRIFT

TERMS: tuple[Term, ...] = (
    COULOMB,
    VISCOUS,
    STRIBECK,
    ASYMMETRY,
    POSITION_FRICTION,
    FRICTION_RIPPLE,
    GRAVITY,
    SPRING,
    COGGING,
    INERTIA,
    CROSS_COUPLING,
    WARMUP,
    PRESLIDING,
    BACKLASH,
    COMPLIANCE,
    EXTERNAL_LOAD,
    WINDAGE,
    SENSOR_DRIFT,
    GAIN,
    LAG,
    SATURATION,
    LOST_SIGN,
    SHEAR,
    EDGE_FORCE,
    TOOL_WEAR,
)

__all__ = [
    "COGGING",
    "FRICTION_RIPPLE",
    "TERMS",
    "Belief",
    "Contribution",
    "Factor",
    "InputChange",
    "OutputChange",
    "Parameter",
    "Term",
]
