"""Identifiers of every effect that a simulation may say it includes, modelled here or not."""

from autodb.terms import TERMS, Term

AXIS = frozenset(
    {
        "coulomb",
        "viscous",
        "stribeck",
        "asymmetry",
        "position_friction",
        "gravity",
        "spring",
        "cogging",
        "inertia",
        "cross_coupling",
        "warmup",
        "presliding",
        "backlash",
        "compliance",
        "external_load",
        "gain",
        "sensor_drift",
        "lag",
        "saturation",
        "lost_sign",
        "windage",
    }
)
CUTTING = frozenset(
    {
        "shear",
        "edge_force",
        "size_effect",
        "speed_softening",
        "built_up_edge",
        "tool_wear",
        "hard_spot",
        "depth_error",
        "nose_radius",
        "runout",
        "deflection",
        "chatter",
        "sensor_drift",
        "gain",
    }
)
TABLE = frozenset({"table_gravity", "table_inertia", "thermal_drift", "crosstalk"})

VOCABULARY: frozenset[str] = AXIS | CUTTING | TABLE


def term_called(name: str, form: str = "") -> Term:
    """Return the term of this name and form."""
    return next(t for t in TERMS if t.name == name and t.form == form)
