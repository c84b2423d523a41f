"""How good a calibration of one axis is, in figures: all from its cuts, none from the fit alone.

Estimates and errors are those of cuts left out, of the form taken: each group of cuts is estimated
by coefficients fitted without it, in the folds by which the form was chosen.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from autodb import standard
from autodb.fitting.anfis.sentences import Rules, rule_sentences
from autodb.fitting.gaussian import NORMAL_95
from autodb.fitting.linear import Undetermined
from autodb.fitting.scores import straight_line
from autodb.records.tables import CutTable
from autodb.reports.card import conditions
from autodb.sensing.ranges.calibration import Calibration
from autodb.sensing.ranges.choosing import FOLDS, groups_left_out
from autodb.sensing.ranges.error_kinds import ErrorKinds
from autodb.sensing.ranges.forms import Fuzzy, MeasuredCuts
from autodb.sensing.ranges.outliers import transients
from autodb.sensing.ranges.points import Points, calibration_points
from autodb.sensing.ranges.sensed_force import of_current
from autodb.wording import phrase

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Trueness:
    """The line reference = intercept + slope · estimate, with standard errors; ideal are 0 and 1.

    The errors are delete-a-group jackknife ones (Efron and Tibshirani 1993, An introduction to the
    bootstrap, chapter 11): rows of one group share theirs. The intercept is in the target's unit.
    """

    slope: float
    slope_se: float
    intercept: float
    intercept_se: float


@dataclass(frozen=True)
class OneCut:
    """What is sensed of one cut at a current, and the standard deviations of its errors.

    ``own`` is that cut's alone; coefficients, gain, references and what a new group has of its
    own are shared by all cuts.
    """

    current: float
    value: float
    own: float
    coefficients: float
    gain: float
    references: float
    group: float

    @property
    def shared(self) -> float:
        """Standard deviation of what all cuts share."""
        return float(np.linalg.norm([self.coefficients, self.gain, self.references, self.group]))

    @property
    def half(self) -> float:
        """Half width of the 95 % interval."""
        return NORMAL_95 * float(np.hypot(self.own, self.shared))


@dataclass(frozen=True)
class AxisCard:
    """One axis: rows (m,) in the order of the table, ``sudden`` (m,) those excluded.

    ``cut`` are their numbers, ``order`` their places in the table, ``estimate`` that of cuts left
    out (of transients that of the fit). ``repeats``: conditions and sentences; ``repeated``: how
    many conditions there are that could be shown. ``moved``: from the first cut to the last;
    ``what_moved``: what it was that did.
    """

    calibration: Calibration
    cut: Array
    order: Array
    sensed: MeasuredCuts
    target: Array
    estimate: Array
    sudden: NDArray[np.bool_]
    trueness: Trueness | None
    middle: OneCut
    rules: tuple[str, ...]
    repeats: tuple[tuple[str, tuple[str, ...]], ...]
    repeated: int
    moved: tuple[str, ...]
    what_moved: tuple[str, ...]

    @property
    def left_out_rmse(self) -> float:
        """Root mean square error of cuts left out, in the target's unit."""
        sound = ~self.sudden
        return float(np.sqrt(np.mean((self.target[sound] - self.estimate[sound]) ** 2)))


def axis_card(
    calibration: Calibration,
    table: CutTable,
    *,
    force_N: Array | None = None,
    protocol: standard.CutProtocol | None = None,
    what_moved: tuple[str, ...] = (),
) -> AxisCard:
    """Return the card of an axis from the table that it was calibrated on.

    ``force_N`` (n,) as ``calibration.calibrate`` took it; ``what_moved``: sentences on what it was.
    """
    points, row = by_row(table, calibration.axis, force_N)
    sudden = transients(points.sensed.current, points.target, points.groups)
    sound, rest = points.at(~sudden), points.at(sudden)
    errors = groups_left_out(
        calibration.form, sound.sensed, sound.target, sound.groups, folds=min(FOLDS, len(sound.cut))
    )
    estimate = np.empty_like(points.target)
    estimate[~sudden] = sound.target - errors
    estimate[sudden] = calibration.form.value(calibration.coefficients, rest.sensed)
    said = conditions_of(calibration, table, protocol, row[~sudden])
    run = cuts_of_run(sudden)
    return AxisCard(
        calibration=calibration,
        cut=table.cut[row],
        order=row.astype(np.float64) + 1.0,
        sensed=points.sensed,
        target=points.target,
        estimate=estimate,
        sudden=sudden,
        trueness=trueness(sound.target, estimate[~sudden], sound.groups),
        middle=at_middle(calibration, sound.sensed),
        rules=rules(calibration),
        repeats=conditions.condition_scatter(
            said, sound.target, estimate[~sudden], calibration.unit
        ),
        repeated=conditions.count_repeated(said),
        moved=conditions.movement(
            conditions_of(calibration, table, protocol, row[run]),
            _signals(calibration, points.at(run), protocol, air_of(calibration, table, row[run])),
        ),
        what_moved=what_moved,
    )


def by_row(table: CutTable, axis: str, force_N: Array | None) -> tuple[Points, NDArray[np.intp]]:
    """Return the points, and the row of the table of each: numbers of several files repeat."""
    numbered = replace(table, channels={**table.channels, "cut": np.arange(float(len(table)))})
    points = calibration_points(numbered, axis, force_N=force_N)
    return points, points.cut.astype(np.intp)


