"""Renders a card as a page that loads nothing from outside."""

import numpy as np

from autodb import __version__
from autodb.fitting.gaussian import NORMAL_95
from autodb.reports import amounts, figures
from autodb.reports.card import plots
from autodb.reports.card.axis_figures import AxisCard, OneCut
from autodb.reports.card.budget import budget_of_axis
from autodb.reports.card.conditions import FEWEST
from autodb.reports.card.machine_card import CalibrationCard, not_sensed, when_again
from autodb.sensing.ranges.calibration import OFFER_R_SQUARED, Calibration
from autodb.sensing.ranges.choosing import FOLDS
from autodb.sensing.ranges.outliers import numbers, outlier_sentences
from autodb.sensing.ranges.repeats import LEVEL
from autodb.sensing.ranges.validity import ANY
from autodb.wording import listed, localized, phrase, phrase_many
from autodb.wording.kept import said_again


def render_card(card: CalibrationCard) -> str:
    """Return the card as a page that loads nothing from outside."""
    return figures.whole_page(
        "card.html.j2",
        title=phrase("{machine}: calibration card", machine=card.title),
        card=card,
        version=__version__,
        offered_above=OFFER_R_SQUARED,
        not_sensed=not_sensed(card),
        when_again=when_again(card.cards),
        shown=[_shown(card, number) for number in range(len(card.cards))],
    )


def _shown(card: CalibrationCard, number: int) -> dict[str, object]:
    """Return what the template shows of one axis."""
    axis = card.cards[number]
    c, s = axis.calibration, axis.calibration.scores
    id_ = f"axis-{c.axis}" if c.holds == ANY else f"axis-{c.axis}-{number + 1}"
    residuals, still = plots.residuals(axis, id_=id_)
    return {
        "axis": axis,
        "id": id_,
        "name": _axis_words(c.axis),
        "holds": listed(map(said_again, c.holds.stated)),
        "sensed_as": plots.sensed_as(axis),
        "calibration": c,
        "version": _version(card, number),
        "equation": c.form.equation(c.coefficients, c.unit, c.current_unit),
        "r_squared": _plain(s.r_squared),
        "r_squared_interval": phrase(
            "{low} to {high}", low=_plain(s.r_squared_low), high=_plain(s.r_squared_high)
        ),
        "rmse": amounts.quantity(s.rmse, c.unit),
        "folds": min(FOLDS, s.groups),
        "one_cut": _one_cut(axis.middle, c.unit),
        "percent": _percent(axis.middle),
        "domain": _domain(c),
        "rivals": _rivals(c),
        "range": amounts.span(c.current_low, c.current_high, c.current_unit),
        "trueness": _trueness(axis),
        "parts": _parts(axis.middle, c.unit),
        "budget": budget_of_axis(axis),
        "scatter_plot": plots.reference_over_estimate(axis, id_=id_),
        "residual_plots": residuals,
        "still": still,
        "trials": _trials(axis),
        "excluded": _excluded(axis),
        "outliers": outlier_sentences(c.outliers),
        "more_repeats": axis.repeated - len(axis.repeats),
        "fewest": FEWEST,
        "level": LEVEL,
    }


def _axis_words(axis: str) -> str:
    return phrase("Spindle") if axis == "spindle" else phrase("{axis} axis", axis=axis.upper())


def _version(card: CalibrationCard, number: int) -> str:
    if not card.versions:
        return phrase("not stored")
    return phrase("version {number}", number=card.versions[number])


def _domain(calibration: Calibration) -> str:
    """Return the range that a calibration was made over; empty where it is not known."""
    known = calibration.domain
    if known is None:
        return ""
    return listed(map(said_again, known.each(calibration.unit, calibration.current_unit)))


def _plain(score: float) -> str:
    return localized(f"{score:.3f}".replace("-", "−"))


def _rivals(calibration: Calibration) -> str:
    """Return what the form in use is compared with outside the range of its cuts."""
    near = () if calibration.domain is None else calibration.domain.rivals
    names = [
        phrase(
            "{form} (weight {share})",
            form=said_again(one.form.label),
            share=f"{100.0 * one.weight:.0f}\u00a0%",
        )
        for one in near
    ]
    return listed([*names, phrase("itself, held at the end of the range")], phrase(" and "))


def _one_cut(cut: OneCut, unit: str) -> str:
    return amounts.plus_minus(cut.value, cut.half, unit)


def _percent(cut: OneCut) -> str:
    if cut.value == 0.0:
        return ""
    percent = 100.0 * cut.half / abs(cut.value)
    return f"± {localized(f'{percent:.{0 if percent >= 10.0 else 1}f}')}\u00a0%"


def _trueness(axis: AxisCard) -> list[tuple[str, str, str]]:
    """Return name, value ± standard error, and the ideal."""
    t, unit = axis.trueness, axis.calibration.unit
    if t is None:
        return []
    return [
        (phrase("Slope"), amounts.plus_minus(t.slope, t.slope_se, "1"), "1"),
        (phrase("Intercept"), amounts.plus_minus(t.intercept, t.intercept_se, unit), "0"),
    ]


def _parts(cut: OneCut, unit: str) -> list[tuple[str, str, float]]:
    """Return each part of one cut's error: name, 95 % half width, percent of the variance."""
    whole = cut.own**2 + cut.shared**2
    rows = (
        (phrase("Its own"), cut.own, phrase("none")),
        (phrase("Coefficients"), cut.coefficients, phrase("none")),
        (phrase("Gain, day to day"), cut.gain, phrase("none seen")),
        (phrase("Tool, material or day"), cut.group, phrase("none seen")),
        (phrase("Reference forces"), cut.references, phrase("none stated")),
    )
    return [
        (name, amounts.quantity(NORMAL_95 * sd, unit) if sd else none, 100.0 * sd**2 / whole)
        for name, sd, none in rows
    ]


def _trials(axis: AxisCard) -> list[tuple[str, str, bool]]:
    """Return each form tried: name, error on groups left out, whether it was taken."""
    c = axis.calibration
    return [
        (
            said_again(name),
            amounts.quantity(error, c.unit)
            if np.isfinite(error)
            else phrase("not determined by these cuts"),
            name == c.form.label,
        )
        for name, error in c.trials.items()
    ]


def _excluded(axis: AxisCard) -> str:
    c = axis.calibration
    if not c.transients:
        return ""
    scores = c.scores_with_transients
    said = phrase_many(
        "{count} transient row excluded (cut {cuts}): the current jumps, the force does not. With "
        "it: RMSE {rmse}, R² {r_squared}",
        "{count} transient rows excluded (cut {cuts}): the current jumps, the force does not. With "
        "them: RMSE {rmse}, R² {r_squared}",
        len(c.transients),
        cuts=numbers(c.transients),
        rmse=amounts.quantity(scores.rmse, c.unit),
        r_squared=localized(f"{scores.r_squared:.3f}"),
    )
    return f"{said}."
