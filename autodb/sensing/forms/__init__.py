"""Forms in which an axis' current tells force or torque, the plainest first."""

from typing import Any

from autodb.sensing.forms.form import Felt, Form, Law
from autodb.sensing.forms.fuzzy import (
    FEED_SETS,
    OF_CURRENT,
    OF_CURRENT_FEED,
    OF_CURRENT_SPEED,
    SPINDLE_SETS,
    Fuzzy,
)
from autodb.sensing.forms.line import Line, LineOfSpeed
from autodb.sensing.forms.power import Power, PowerOfSpeed

__all__ = [
    "FEED_FORMS", "FEED_SETS", "LAWS", "LINE", "LINE_OF_SPEED", "OF_CURRENT", "OF_CURRENT_FEED",
    "OF_CURRENT_SPEED", "POWER", "POWER_OF_SPEED", "SPINDLE_FORMS", "SPINDLE_SETS", "Felt", "Form",
    "Fuzzy", "Law", "kept",
]  # fmt: skip

LINE, LINE_OF_SPEED = Line(), LineOfSpeed()
POWER, POWER_OF_SPEED = Power(), PowerOfSpeed()
FEED_FORMS: tuple[Form, ...] = (LINE, LINE_OF_SPEED, OF_CURRENT, OF_CURRENT_FEED)
SPINDLE_FORMS: tuple[Form, ...] = (LINE, POWER, POWER_OF_SPEED, OF_CURRENT_SPEED)
"""Forms of the torque; of a tangential force without its arm only the line."""
LAWS: tuple[Form, ...] = (LINE, LINE_OF_SPEED, POWER, POWER_OF_SPEED)


def kept(kind: str, parameters: dict[str, Any] | None) -> Form:
    """Return the form that was kept by its kind and, of rules, their parameters."""
    if parameters is not None:
        return Fuzzy.of_parameters(parameters)
    return next(law for law in LAWS if law.kind == kind)
