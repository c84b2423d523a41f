"""Calibrate an axis current against known forces, and sense force with it (P1 sections 8-9).

Force for the feed axes, torque T for the spindle, F_y = T/r_e, each in one of the forms of
``sensing.ranges.forms``. I is the rise of the current range over air cutting where both ranges are
known.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from autodb.errors import UnusableInput
from autodb.fitting.scores import bootstrap_r_squared, r_squared
from autodb.records.tables import CutTable
from autodb.sensing.dynamometer import ForceError
from autodb.sensing.ranges.choosing import (
    CONDITION,
    FOLDS,
    MIN_GROUPS,
    TriedForm,
    assessed,
    best,
    close,
    groups_left_out,
    materials_of,
    several,
    try_forms,
)
from autodb.sensing.ranges.domain import OF_FEED, OF_SPINDLE, Domain, domain_of, near_forms
from autodb.sensing.ranges.error_kinds import DAY_SHARE, ErrorKinds, FittedCuts, error_kinds_of
from autodb.sensing.ranges.folding import Fold, fold_of
from autodb.sensing.ranges.forms import (
    BOTH_WAYS_FORMS,
    FEED_FORMS,
    FEED_SETS,
    LINE,
    MAGNETISED,
    SPINDLE_FORMS,
    SPINDLE_SETS,
    TANGENTIAL_FORMS,
    CurrentForm,
    FittedForm,
    of_one_way,
)
from autodb.sensing.ranges.forms.noisy import by_current
from autodb.sensing.ranges.outliers import Outlier, outliers, transients
from autodb.sensing.ranges.points import COMPONENT_OF_AXIS, FEED_AXES, Points, calibration_points
from autodb.sensing.ranges.validity import ANY, Holds
from autodb.wording import listed, localized, phrase, shop_amount, significant, stored_msgid
from autodb.wording.kept import said_again

Array = NDArray[np.float64]

OFFER_R_SQUARED = 0.3
"""A calibration is offered when the lower 95 % bound of R² on groups left out is above this."""
ABOVE = stored_msgid(
    "R² {r2} (95 % {low} to {high}) on held-out groups ({group}), lower bound above {least}"
)
NOT_ABOVE = stored_msgid(
    "R² {r2} (95 % {low} to {high}) on held-out groups ({group}), lower bound not above {least}"
)
USABLE, NOT_USABLE = stored_msgid("usable: {verdict}"), stored_msgid("not usable: {verdict}")


@dataclass(frozen=True)
class Scores:
    """Errors on groups left out: RMSE in the target's unit, R² with its 95 % interval."""

    n: int
    rmse: float
    r_squared: float
    r_squared_low: float
    r_squared_high: float
    groups: int
    grouped_by: str


