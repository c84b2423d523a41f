"""The physics of every channel: one term is one effect with named parameters.

A new one is a function and its term: here, or in another package (``autodb.terms.vocabulary``).
"""

from autodb.terms._term import (
    Channel,
    Contribution,
    Factor,
    Home,
    InputChange,
    NamedEffect,
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
from autodb.terms.warming import WARMUP

TERMS: tuple[Term, ...] = (
    INERTIA,
    VISCOUS,
    COULOMB,
    GRAVITY,
    TILT,
    STRIBECK,
    ASYMMETRY,
    POSITION_FRICTION,
    FRICTION_RIPPLE,
    SPRING,
    COGGING,
    COGGING_HARMONICS,
    COGGING_TABLE,
    CROSS_COUPLING,
    WARMUP,
    PRESLIDING,
    BACKLASH,
    COMPLIANCE,
    LAG,
    WINDAGE,
    EXTERNAL_LOAD,
    SENSOR_DRIFT,
    GAIN,
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
    "Home",
    "InputChange",
    "NamedEffect",
    "OutputChange",
    "ParameterPrior",
    "Term",
    "TermParameter",
]
