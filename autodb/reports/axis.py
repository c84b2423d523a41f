"""The page of an identified axis: three maps of its effort, its terms, and what is not known."""

import numpy as np
import plotly.graph_objects as go
from markupsafe import Markup
from numpy.typing import NDArray

from autodb import __version__
from autodb.files.channels import ROTARY_AXES
from autodb.fitting.gaussian import NORMAL_95
from autodb.records.tables import Recording
from autodb.reports import amounts, figures
from autodb.sensing.drives.field import EffortField, field
from autodb.sensing.drives.fit.axis_model import Identified, IdentifiedTerm, amplitudes, readable
from autodb.sensing.drives.fit.drive_errors import BANDWIDTHS_HZ, DriveErrors
from autodb.sensing.drives.fit.thermal import thermal_state
from autodb.terms.vocabulary import term_called
from autodb.wording import localized, msgid, phrase

Array = NDArray[np.float64]

MAP_PX = 360
TOLD_HZ = (1.0, 10.0)
"""Bandwidths at which the error of each state is stated."""
STATES = (
    msgid("in steady motion"), msgid("while the speed changes"), msgid("shortly after a reversal"),
)  # fmt: skip


def render_axis(model: Identified, moves: Recording) -> str:
    """Return the page of an axis that was identified from ``moves``: one file, no network."""
    found = field(moves, model.axis, model.protocol, model.terms, model.off_law)
    return figures.whole_page(
        "axis.html.j2",
        title=phrase("{file}: axis {axis}", file=moves.path.name, axis=model.axis),
        name=moves.path.name,
        axis=model.axis,
        channel=model.channel,
        version=__version__,
        relative=_percent(model.relative_error),
        held_out=_percent(model.held_out_error),
        plain=_percent(model.plain.relative_error),
        field_error=_percent(found.error_share),
        maps=field_plots(found, model.axis, model.unit),
        terms=[term_row(t) for t in (*readable(model.fitted), *amplitudes(model))],
        not_excited=model.not_excited,
        doubts=model.doubts,
        errors=_errors(model.errors, model.unit),
        bandwidths=[amounts.quantity(hz, "Hz") for hz in TOLD_HZ],
        warmth=_warmth(model),
        thermal=_thermal(model, moves),
        protocol=str(model.protocol),
        timing=str(moves.timing),
    )


def _percent(share: float) -> str:
    if np.isnan(share):
        return phrase("not known")
    return f"{localized(f'{100.0 * share:.2f}')}\u00a0%"


def field_plots(found: EffortField, axis: str, unit: str) -> list[tuple[str, Markup]]:
    """Return the maps of an axis' field in its unit, as words and plot each."""
    speed_unit = "deg/s" if axis in ROTARY_AXES else "mm/s"
    both = np.concatenate([found.measured.ravel(), found.modelled.ravel()])
    largest = float(np.nanmax(np.abs(both))) if np.isfinite(both).any() else 1.0
    left = float(np.nanmax(np.abs(found.left))) if np.isfinite(found.left).any() else 1.0
    return [
        (name, _map(found, (values, top), (key, name, unit), speed_unit))
        for key, name, values, top in (
            ("measured", phrase("Measured"), found.measured, largest),
            ("modelled", phrase("Modelled"), found.modelled, largest),
            ("residual", phrase("Residual"), found.left, left),
        )
    ]


def _map(
    found: EffortField, shown: tuple[Array, float], called: tuple[str, str, str], speed_unit: str
) -> Markup:
    """Return the map of values up to a largest, called by a page's id, a name and their unit."""
    (values, top), (key, name, unit) = shown, called
    place_unit, title = speed_unit.removesuffix("/s"), figures.bracketed(name, unit)
    made = figures.figure([title], x_title=figures.bracketed(phrase("Place"), place_unit))
    scale, place, speed = (figures.plot_scale(one) for one in (unit, place_unit, speed_unit))
    tones = [
        [0.0, figures.colour("corrected")],
        [0.5, figures.colour("card")],
        [1.0, figures.colour("simulation")],
    ]
    made.add_trace(
        go.Heatmap(
            x=[localized(f"{place * at:.{0 if place == 1.0 else 1}f}") for at in found.places],
            y=[localized(f"{speed * v:+.3g}") for v in found.velocities],
            z=scale * values, zmin=-scale * top, zmax=scale * top, colorscale=tones,
            hoverongaps=False,
            colorbar={"thickness": 10, "outlinewidth": 0, "tickformat": ".3g"},
            hovertemplate=phrase(
                "place {x}, velocity {y}: {z}", x="%{x}", y="%{y}", z="%{z:.3g}"
            )
            + "<extra></extra>",
        )
    )  # fmt: skip
    made.update_xaxes(type="category")
    made.update_yaxes(
        type="category",
        title={"text": figures.bracketed(phrase("Velocity"), speed_unit), "font": {"size": 13}},
        automargin=True,
    )
    label = phrase("{quantity} over place and velocity", quantity=title)
    return figures.as_html(made, key, height_px=MAP_PX, label=label)


def term_row(term: IdentifiedTerm) -> tuple[str, str, str]:
    """Return name, value with its 95 % half width, and the sentence of a term's parameter."""
    sure = amounts.plus_minus(term.value, NORMAL_95 * (term.sd or 0.0), term.unit)
    return f"{term.key} {term.parameter}", sure, phrase(term_called(term.term, term.form).statement)


def _errors(errors: DriveErrors | None, unit: str) -> list[tuple[str, list[str]]]:
    """Return what the model leaves of blocks left out, by what the axis does."""
    if errors is None:
        return []
    at = [BANDWIDTHS_HZ.index(hz) for hz in TOLD_HZ]
    return [
        (phrase(name), [amounts.quantity(errors.rms[row][column], unit) for row in at])
        for column, name in enumerate(STATES)
    ]


def _warmth(model: Identified) -> str:
    """Say what is known of the axis' warming."""
    drop = next((t for t in model.fitted if (t.term, t.parameter) == ("warmup", "drop")), None)
    if drop is None:
        return phrase(
            "Warming is not in this model: friction is that of these moves, and falls by up to a "
            "fifth as an axis runs warm."
        )
    share = amounts.plus_minus(100.0 * drop.value, 100.0 * NORMAL_95 * (drop.sd or 0.0), "%")
    return phrase(
        "Warm after long running at {speed}, friction is {share} lower than cold.",
        speed=amounts.quantity(10_000.0, "mm/min"),
        share=share,
    )


def _thermal(model: Identified, moves: Recording) -> str:
    """Say how warm the axis was at the begin and the end of the moves; empty without `warmup`."""
    state = thermal_state(moves, model.axis, model.protocol, model.terms)
    if state is None:
        return ""
    begin, end, most = (f"{100.0 * x:.0f}\u00a0%" for x in (state.begin, state.end, state.most))
    return phrase(
        "Thermal state: at the begin of these moves, taken as cold, {begin} of that loss; {end} at "
        "the end; {most} when it was warmest.",
        begin=begin,
        end=end,
        most=most,
    )