@dataclass(frozen=True)
class Calibration:
    """A fitted form: ``coefficients`` (p,), their covariance (p, p), and the kinds of error.

    ``trials``: root mean square error on groups left out of each form tried (NaN: not held).
    ``close``: labels of forms that would do as well; known where it is fitted, and not kept.
    ``holds``: of which cuts it senses the force; ``domain``: what its cuts were; None: a
    calibration of before, which did not keep it. ``reference_errors``: what the dynamometer of its
    cuts moves all their forces by; none: they are those of a protocol.
    """

    form: CurrentForm
    axis: str
    component: str
    channel: str
    current_unit: str
    unit: str
    coefficients: Array
    covariance: Array
    errors: ErrorKinds
    scores: Scores
    scores_with_transients: Scores
    transients: tuple[float, ...]
    outliers: tuple[Outlier, ...]
    trials: dict[str, float]
    current_low: float
    current_high: float
    close: tuple[str, ...] = ()
    holds: Holds = ANY
    domain: Domain | None = None
    reference_errors: tuple[ForceError, ...] = ()

    @property
    def law(self) -> FittedForm:
        """The form with its coefficients."""
        return FittedForm(self.coefficients, self.covariance, self.form)

    @property
    def called(self) -> str:
        """The axis, with what the calibration holds for where it does not hold for any cut."""
        return f"{self.axis} ({self.holds.words()})" if self.holds != ANY else self.axis

    @property
    def shared_covariance(self) -> Array:
        """Covariance of coefficients and offset that is common to all that is sensed with them.

        (p + 1, p + 1), or (p, p) where no offset was fitted; then one more, of variance 1, of the
        form's choice beyond the domain, where that is known.
        """
        shared = self.errors.shared(self.form.scaling(self.coefficients))
        p = len(self.coefficients)
        shared[:p, :p] += self.covariance
        if self.domain is None:
            return shared
        wider = np.pad(shared, (0, 1))
        wider[-1, -1] = 1.0
        return wider

    @property
    def called_words(self) -> str:
        """What it is called, for the reader."""
        if self.holds == ANY:
            return self.axis
        return f"{self.axis} ({listed(map(said_again, self.holds.stated))})"

    def trials_words(self) -> str:
        """Return the errors of the forms tried, the one taken first."""
        taken, (scale, unit) = self.form.label, shop_amount(1.0, self.unit)
        held = {name: scale * error for name, error in self.trials.items() if np.isfinite(error)}
        words = {name: said_again(name) for name in (*self.trials, taken)}
        rest = [f"{localized(significant(held[name]))} {words[name]}" for name in held]
        first: str = words[taken]
        if taken in held:
            first = f"{localized(significant(held[taken]))} {unit} {words[taken]}"
            del rest[list(held).index(taken)]
        others = [
            phrase("not determined: {form}", form=words[one]) for one in self.trials
            if one not in held
        ]  # fmt: skip
        return listed([phrase("{form} (taken)", form=first), *rest, *others])

    @property
    def offered(self) -> bool:
        """Whether the axis senses force well enough to be used."""
        return self.scores.r_squared_low > OFFER_R_SQUARED

    @property
    def verdict(self) -> str:
        """One sentence: offered or refused, with the figure that decided."""
        s = self.scores
        whole, verdict = (USABLE, ABOVE) if self.offered else (NOT_USABLE, NOT_ABOVE)
        said = verdict.format(
            r2=f"{s.r_squared:.3f}", low=f"{s.r_squared_low:.3f}", high=f"{s.r_squared_high:.3f}",
            group=s.grouped_by, least=OFFER_R_SQUARED,
        )  # fmt: skip
        return whole.format(verdict=said)


def calibrate(
    table: CutTable,
    axis: str,
    *,
    force_N: Array | None = None,
    reference_share: float = 0.0,
    other_way: NDArray[np.bool_] | None = None,
) -> Calibration:
    """Fit one axis' form on the cuts in which it moves, scored on groups left out.

    ``force_N`` as in ``calibration_points``. ``reference_share``: relative standard deviation that
    all references share. ``other_way`` (n,): cuts of a feed axis' other direction, which tell of
    the gain too.

    Raises UnusableInput when the current, the force or enough independent groups are missing.
    """
    points = calibration_points(table, axis, force_N=force_N, other_way=other_way)
    one_sided = axis in FEED_AXES and other_way is None
    fold = fold_of(points.sensed, points.target) if one_sided else None
    if fold is not None:
        points = _unfolded(points, fold, axis=axis, path=table.path)
    sudden = transients(points.sensed.current, points.target, points.groups)
    sound = points.at(~sudden)
    forms = _forms(table, axis, points.unit) if other_way is None else BOTH_WAYS_FORMS
    trials = try_forms(forms, sound.sensed, sound.target, sound.groups, folds=FOLDS)
    form = best(trials, sound.groups).form
    law = form.fit(sound.sensed, sound.target)
    scores = _scores(assessed(trials, sound.groups), sound)
    cuts = _fitted_cuts(law, sound)
    errors, covariance = error_kinds_of(
        cuts, rmse=scores.rmse, day_share=DAY_SHARE[axis], reference_share=reference_share
    )
    own = of_one_way(replace(law, covariance=covariance))
    currents = sound.sensed.at(sound.sensed.one_way).current
    return Calibration(
        form=own.form,
        axis=axis,
        component=COMPONENT_OF_AXIS[axis],
        channel=points.channel,
        current_unit=table.unit(points.channel.split(" − ", maxsplit=1)[0]),
        unit=points.unit,
        coefficients=own.coefficients,
        covariance=own.covariance,
        errors=errors,
        scores=scores,
        scores_with_transients=_scores(_of_all(form, points), points) if sudden.any() else scores,
        transients=tuple(points.cut[sudden].tolist()),
        outliers=outliers(law, cuts.slopes, cuts.error, np.sort(sound.cut)),
        trials={own.form.label if t.form is form else t.form.label: t.rmse for t in trials},
        close=tuple(one.label for one in close(trials, sound.groups)),
        current_low=float(currents.min()),
        current_high=float(currents.max()),
        domain=_domain(axis, own, form, trials, sound, fold),
    )


