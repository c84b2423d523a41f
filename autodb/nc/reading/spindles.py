"""What a block says of the spindle: speed, limits, whether it turns, and which one it is."""

from collections.abc import Mapping

from autodb.nc.reading.controls import LINUXCNC, OF_FANUC, SINUMERIK
from autodb.nc.reading.frames import names_axis
from autodb.nc.reading.lines.blocks import ProgramBlock, Word
from autodb.nc.reading.state import ProgramState, positive_value, word_value

_STARTS = frozenset({"M3", "M4", "M13", "M14", "M33", "M34"})
ANOTHER_SPINDLE = (
    "this starts another spindle than the one before, a second one or that of a driven tool; give "
    "what is cut with it as a program of its own, and state last_line in the job for what is before"
)


def starts_another(
    state: ProgramState, codes: Mapping[str, Word], values: Mapping[str, Word]
) -> bool:
    """Return whether M3 or M4 with P starts another spindle of a lathe than the first such P.

    Fanuc's lathes with several spindles choose one by P (Series 0i, multi-spindle control).
    """
    chooses = state.lathe and state.control in OF_FANUC and "P" in values
    if not chooses or not codes.keys() & _STARTS:
        return False
    state.spindle = state.spindle or values["P"].code
    return state.spindle != values["P"].code


def take_spindle(
    state: ProgramState,
    codes: Mapping[str, Word],
    values: Mapping[str, Word],
    block: ProgramBlock,
) -> None:
    """Take speed, limits and whether the spindle turns."""
    if "LIMS" in values:
        state.highest_rpm = positive_value(values["LIMS"], block)
    if codes.keys() & _STARTS or ("M1" in values and values["M1"].number in (3.0, 4.0)):
        state.turning, state.stopped = True, None
    if state.control is LINUXCNC and "G96" in codes and "D" in values:
        state.limit_rpm = positive_value(values["D"], block)
    if "G97" in codes and state.control is LINUXCNC:
        state.limit_rpm = None
    speed = values.get("S", values.get("S1"))
    if speed is None:
        return
    if word_value(speed) < 0:
        raise block.refusal(speed.text, "use a speed of at least 0")
    limits = codes.keys() & {"G50", "G92"}
    if limits and not names_axis(values):
        state.limit_rpm = positive_value(speed, block)
    elif state.control is SINUMERIK and codes.keys() & {"G25", "G26"}:
        state.highest_rpm = word_value(speed) if "G26" in codes else state.highest_rpm
    elif "G10" not in codes and "SPOS" not in values:
        _take_speed(state, word_value(speed))


def _take_speed(state: ProgramState, said: float) -> None:
    """Take a speed S; none is what a dial sets, where the job states it."""
    if said == 0.0 and state.dial_rpm is not None and not state.surface:
        state.note("the program says S0: the spindle turns at speed_rpm of the job")
        state.speed = state.dial_rpm
    else:
        state.set_surface_speed(said)
