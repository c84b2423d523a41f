"""What a fair reader reads off a summand of a formula: which term stands for these variables.

The names are those of `Problem.inputs`; the rule is in the README and was written before any score.
"""

from dataclasses import dataclass

from benchmarks.peers.problem import SIMULATED

UNKNOWN = "unknown"


@dataclass(frozen=True)
class Summand:
    """``names`` of its variables; ``even`` in the direction of motion; ``wave``: has a sine in it;
    ``straight``: proportional to its only variable but for an offset."""

    names: frozenset[str]
    even: bool = False
    wave: bool = False
    straight: bool = False


def axis_term(summand: Summand) -> str:
    """Return the term of an axis that a summand stands for, or `unknown`.

    >>> axis_term(Summand(frozenset({"x"}), wave=True))
    'cogging'
    """
    names = summand.names
    if names == {"x"}:
        return "cogging" if summand.wave else "spring"
    if names == {SIMULATED} and not summand.straight:
        return "lost_sign" if summand.even else "saturation"
    if names in ({"s"}, {"v"}, {"s", "v"}) and summand.even:
        return "asymmetry"
    if names == {"t"} and summand.wave:
        return UNKNOWN
    return AXIS.get(names, UNKNOWN)


def cut_term(summand: Summand) -> str:
    """Return the term of a table of cuts that a summand stands for, or `unknown`.

    >>> cut_term(Summand(frozenset({"sim", "speed"})))
    'speed_softening'
    """
    names = summand.names
    if names == {SIMULATED}:
        return "shear" if summand.straight else "deflection"
    return CUTS.get(names, CUTS.get(names - SIZE, UNKNOWN))


SIZE = frozenset({SIMULATED, "depth"})
"""What a force is proportional to, whatever changes it."""
AXIS = {
    frozenset[str](): "gravity",
    frozenset({"s"}): "coulomb",
    frozenset({"v"}): "viscous",
    frozenset({"s", "v"}): "stribeck",
    frozenset({"a"}): "inertia",
    frozenset({"s", "x"}): "position_friction",
    frozenset({"s", "v", "x"}): "position_friction",
    frozenset({"t"}): "sensor_drift",
    frozenset({"s", "t"}): "warmup",
    frozenset({"t", "v"}): "warmup",
    frozenset({"s", "t", "v"}): "warmup",
    frozenset({"ya"}): "cross_coupling",
    frozenset({SIMULATED}): "gain",
    frozenset({SIMULATED, "t"}): "gain",
}
CUTS = {
    frozenset({"depth"}): "edge_force",
    frozenset({"depth", SIMULATED}): "depth_error",
    frozenset({"feed"}): "size_effect",
    frozenset({"speed"}): "speed_softening",
    frozenset({"speed", "feed"}): "speed_softening",
    frozenset({"used"}): "tool_wear",
    frozenset({"used", "edge"}): "tool_wear",
    frozenset({"used", "feed"}): "tool_wear",
    frozenset[str](): "sensor_drift",
    frozenset({"t"}): "sensor_drift",
    frozenset({"number"}): "sensor_drift",
    frozenset({"t", SIMULATED}): "gain",
    frozenset({"number", SIMULATED}): "gain",
}
