"""What the effects of a milled waveform are, in shop words, and what would tell them apart."""

from collections.abc import Sequence

STATEMENTS = {
    "edge_force": "The cutting edge rubs: a force that does not depend on the chip's thickness.",
    "size_effect": "Thin chips take more force for their area than thick ones.",
    "tool_wear": "The edge wears while it cuts: its rubbing force grows within the recording.",
    "runout": "The teeth do not stand out alike: one takes more, the next finds less.",
    "depth_error": "The mill cut deeper or shallower than the simulation has it.",
    "deflection": "Tool or work springs away: the harder the cut, the less of it is taken.",
    "chatter": "The cut rings at a frequency of its own, which is no multiple of the spindle's.",
    "hard_spot": "For a stretch the material is harder or softer.",
    "gain": "One component is scaled while the others are not.",
    "sensor_drift": "The sensor's zero wanders with the clock, in air too.",
    "thermal_drift": "The sensor's zero moves while chips heat it, and comes back in air.",
    "crosstalk": "The sensor mixes its components: one shows a share of another.",
    "table_gravity": "A mass on the tilted table weighs on the sensor.",
    "table_inertia": "A mass on the swinging table pulls on the sensor.",
}
APART: dict[frozenset[str], str] = {
    frozenset(pair): words
    for *pair, words in (
        ("edge_force", "size_effect", "Repeat the cut at a tenth of the feed: the edge's force "
         "stays as it is, the extra force of thin chips nearly goes with the chip."),
        ("edge_force", "depth_error", "Repeat the cut at twice the depth: the edge's force "
         "doubles, what a wrong depth adds stays."),
        ("edge_force", "tool_wear", "Repeat the cut with a new edge: worn-on force is gone, the "
         "edge's own is there."),
        ("tool_wear", "sensor_drift", "Let the sensor stand in air after the cut: drift goes on, "
         "wear shows nothing there."),
        ("tool_wear", "thermal_drift", "Repeat the cut after a pause of some minutes: heat has "
         "gone, wear has not."),
        ("tool_wear", "gain", "Repeat the cut with a new edge: wear falls back, a scale does not."),
        ("tool_wear", "hard_spot", "Repeat the cut beside the last one: a hard place is in the "
         "work, wear is on the edge and goes on."),
        ("sensor_drift", "thermal_drift", "Record some minutes of air after the cut: heat drift "
         "comes back, the clock's goes on."),
        ("sensor_drift", "table_gravity", "Tilt the table once without cutting: weight follows the "
         "angle, drift the clock."),
        ("sensor_drift", "table_inertia", "Swing the table once without cutting: inertia shows "
         "there, drift does not follow it."),
        ("runout", "deflection", "Repeat the cut at twice the feed: run-out stays the same in "
         "millimetres, bending grows with the force."),
        ("runout", "depth_error", "Compare single turns: run-out differs from tooth to tooth, a "
         "depth does not."),
        ("runout", "chatter", "Repeat the cut at another spindle speed: run-out stays at multiples "
         "of the turn, chatter at its own frequency."),
        ("gain", "depth_error", "Load the sensor with a known weight: a scale shows, a depth does "
         "not."),
        ("gain", "crosstalk", "Load the sensor along one axis with a known weight: crosstalk shows "
         "in the others."),
        ("gain", "deflection", "Load the sensor with a known weight: a scale shows, bending of the "
         "tool does not."),
        ("deflection", "depth_error", "Repeat the cut with a shorter overhang: bending goes, a "
         "wrong depth stays."),
        ("deflection", "size_effect", "Repeat the cut with a shorter overhang: bending goes, the "
         "force of thin chips stays."),
        ("hard_spot", "depth_error", "Measure the depth along the cut: over a hard stretch it is "
         "as elsewhere."),
    )
}  # fmt: skip
MOST = 2
"""Alternatives that are told what would separate."""


def words_that_tell(name: str, others: Sequence[str]) -> str | None:
    """Return what would tell an effect from its nearest alternatives; None where none is known."""
    pairs = (frozenset((name, other)) for other in others[:MOST])
    lines = dict.fromkeys(APART[pair] for pair in pairs if pair in APART)
    return " ".join(lines) or None
