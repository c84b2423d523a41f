"""The physics of every channel: one term is one effect with named parameters.

A new one is a function and its term here, and what docs/architecture.md lists under "Add an
effect".
"""

from autodb.terms._term import (
    Channel,
    Contribution,
    Factor,
    InputChange,
    OutputChange,
    ParameterPrior,
    Term,
    TermParameter,
)
from autodb.terms.chip import BUILT_UP_EDGE, HARD_SPOT, SIZE_EFFECT, SPEED_SOFTENING
from autodb.terms.drive import (
    COGGING,
    COMPLIANCE,
    CROSS_COUPLING,
    EXTERNAL_LOAD,
    FRICTION_RIPPLE,
    GRAVITY,
    INERTIA,
    SPRING,
    TILT,
    WARMUP,
    WINDAGE,
)
from autodb.terms.engagement import DEFLECTION, DEPTH_ERROR
from autodb.terms.friction import (
    ASYMMETRY,
    BACKLASH,
    COULOMB,
    POSITION_FRICTION,
    PRESLIDING,
    STRIBECK,
    VISCOUS,
)
from autodb.terms.nose import NOSE_AXIAL, NOSE_LENGTH, NOSE_RADIAL, NOSE_THINNING
from autodb.terms.process import EDGE_FORCE, EDGE_WEAR, SHEAR, TOOL_WEAR
from autodb.terms.ripple import COGGING_HARMONICS, COGGING_TABLE
from autodb.terms.sensor import GAIN, LAG, LOST_SIGN, SATURATION, SENSOR_DRIFT
from autodb.terms.table import (
    CROSSTALK,
    TABLE_GRAVITY_X,
    TABLE_GRAVITY_Y,
    TABLE_GRAVITY_Z,
    TABLE_INERTIA_X,
    TABLE_INERTIA_Y,
    TABLE_INERTIA_Z,
    THERMAL_DRIFT,
)

TERMS: tuple[Term, ...] = (
    COULOMB,
    VISCOUS,
    STRIBECK,
    ASYMMETRY,
    POSITION_FRICTION,
    FRICTION_RIPPLE,
    GRAVITY,
    TILT,
    SPRING,
    COGGING,
    COGGING_HARMONICS,
    COGGING_TABLE,
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
    EDGE_WEAR,
    SIZE_EFFECT,
    SPEED_SOFTENING,
    BUILT_UP_EDGE,
    HARD_SPOT,
    DEPTH_ERROR,
    NOSE_AXIAL,
    NOSE_RADIAL,
    NOSE_LENGTH,
    NOSE_THINNING,
    DEFLECTION,
    TABLE_GRAVITY_X,
    TABLE_GRAVITY_Y,
    TABLE_GRAVITY_Z,
    TABLE_INERTIA_X,
    TABLE_INERTIA_Y,
    TABLE_INERTIA_Z,
    THERMAL_DRIFT,
    CROSSTALK,
)

__all__ = [
    "COGGING",
    "COGGING_HARMONICS",
    "COGGING_TABLE",
    "FRICTION_RIPPLE",
    "TERMS",
    "Channel",
    "Contribution",
    "Factor",
    "InputChange",
    "OutputChange",
    "ParameterPrior",
    "Term",
    "TermParameter",
]
