"""The card of a machine: its axes, what none of them senses, and when to calibrate again."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from autodb.cutting.turning import PASSIVE_AXIS
from autodb.fitting.gaussian import NORMAL_95
from autodb.reports.card.axis_figures import AxisCard
from autodb.sensing.ranges.calibration import Calibration
from autodb.sensing.ranges.error_kinds import DAY_SHARE
from autodb.sensing.ranges.points import COMPONENT_OF_AXIS
from autodb.sensing.ranges.validity import ANY


@dataclass(frozen=True)
class CalibrationCard:
    """What a card shows. ``title``: the machine, or the files; ``made``: the day, as text.

    ``axes`` of the machine, ``versions`` stored of those calibrated (empty: nothing is stored);
    ``left_out``: sentences why an axis could not be calibrated.
    """

    title: str
    made: str
    sources: tuple[str, ...]
    axes: tuple[str, ...]
    cards: tuple[AxisCard, ...]
    versions: tuple[int, ...]
    left_out: tuple[str, ...]


def not_sensed(card: CalibrationCard) -> list[tuple[str, str]]:
    """Return which force is not sensed, and why."""
    found = [
        (f"force.{component}, in any cut", f"there is no axis {axis}")
        for axis, component in COMPONENT_OF_AXIS.items()
        if axis not in card.axes
    ]
    found += [("an axis without a calibration, in any cut", sentence) for sentence in card.left_out]
    for one in (each.calibration for each in card.cards):
        force = f"force.{one.component}"
        if not one.offered:
            where = f" with {one.holds.words()}" if one.holds != ANY else ""
            found.append((f"{force}, in any cut{where}", f"axis {one.called} is {one.verdict}"))
            continue
        if one.holds != ANY:
            found.append(
                (
                    f"{force}, in other cuts than those with {one.holds.words()}",
                    "this calibration was not made on them",
                )
            )
        found += [
            (f"{force}, where the operation is '{operation}'",
             f"axis {axis} stands still: a passive force shows in no current")
            for operation, axis in PASSIVE_AXIS.items()
            if axis == one.axis
        ]  # fmt: skip
    return found


def when_again(cards: Sequence[AxisCard]) -> list[str]:
    """Return what is known of when a calibration ends; no period is."""
    return [
        "After a change of drive or its parameters, motor, current sensor, screw, bearings or way "
        "oil: the equations describe the axes as they were.",
        "When a standard cut, made once more, has moved by more than the interval that repeats "
        "give it.",
        "When currents leave the range that an axis was calibrated over: further out the equation "
        "was not tested.",
        *_wander([card.calibration for card in cards if card.calibration.offered]),
        "For how many weeks a calibration holds is not known: these cuts say nothing of it.",
    ]


def _wander(calibrations: Sequence[Calibration]) -> Iterator[str]:
    """Yield by how much axes are known to differ from day to day, or from group to group."""
    still = [one.called for one in calibrations if not _differs(one)]
    if still:
        yield (
            f"{'Axis' if len(still) == 1 else 'Axes'} {' and '.join(still)}: over these cuts "
            "the gain drifted no more than by chance. These cuts do not show how far it differs "
            "on another day; the intervals include nothing for it."
        )
    for one in calibrations:
        if one.errors.gain_share:
            yield _known(one)
        elif one.called not in still:
            yield (
                f"Axis {one.called}: the {one.scores.groups} groups of these cuts show how far "
                f"another {one.scores.grouped_by} differs, and every interval includes that."
            )


def _differs(calibration: Calibration) -> bool:
    errors = calibration.errors
    return errors.gain_share > 0.0 or (errors.group is not None and bool(errors.group.any()))


def _known(one: Calibration) -> str:
    percent = 100.0 * NORMAL_95 * one.errors.gain_share
    said = f"Axis {one.called}: the gain is known to ± {percent:.2g} % (95 %) from day"
    published = DAY_SHARE[one.axis]
    source = "what was seen from cut to cut here"
    if published:
        source = (
            f"{100.0 * published:.2g} % (one standard deviation) of a published lathe, or what "
            "was seen here if that is more"
        )
    return f"{said} to day, and every interval includes that. It comes from {source}."
