"""Columns that name a quantity and no axis: those of one motor, where nothing else is said."""

from collections.abc import Iterator, Mapping

from autodb.errors import UnusableInput
from autodb.files.units import conversion
from autodb.records.proposed.names import NameSays, name_words
from autodb.wording import msgid, phrase

GUESSED = msgid("its name; which axis it is no name says")
_TURNS = {"rpm", "drehzahl", "giri", "rps"}
_OF_SPINDLE = {
    "velocity": "spindle.speed",
    "current": "spindle.current",
    "power": "spindle.power",
    "torque": "torque.spindle",
    "temperature": "spindle.temperature",
}
_OF_AXIS = {
    "position": "x.position",
    "velocity": "x.velocity",
    "current": "x.current",
    "torque": "x.drive_torque",
    "temperature": "x.temperature",
}
_WITH_UNIT = ("position", "velocity")
"""Quantities that are logged in too many units to be taken in ours where none is stated."""


def of_one_motor(
    said: Mapping[str, NameSays], units: Mapping[str, str]
) -> Iterator[tuple[str, str, str, str]]:
    """Yield column, channel, unit and reason of quantities that one column each is named by.

    A motor whose speed is in revolutions is a spindle, another one drives an axis; a force without
    a direction is along the tool. Nothing is said where a name says an axis.
    """
    able = {n: s for n, s in said.items() if s.quantity and not s.commanded and not s.foreign}
    if any(says.axis for says in able.values()):
        return
    turns = any(s.quantity == "velocity" and _turns(n, units.get(n, "")) for n, s in able.items())
    channels = {**(_OF_SPINDLE if turns else _OF_AXIS), "force": "force.z"}
    for name, says in able.items():
        alone = sum(other.quantity == says.quantity for other in able.values()) == 1
        known = bool(units.get(name)) or _turns(name, "") or says.quantity not in _WITH_UNIT
        if alone and known and says.quantity in channels:
            yield name, channels[says.quantity], units.get(name, ""), phrase(GUESSED)


def _turns(name: str, unit: str) -> bool:
    """Say whether a speed is one of revolutions, by its name or unit."""
    if not unit:
        return not _TURNS.isdisjoint(name_words(name))
    try:
        conversion(unit, to="rpm", where="")
    except UnusableInput:
        return False
    return True
