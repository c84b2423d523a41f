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
from autodb.wording import listed, localized, phrase
from autodb.wording.kept import said_again


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
    found: list[tuple[str, str]] = [
        (_in_any(f"force.{component}"), phrase("there is no axis {axis}", axis=axis))
        for axis, component in COMPONENT_OF_AXIS.items()
        if axis not in card.axes
    ]
    without = phrase("an axis without a calibration, in any cut")
    found += [(without, sentence) for sentence in card.left_out]
    for one in (each.calibration for each in card.cards):
        force = f"force.{one.component}"
        if not one.offered:
            what = _in_any(force) if one.holds == ANY else _with(one, force)
            verdict = said_again(one.verdict)
            found.append(
                (what, phrase("axis {axis} is {verdict}", axis=one.called_words, verdict=verdict))
            )
            continue
        if one.holds != ANY:
            found.append(
                (
                    phrase(
                        "{force}, in other cuts than those with {conditions}",
                        force=force,
                        conditions=listed(map(said_again, one.holds.stated)),
                    ),
                    phrase("this calibration was not made on them"),
                )
            )
        found += [
            (phrase("{force}, where the operation is '{operation}'",
                    force=force, operation=operation),
             phrase("axis {axis} stands still: a passive force shows in no current", axis=axis))
            for operation, axis in PASSIVE_AXIS.items()
            if axis == one.axis
        ]  # fmt: skip
    return found


def _in_any(force: str) -> str:
    return phrase("{force}, in any cut", force=force)


def _with(one: Calibration, force: str) -> str:
    return phrase(
        "{force}, in any cut with {conditions}",
        force=force,
        conditions=listed(map(said_again, one.holds.stated)),
    )


def when_again(cards: Sequence[AxisCard]) -> list[str]:
    """Return what is known of when a calibration ends; no period is."""
    return [
        phrase(
            "After a change of drive or its parameters, motor, current sensor, screw, bearings or "
            "way oil: the equations describe the axes as they were."
        ),
        phrase(
            "When a standard cut, made once more, has moved by more than the interval that repeats "
            "give it."
        ),
        phrase(
            "When currents leave the range that an axis was calibrated over: further out the "
            "equation was not tested."
        ),
        *_wander([card.calibration for card in cards if card.calibration.offered]),
        phrase(
            "For how many weeks a calibration holds is not known: these cuts say nothing of it."
        ),
    ]


def _wander(calibrations: Sequence[Calibration]) -> Iterator[str]:
    """Yield by how much axes are known to differ from day to day, or from group to group."""
    still = [one for one in calibrations if not _differs(one)]
    if still:
        said = phrase(
            "over these cuts the gain drifted no more than by chance. These cuts do not show how "
            "far it differs on another day; the intervals include nothing for it."
        )
        names = listed([one.called_words for one in still], phrase(" and "))
        yield (
            phrase("Axis {axis}: {said}", axis=names, said=said)
            if len(still) == 1
            else phrase("Axes {axes}: {said}", axes=names, said=said)
        )
    for one in calibrations:
        if one.errors.gain_share:
            yield _known(one)
        elif one.called not in [each.called for each in still]:
            yield phrase(
                "Axis {axis}: the {count} groups of these cuts show how far another of them "
                "({group}) differs, and every interval includes that.",
                axis=one.called_words,
                count=one.scores.groups,
                group=said_again(one.scores.grouped_by),
            )


def _differs(calibration: Calibration) -> bool:
    errors = calibration.errors
    return errors.gain_share > 0.0 or (errors.group is not None and bool(errors.group.any()))


def _known(one: Calibration) -> str:
    percent = 100.0 * NORMAL_95 * one.errors.gain_share
    published = DAY_SHARE[one.axis]
    source = phrase("what was seen from cut to cut here")
    if published:
        source = phrase(
            "{percent} % (one standard deviation) of a published lathe, or what was seen here if "
            "that is more",
            percent=localized(f"{100.0 * published:.2g}"),
        )
    return phrase(
        "Axis {axis}: the gain is known to ± {percent} % (95 %) from day to day, and every "
        "interval includes that. It comes from {source}.",
        axis=one.called_words,
        percent=localized(f"{percent:.2g}"),
        source=source,
    )
