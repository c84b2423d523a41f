"""Forms in which an axis' current gives force or torque, the simplest first."""

from typing import Any

from autodb.sensing.ranges.forms.both_ways import GainEach, OneGain, of_one_way
from autodb.sensing.ranges.forms.form import CurrentForm, FittedForm, MeasuredCuts
from autodb.sensing.ranges.forms.fuzzy import (
    FEED_SETS,
    OF_CURRENT,
    OF_CURRENT_FEED,
    OF_CURRENT_SPEED,
    SPINDLE_SETS,
    Fuzzy,
)
from autodb.sensing.ranges.forms.line import LineOfSpeed, StraightLine
from autodb.sensing.ranges.forms.magnetised import Magnetised, MagnetisedOfSpeed
from autodb.sensing.ranges.forms.power import Power, PowerOfSpeed
from autodb.sensing.ranges.forms.warmed import Warmed

__all__ = [
    "BOTH_WAYS_FORMS",
    "FEED_FORMS",
    "FEED_SETS",
    "LAWS",
    "LINE",
    "LINE_OF_SPEED",
    "MAGNETISED",
    "MAGNETISED_OF_SPEED",
    "OF_CURRENT",
    "OF_CURRENT_FEED",
    "OF_CURRENT_SPEED",
    "POWER",
    "POWER_OF_SPEED",
    "SPINDLE_FORMS",
    "SPINDLE_SETS",
    "TANGENTIAL_FORMS",
    "WARMED_LINE",
    "WARMED_POWER",
    "WARMED_POWER_OF_SPEED",
    "CurrentForm",
    "FittedForm",
    "Fuzzy",
    "MeasuredCuts",
    "Warmed",
    "of_one_way",
    "stored_form",
]  # fmt: skip

LINE, LINE_OF_SPEED = StraightLine(), LineOfSpeed()
POWER, POWER_OF_SPEED = Power(), PowerOfSpeed()
MAGNETISED, MAGNETISED_OF_SPEED = Magnetised(), MagnetisedOfSpeed()
WARMED_LINE = Warmed(LINE)
WARMED_POWER = Warmed(POWER)
WARMED_POWER_OF_SPEED = Warmed(POWER_OF_SPEED)
FEED_FORMS: tuple[CurrentForm, ...] = (
    LINE, MAGNETISED, LINE_OF_SPEED, OF_CURRENT, OF_CURRENT_FEED,
)  # fmt: skip
BOTH_WAYS_FORMS: tuple[CurrentForm, ...] = (
    OneGain(LINE), OneGain(LINE_OF_SPEED), GainEach(LINE), GainEach(LINE_OF_SPEED),
)  # fmt: skip
"""Forms of a feed axis that was calibrated in both directions."""
SPINDLE_FORMS: tuple[CurrentForm, ...] = (
    LINE, MAGNETISED, WARMED_LINE, POWER, MAGNETISED_OF_SPEED, WARMED_POWER, POWER_OF_SPEED,
    WARMED_POWER_OF_SPEED, OF_CURRENT_SPEED,
)  # fmt: skip
"""Forms of the torque."""
TANGENTIAL_FORMS: tuple[CurrentForm, ...] = (LINE, WARMED_LINE)
"""Forms of a tangential force whose arm is not known."""
LAWS: tuple[CurrentForm, ...] = (
    LINE, LINE_OF_SPEED, MAGNETISED, MAGNETISED_OF_SPEED, POWER, POWER_OF_SPEED, WARMED_LINE,
    WARMED_POWER, WARMED_POWER_OF_SPEED,
)  # fmt: skip


def stored_form(kind: str, parameters: dict[str, Any] | None) -> CurrentForm:
    """Return the form that was kept by its kind and, of rules, their parameters."""
    if parameters is not None:
        return Fuzzy.of_parameters(parameters)
    return next(law for law in LAWS if law.kind == kind)
