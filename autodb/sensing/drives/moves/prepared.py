"""One axis' recording, filtered and reduced, ready to be fitted."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from autodb.errors import UnusableInput
from autodb.files.channels import axis_of, effort_channels, linear_efforts, rotary_efforts
from autodb.records.tables import Recording
from autodb.sensing.drives.moves.motion import (
    SPINDLE,
    protocol_of,
    spindle_inputs,
    term_inputs,
)
from autodb.sensing.drives.moves.protocol import FilterProtocol
from autodb.timing import Timing
from autodb.wording import phrase

Array = NDArray[np.float64]

SHORTEST_ROWS = 100
SPINDLE_EFFORTS = ("torque.spindle", "spindle.current")


def effort_channel(recording: Recording, axis: str | None) -> str:
    """Return the effort channel of ``axis``, or the only one there is.

    The spindle's, torque before current, only where ``axis`` is `spindle`.

    Raises UnusableInput where there is none or the choice is open.
    """
    if axis == SPINDLE:
        return _spindle_effort(recording)
    found = _efforts(list(recording.channels), axis)
    if not found:
        gaps = _efforts(list(recording.unusable), axis)
        if gaps:
            raise UnusableInput(recording.unusable[gaps[0]])
        moving = (axis_of(name) for name in recording.channels if name.endswith(".position"))
        axis = axis or next(moving, "x")
        wanted = f"{axis}.current"
        raise UnusableInput(
            phrase(
                "{file}: no drive effort{near}; record '{wanted}' or '{axis}.drive_force'",
                file=recording.path,
                near=recording.near(wanted),
                wanted=wanted,
                axis=axis,
            )
        )
    if len({axis_of(name) for name in found}) > 1:
        raise UnusableInput(
            phrase(
                "{file}: several axes ({names}); give --axis",
                file=recording.path,
                names=", ".join(found),
            )
        )
    return found[0]


def _efforts(names: list[str], axis: str | None) -> list[str]:
    """Return the efforts of an axis; of all linear ones, or else of the rotary ones."""
    if axis is None:
        return linear_efforts(names) or rotary_efforts(names)
    return [name for name in effort_channels(names) if axis_of(name) == axis]


def _spindle_effort(recording: Recording) -> str:
    for name in SPINDLE_EFFORTS:
        if recording.get(name) is not None:
            return name
    raise UnusableInput(
        phrase(
            "{file}: no spindle effort{near}; record 'spindle.current' or 'torque.spindle'",
            file=recording.path,
            near=recording.near("spindle.current"),
        )
    )


def effort_axis(recording: Recording, axis: str | None) -> str:
    """Return the axis that is identified: ``axis``, or the only one with an effort."""
    return axis or axis_of(effort_channel(recording, axis))


@dataclass(frozen=True)
class Prepared:
    """One axis' recording, ready to be fitted.

    ``inputs`` (n,) and ``whole_effort`` (n,) at every row, ``effort`` (m,) as reduced.
    """

    path: str
    axis: str
    channel: str
    unit: str
    inputs: dict[str, Array]
    effort: Array
    whole_effort: Array
    protocol: FilterProtocol
    timing: Timing

    @property
    def rate_hz(self) -> float:
        """Rows per second of the inputs."""
        return self.timing.rate_hz

    def by(self, protocol: FilterProtocol) -> "Prepared":
        """Return the same recording reduced by another protocol."""
        smooth = protocol.smoothed(self.whole_effort, timing=self.timing)
        effort = protocol.reduced(smooth, timing=self.timing)
        return replace(self, effort=effort, protocol=protocol)

    def reduced(self, values: Array) -> Array:
        """Return values (n,) or (n, k) as the effort was reduced, (m,) or (m, k)."""
        return self.protocol.reduced(values, timing=self.timing)

    def sampled(self, name: str) -> Array:
        """Return an input (m,) at the rows that are kept."""
        return self.protocol.sampled(self.inputs[name], timing=self.timing)

    @property
    def middle_mm(self) -> float:
        """Middle of the travel; 0 where there is none."""
        place = self.inputs.get("position", np.zeros(1))
        return 0.5 * float(place.min() + place.max())


def prepared(
    recording: Recording, *, axis: str | None = None, protocol: FilterProtocol | None = None
) -> Prepared:
    """Filter and reduce one axis of a recording.

    Raises UnusableInput without effort or position, or when it is too short or all zero.
    """
    channel = effort_channel(recording, axis)
    if len(recording) < SHORTEST_ROWS:
        raise UnusableInput(
            phrase(
                "{file}: {n} rows are too few to identify an axis; record at least {shortest_rows}",
                file=recording.path,
                n=len(recording),
                shortest_rows=SHORTEST_ROWS,
            )
        )
    timing = recording.timing
    name = effort_axis(recording, axis)
    protocol = protocol or protocol_of(recording, name)
    of = spindle_inputs if name == SPINDLE else term_inputs
    inputs = of(recording, name, cutoff_hz=protocol.cutoff_hz)
    effort = protocol.smoothed(recording[channel], timing=timing)
    rows = protocol.reduced(effort, timing=timing)
    if len(rows) < 50:
        raise UnusableInput(
            phrase(
                "{file}: too short to identify an axis; record at least 2 s", file=recording.path
            )
        )
    if not np.any(np.abs(inputs["direction"]) >= 1.0):
        raise UnusableInput(
            phrase(
                "{file}: {name} does not move enough to identify it", file=recording.path, name=name
            )
        )
    if not np.any(rows):
        raise UnusableInput(
            phrase("{file}: {channel} is zero in every row", file=recording.path, channel=channel)
        )
    return Prepared(
        path=str(recording.path),
        axis=name,
        channel=channel,
        unit=recording.unit(channel),
        inputs=inputs,
        effort=rows,
        whole_effort=recording[channel],
        protocol=protocol,
        timing=timing,
    )