def _domain(  # noqa: PLR0917 - what a calibration was made with
    axis: str,
    own: FittedForm,
    form: CurrentForm,
    trials: Sequence[TriedForm],
    sound: Points,
    fold: Fold | None,
) -> Domain:
    """Return what a calibration's cuts were, and which laws were nearly as good.

    Of a slide the load beside a magnetising current is a line again away from no load: to count
    both would halve what the others say of what lies beyond.
    """
    slides, one_way = axis in FEED_AXES, sound.sensed.one_way
    apart = [t for t in trials if not (slides and form is LINE and t.form is MAGNETISED)]
    return domain_of(
        own,
        sound.sensed.at(one_way),
        sound.target[one_way],
        near_forms(apart, form, sound.sensed, sound.target, sound.groups),
        conditions=OF_FEED if slides else OF_SPINDLE,
        fold=fold,
    )


def _unfolded(points: Points, fold: Fold, *, axis: str, path: Path) -> Points:
    """Return the cuts whose range no other force shows; raises UnusableInput for too few."""
    clear = points.at(np.abs(points.target) > abs(fold.force))
    count = len(np.unique(clear.groups))
    if count < MIN_GROUPS:
        raise UnusableInput(
            phrase(
                "{file}: {axis}: its range folds where the force takes up the weight: up to "
                "{force} {unit} two forces show one range, and {n} independent groups of cuts "
                "lie above; use {min_groups} or more with higher forces, or record the drive's "
                "signed current as {axis}.current",
                file=path,
                axis=axis,
                force=localized(f"{abs(fold.force):.4g}"),
                unit=points.unit,
                n=count,
                min_groups=MIN_GROUPS,
            )
        )
    return clear


def _fitted_cuts(law: FittedForm, sound: Points) -> FittedCuts:
    """Return what a law says of the cuts that it was fitted to, in their order."""
    order = np.argsort(sound.cut)
    sensed, target = sound.sensed.at(order), sound.target[order]
    estimate = law.form.value(law.coefficients, sensed)
    return FittedCuts(
        estimate,
        target - estimate,
        law.form.slopes(law.coefficients, sensed),
        law.covariance,
        None if sound.grouped_by == CONDITION else sound.groups[order],
        sensed.current_sd,
        by_current(law.form, law.coefficients, sensed)[0],
    )


def _of_all(form: CurrentForm, points: Points) -> Array:
    """Return the errors (m,) on groups left out of one form, transients among them."""
    return groups_left_out(form, points.sensed, points.target, points.groups, folds=FOLDS)


def _forms(table: CutTable, axis: str, unit: str) -> tuple[CurrentForm, ...]:
    """Return the forms to try: only rules that the cuts' own conditions cannot carry alone.

    A system that sees feed and depth can learn the force of one material by heart and needs no
    current then; it is tried where several materials were cut.
    """
    learned = several(materials_of(table))
    if axis in FEED_AXES:
        return (*FEED_FORMS, *(FEED_SETS if learned else ()))
    if unit != "N·m":
        return TANGENTIAL_FORMS
    return (*SPINDLE_FORMS, *(SPINDLE_SETS if learned else ()))


def _scores(errors: Array, points: Points) -> Scores:
    y, groups = points.target, points.groups
    low, high = bootstrap_r_squared(errors, y, groups)
    return Scores(
        n=len(y),
        rmse=float(np.sqrt(np.mean(errors**2))),
        r_squared=r_squared(errors, y),
        r_squared_low=low,
        r_squared_high=high,
        groups=len(np.unique(groups)),
        grouped_by=points.grouped_by,
    )
