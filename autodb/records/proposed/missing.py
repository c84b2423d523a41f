"""What a recording or a table of cuts lacks for a command, by the channels that it has."""

from collections.abc import Collection, Iterator

from autodb.files.channels import FORCES
from autodb.wording import phrase


def missing_of_moves(channels: Collection[str]) -> Iterator[str]:
    """Yield what a recording over time lacks: the command, and what it needs."""
    if "t" not in channels:
        yield phrase('every command: time; state "t" = {row_in = "*", step_s = …} if rows are even')
    moved = {c.partition(".")[0] for c in channels if c.endswith((".position", ".velocity"))}
    efforts = (".current", "drive_torque", "drive_force")
    driven = {c.partition(".")[0] for c in channels if c.endswith(efforts)}
    if not moved & driven:
        yield phrase(
            "identify and explain: an axis with its position and its current, torque or force"
        )
    if not {*FORCES} & {*channels}:
        yield phrase("calibrate: a measured force, or the cuts of a protocol")


def missing_of_cuts(channels: Collection[str]) -> Iterator[str]:
    """Yield what a table of cuts lacks: the command, and what it needs."""
    if not {*FORCES} & {*channels}:
        yield phrase("calibrate: a measured force (force.x, force.y, force.z), or standard cuts")
    if not any(".current" in channel for channel in channels):
        yield phrase("calibrate: a current of the axis (z.current.range, spindle.current.range)")
    lacking = {"work.material", "tool", "cutting.feed", "cutting.depth"} - {*channels}
    if lacking:
        yield phrase("refresh and predict: {channels}", channels=", ".join(sorted(lacking)))
    if "operation" not in channels:
        yield phrase("what is not turned: operation; without it all cuts count as turned")