def cuts_of_run(sudden: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return which cuts (m,) show what moved: all but transients between the first and the last.

    Where the last cut's current leaves its neighbours' it may have moved.
    """
    ends = np.zeros_like(sudden)
    ends[[0, -1]] = True
    return np.asarray(~sudden | ends)


def conditions_of(
    calibration: Calibration,
    table: CutTable,
    protocol: standard.CutProtocol | None,
    rows: NDArray[np.intp],
) -> list[str]:
    """Return the conditions (m,) of an axis' cuts in some rows; a torque's hold the diameter."""
    alike = conditions.condition_words(table, protocol, with_diameter=calibration.unit == "N·m")
    return [alike[row] for row in rows]


def air_of(calibration: Calibration, table: CutTable, rows: NDArray[np.intp]) -> Array | None:
    """Return the current in air (m,) of some rows; None where the calibration goes without it."""
    name = air_channel(calibration)
    return None if name is None else table[name][rows]


def air_channel(calibration: Calibration) -> str | None:
    """Return the channel of the current in air that a calibration takes off, if it does."""
    _, taken, air = calibration.channel.partition(" − ")
    return air if taken else None


def _signals(
    calibration: Calibration,
    sound: Points,
    protocol: standard.CutProtocol | None,
    air: Array | None,
) -> dict[str, tuple[Array, str]]:
    """Return what may have moved: current, that in air, and a force measured in each cut."""
    found = {calibration.channel: (sound.sensed.current, calibration.current_unit)}
    if air is not None:
        found[air_channel(calibration) or ""] = (air, calibration.current_unit)
    if protocol is None:
        found[phrase("the reference of {axis}", axis=calibration.axis)] = (
            sound.target,
            calibration.unit,
        )
    return found


def trueness(target: Array, estimate: Array, groups: NDArray[np.generic]) -> Trueness | None:
    """Return the line of reference (n,) on estimate (n,); None where estimates hold no line."""
    names = np.unique(groups)
    try:
        whole = straight_line(estimate, target).coefficients
        without = np.array(
            [
                straight_line(estimate[groups != name], target[groups != name]).coefficients
                for name in names
            ]
        )
    except Undetermined:
        return None
    g = len(names)
    errors = np.sqrt((g - 1) / g * np.sum((without - without.mean(axis=0)) ** 2, axis=0))
    return Trueness(float(whole[1]), float(errors[1]), float(whole[0]), float(errors[0]))


def at_middle(calibration: Calibration, sensed: MeasuredCuts) -> OneCut:
    """Return what one cut at the middle of the current's range gives, all else at its median."""
    form, coefficients = calibration.form, calibration.coefficients
    current = 0.5 * (calibration.current_low + calibration.current_high)
    middle = _medians(sensed, current)
    slopes = form.slopes(coefficients, middle)[0]
    whole = float(slopes @ form.scaling(coefficients))
    by_share = abs(whole)
    kinds = calibration.errors
    return OneCut(
        current=current,
        value=float(form.value(coefficients, middle)[0]),
        own=float(
            np.linalg.norm(
                [kinds.cut_sd, form.beyond(middle)[0], of_current(calibration, middle)[0]]
            )
        ),
        coefficients=float(np.sqrt(slopes @ calibration.covariance @ slopes)),
        gain=by_share * kinds.gain_share,
        references=by_share * _of_references(calibration),
        group=_of_group(kinds, whole),
    )


def _of_references(calibration: Calibration) -> float:
    """Return the share that references err by together: a protocol's, or a dynamometer's."""
    shares = [one.share for one in calibration.reference_errors]
    return float(np.linalg.norm([calibration.errors.reference_share, *shares]))


def _of_group(kinds: ErrorKinds, whole: float) -> float:
    """Return the standard deviation of a new group's own part where ``whole`` is sensed."""
    if kinds.group is None:
        return 0.0
    moves = np.array([1.0, whole])
    return float(np.sqrt(moves @ kinds.group @ moves))


def _medians(sensed: MeasuredCuts, current: float) -> MeasuredCuts:
    known = (sensed.speed_rpm, sensed.feed_mm, sensed.depth_mm, sensed.temperature_C)
    speed, feed, depth, temperature = (np.array([np.median(one)]) for one in known)
    air = None if sensed.air is None else np.array([np.median(sensed.air)])
    return MeasuredCuts(
        np.array([current]), feed * speed / 60.0, speed, feed, depth, temperature, air=air
    )


def rules(calibration: Calibration) -> tuple[str, ...]:
    """Return the rules of a fuzzy system in words; a law has none."""
    form = calibration.form
    if not isinstance(form, Fuzzy) or form.learned is None:
        return ()
    names = [one.name for one in form.inputs]
    units = [one.unit for one in form.inputs]
    fitted = Rules(
        form.learned.premises,
        form.learned.scaling,
        calibration.coefficients.reshape(-1, len(names) + 1),
    )
    what = phrase("torque") if calibration.unit == "N·m" else phrase("force")
    return rule_sentences(fitted, (*names, what), (*units, calibration.unit))
