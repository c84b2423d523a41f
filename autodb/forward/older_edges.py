"""Intervals of cuts with an older edge than a pair was learnt with: they leave room for usual wear.

Forces of edges nobody has seen are not those of fresh ones, and they grow. Where a pair's posterior
has no wear yet, the high end of a turned cut whose edge has cut T seconds before, when its cuts
have gone up to T_0, is farther off by

    g F (T - T_0) / T_L

with the growth g that edges have at a flank wear of 0.3 mm, by component: 26 % of the cutting
force, 117 % of the feed force, 78 % of the passive force, the middle of what Vicomtech's turning
tests of tools 3, 11, 13, 15 and 16 show at 0.27 to 0.39 mm. T_L is 900 s, the life of ISO 3685's
reference conditions; most shops plan for longer, so that few edges grow faster.
"""

from autodb.cutting.turning import PASSIVE_AXIS
from autodb.forward.prediction import PredictedCut
from autodb.forward.stretching import Reach, stretched

LIFE_S = 900.0
CUTTING, FEEDING, PASSIVE = 0.26, 1.17, 0.78
FEEDS = {"turn": "z", "face": "x"}
"""Axis along which a tool feeds, by operation; no other operation's wear is known so."""


def with_room_for_wear(cut: PredictedCut, *, cut_s: float, seen_s: float) -> PredictedCut:
    """Return a turned cut with room for the wear of an edge that has cut ``cut_s`` before.

    ``seen_s``: the longest that an edge had cut of those that the pair was learnt from. Cuts in a
    state of their own, and other operations, stay as they are.
    """
    feeds, passive = FEEDS.get(cut.operation), PASSIVE_AXIS.get(cut.operation)
    if feeds is None or cut.state is not None or cut_s <= seen_s:
        return cut
    older = (cut_s - seen_s) / LIFE_S
    growth = {"force_y_N": CUTTING, "torque_N_m": CUTTING, "power_W": CUTTING}
    growth |= {f"force_{feeds}_N": FEEDING, f"force_{passive}_N": PASSIVE}
    return stretched(cut, {name: _reach(cut, name, g * older) for name, g in growth.items()})


def _reach(cut: PredictedCut, name: str, grown: float) -> Reach:
    """Return how much farther the end is on the side to which the force grows."""
    own = getattr(cut, name)
    upwards = own.value >= 0.0
    room = (own.high - own.value) if upwards else (own.value - own.low)
    factor = 1.0 + grown * abs(own.value) / room if room > 0.0 else 1.0
    return (1.0, factor) if upwards else (factor, 1.0)
