"""Fit the parts of an axis' model all at once, and say what the moves do not show.

Shape parameters come from variable projection first (``linearised``); here everything is
fitted together around that shape, with friction free to deviate from its law and with coloured
noise (``fitting.deviation``), and the shape is moved to where that fit wants it.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from autodb.errors import UnusableInput
from autodb.fitting.covariance import given_one
from autodb.fitting.deviation import Deviating, least_squares_with_deviation
from autodb.fitting.linear import least_squares, spanning
from autodb.fitting.rounds import NotSettled
from autodb.sensing.drives.fit.axis_model import (
    Identified,
    IdentifiedTerm,
    PlainFit,
    Posteriors,
    predicted_effort,
)
from autodb.sensing.drives.fit.beside_laws import beside_laws
from autodb.sensing.drives.fit.deviation import SPEED, follows
from autodb.sensing.drives.fit.discrepancy import FrictionDiscrepancy
from autodb.sensing.drives.fit.drive_errors import DriveErrors, drive_errors
from autodb.sensing.drives.fit.held_out import nearer_held_out
from autodb.sensing.drives.fit.hidden_coulomb import coulomb_is_hidden
from autodb.sensing.drives.fit.linearised import Linearised, linearised
from autodb.sensing.drives.fit.prior import combined_with_prior
from autodb.sensing.drives.fit.solved import Name, Solved, given_shape, identified_term
from autodb.sensing.drives.fit.unevenness import row_roots
from autodb.sensing.drives.moves.motion import SPINDLE
from autodb.sensing.drives.moves.prepared import Prepared
from autodb.terms.channel import ChannelPart
from autodb.terms.term import Contribution, TermParameter
from autodb.terms.vocabulary import term_called
from autodb.wording import localized, phrase

Array = NDArray[np.float64]

NOISE_ORDER = 10
EXCITED = 0.5
"""A term is excited while its sd times its column's rms is below EXCITED times the effort's rms:
else its 95 % interval holds the whole effort."""
TURNED = "is the sign of the effort reversed?"
SETTLED = 1e-6
"""Step of the shape, in standard errors, at which it is where the fit with deviation and coloured
noise wants it."""
ROUNDS = 40
"""Steps after which a shape that still moves is not determined. Chosen."""
BACK = 0.5
"""Share of a step by which the next comes back where it was too long. Chosen."""
STAYS = 0.1
"""Step, in standard errors, up to which such a shape is told, with its doubt."""


def fit_axis(
    rows: Prepared,
    parts: tuple[ChannelPart, ...],
    posteriors: Posteriors | None,
    *,
    published: Prepared,
    uneven: bool,
) -> Identified:
    """Return the model: values and covariance with friction free to deviate, scores of the law.

    Fitted on ``rows``, scored on the ``published`` ones of the same recording. ``uneven``: rows
    count by how much they scatter.

    ``posteriors``: what an earlier version knows; it is combined with what these moves say. A part
    whose shape neither shows is left out, and said.

    Raises UnusableInput when no term is excited.
    """
    dropped: list[Name] = []
    deviates = True
    while True:
        solved, moving = _settled(rows, parts, uneven=uneven, deviates=deviates)
        if deviates and not uneven and coulomb_is_hidden(solved, rows, published):
            deviates = False
            continue
        if posteriors is not None:
            solved = combined_with_prior(solved, posteriors, rows)
        vague = [solved.problem.names[i] for i in _vague(solved, rows)]
        shapeless = {part.key for part, p in vague if part.free and _told_by(part, p)}
        if posteriors is None:
            shapeless |= {key for key, step in moving.items() if step > STAYS}
        if not shapeless:
            break
        gone = [part for part in parts if part.key in shapeless]
        dropped += [(part, p) for part in gone for p in part.term.parameters]
        parts = tuple(part for part in parts if part not in gone)
    if len(vague) == len(solved.problem.names):
        raise UnusableInput(
            phrase("{file}: {axis} does not move enough", file=rows.path, axis=rows.axis)
        )
    return _described(rows, solved, dropped, published, moving, sweep=uneven)


def _told_by(part: ChannelPart, parameter: TermParameter) -> bool:
    """Say whether a part is nothing without a parameter: of its shape, or its one coefficient."""
    alone = isinstance(part.term, Contribution) and len(part.term.coefficients) == 1
    return parameter in part.term.shape or alone


def _settled(
    rows: Prepared, parts: tuple[ChannelPart, ...], *, uneven: bool, deviates: bool
) -> tuple[Solved, dict[str, float]]:
    """Fit around the shape that the fit itself wants, where a step of Gauss-Newton moves nothing.

    Return also the last step, in standard errors, of each part whose shape still moves: these rows
    show none at which the fit stays. A step is at most half of a value, and half as long from then
    on where it comes back as far as it went.
    """
    before, pace = np.zeros(0), np.ones(0)
    for _ in range(ROUNDS):
        solved, wanted = _solved(rows, parts, uneven=uneven, deviates=deviates)
        names = solved.problem.names
        shape = [i for i, (part, p) in enumerate(names) if p in part.term.shape]
        free = [names[i] for i in shape]
        here = np.array([part.shape[p.name] for part, p in free])
        lower, upper = (np.array([getattr(p, end) for _, p in free]) for end in ("lower", "upper"))
        half = 0.5 * np.abs(here)
        there = np.clip(np.clip(wanted[shape], here - half, here + half), lower, upper)
        step = (there - here) / np.sqrt(np.diag(solved.covariance))[shape]
        moving: dict[str, float] = {}
        for (part, _), far in zip(free, np.abs(step).tolist(), strict=True):
            if far > SETTLED:
                moving[part.key] = max(far, moving.get(part.key, 0.0))
        if not moving:
            break
        if len(before) == 0:
            before, pace = np.zeros(len(step)), np.ones(len(step))
        pace = np.where(step * before < -BACK * before**2, 0.5 * pace, pace)
        before = step
        parts = _shaped(parts, free, here + pace * (there - here))
    return solved, moving


def _shaped(parts: tuple[ChannelPart, ...], free: list[Name], at: Array) -> tuple[ChannelPart, ...]:
    """Return the parts with the values ``at`` (s,) of their ``free`` shape."""
    values: dict[str, dict[str, float]] = {}
    for (part, p), value in zip(free, at.tolist(), strict=True):
        values.setdefault(part.key, {})[p.name] = value
    return tuple(part.with_shape(values.get(part.key, {})) for part in parts)


def _solved(
    rows: Prepared, parts: tuple[ChannelPart, ...], *, uneven: bool, deviates: bool
) -> tuple[Solved, Array]:
    """Return the fit around the parts' shape, and the values with the shape that it wants, (p,)."""
    problem = linearised(rows, parts)
    beside = beside_laws(rows, problem, sweep=uneven, deviates=deviates)
    own = beside.deviation.groups if beside.deviation else []
    root = row_roots(rows, problem, own) if uneven else np.ones(len(problem.target))
    try:
        fit = least_squares_with_deviation(
            problem.columns * root[:, None],
            [group * root[:, None] for group in beside.groups],
            problem.target * root,
            likely=beside.likely,
            blocks=beside.blocks,
            order=NOISE_ORDER,
        )
    except NotSettled as error:
        terms = ",".join(part.key for part in parts)
        raise UnusableInput(
            phrase(
                "{file}: {axis}: the model discrepancy of friction cannot be estimated "
                "({error}); use fewer terms than {terms}",
                file=rows.path,
                axis=rows.axis,
                error=error,
                terms=terms,
            )
        ) from None
    end = fit.columns + sum(group.shape[1] for group in own)
    values, weights, _ = np.split(_at_shape(problem, fit), [fit.columns, end])
    return Solved(problem, fit, beside.deviation, values, fit.covariance, weights), fit.coefficients


def _at_shape(problem: Linearised, fit: Deviating) -> Array:
    """Return all values (p + m,) with the shape where the columns were computed.

    Coefficients and the deviation's weights are their mean given that shape:
    c − C_cs C_ss⁻¹ (ŝ − s).
    """
    is_shape = np.zeros(len(fit.whole), dtype=np.bool_)
    is_shape[: fit.columns] = [p in part.term.shape for part, p in problem.names]
    values = fit.whole.copy()
    if not is_shape.any():
        return values
    here = np.array([part.shape[p.name] for part, p in problem.names if p in part.term.shape])
    covariance = fit.narrow_covariance
    cross = covariance[np.ix_(~is_shape, is_shape)]
    own = covariance[np.ix_(is_shape, is_shape)]
    values[~is_shape] -= cross @ np.linalg.solve(own, values[is_shape] - here)
    values[is_shape] = here
    return values


def _vague(solved: Solved, rows: Prepared) -> list[int]:
    """Return the parameters that could be anything, the vaguest first: no move excites them.

    A coefficient whose sd makes its column as large as the effort; a shape parameter with an sd as
    large as itself.
    """
    sd = np.sqrt(np.maximum(np.diag(solved.covariance), 0.0))
    effort = float(np.sqrt(np.mean(rows.effort**2)))
    size = sd * np.sqrt(np.mean(solved.problem.columns**2, axis=0)) / (EXCITED * effort)
    for i, (part, p) in enumerate(solved.problem.names):
        empty = not solved.problem.columns[:, i].any()
        if p in part.term.shape:
            size[i] = sd[i] / max(abs(float(solved.values[i])), 1e-300)
        elif empty:
            size[i] = np.inf
    return [int(i) for i in np.argsort(-size, kind="stable") if size[i] > 1.0]


def _without_vague(solved: Solved, rows: Prepared) -> Array:
    """Return the values (p,) with vague coefficients at 0, the others given that.

    One after the other, the vaguest first, until none is vague: what they add up to stays right.
    All given the shape, which keeps its values: at 0 a speed or a distance means nothing.
    """
    shape = [i for i, (part, p) in enumerate(solved.problem.names) if p in part.term.shape]
    for k in shape:
        solved = replace(solved, covariance=given_one(solved.covariance, k))
    while True:
        vague = [k for k in _vague(solved, rows) if k not in shape]
        if not vague:
            return solved.values
        k = vague[0]
        # That blocks widen one sd more than another changes nothing in how values follow each other
        widened = solved.fit.inflation[k] / solved.fit.inflation
        slope = widened * solved.covariance[:, k] / solved.covariance[k, k]
        values = solved.values - slope * solved.values[k]
        values[k] = 0.0
        keep = np.arange(len(values)) != k
        columns = np.where(keep, solved.problem.columns, 1.0)
        problem = replace(solved.problem, columns=columns)
        covariance = given_one(solved.covariance, k)
        solved = replace(solved, problem=problem, values=values, covariance=covariance)


def _described(
    rows: Prepared,
    solved: Solved,
    dropped: Sequence[Name],
    published: Prepared,
    moving: Mapping[str, float],
    *,
    sweep: bool,
) -> Identified:
    names = solved.problem.names
    vague = sorted(_vague(solved, rows))
    numbered = [i for i in range(len(names)) if i not in vague]
    values = _without_vague(solved, rows)
    sd = np.sqrt(np.diag(solved.covariance))
    terms = [identified_term(names[i], values[i], float(sd[i]), rows) for i in numbered]
    in_sum = [identified_term(names[i], values[i], None, rows) for i in vague]
    told = (*terms, *in_sum, *given_shape(solved.problem.parts, rows))
    there = linearised(published, solved.problem.parts)
    weights = solved.weights_with(values)
    nearer, left = nearer_held_out(published, there, solved.off_law_sds, sweep=sweep)
    off_law = solved.deviation.off_law(weights) if solved.deviation and nearer else None
    error = published.effort - published.reduced(predicted_effort(told, published.inputs, off_law))
    rms, effort_rms = _rms(error), _rms(published.effort)
    return Identified(
        axis=rows.axis,
        channel=rows.channel,
        unit=rows.unit,
        terms=told,
        covariance=solved.covariance[np.ix_(numbered, numbered)],
        relative_error=rms / effort_rms,
        held_out_error=_rms(left) / effort_rms,
        errors=_errors(published, left, told, off_law),
        residual_rms=rms,
        protocol=published.protocol,
        not_excited=_not_excited([*dropped, *(names[i] for i in vague)]),
        doubts=(*_doubts(terms), *_restless(moving)),
        plain=_plain(published, there),
        steady=solved.deviation.steady(solved.fit, values, weights) if solved.deviation else None,
        off_law=off_law,
        moved=solved.moved,
    )


def _errors(
    rows: Prepared,
    left: Array,
    terms: Sequence[IdentifiedTerm],
    off_law: FrictionDiscrepancy | None,
) -> DriveErrors | None:
    """Return how far off the model is by what the axis does; a spindle has no travel and no turns.

    Breakaway is Coulomb friction, with what Stribeck friction adds at rest; at least what friction
    is, off its laws too, in the slower half of the motion.
    """
    if rows.axis == SPINDLE:
        return None
    grips = {("coulomb", "level"), ("stribeck", "level")}
    breakaway = sum(abs(t.value) for t in terms if (t.term, t.parameter) in grips)
    inputs = {name: rows.sampled(name) for name in rows.inputs}
    rubs = [t for t in terms if follows(term_called(t.term, t.form), SPEED)]
    friction = np.abs(rows.reduced(predicted_effort(rubs, rows.inputs, off_law)))
    speed = np.abs(inputs["velocity"])
    moves = np.abs(inputs["direction"]) >= 1.0
    if moves.any():
        slow = moves & (speed <= np.median(speed[moves]))
        breakaway = max(breakaway, float(np.median(friction[slow])))
    rate_hz = rows.rate_hz / rows.protocol.decimate
    return drive_errors(inputs, left, rate_hz=rate_hz, breakaway=breakaway)


def _rms(values: Array) -> float:
    return float(np.sqrt(np.mean(values**2)))


def _not_excited(lost: Sequence[Name]) -> tuple[str, ...]:
    said = {f"{part.key} {p.name}": part.term.excited_by for part, p in lost}
    return tuple(f"{name}: {move}" for name, move in said.items())


def _doubts(terms: Sequence[IdentifiedTerm]) -> list[str]:
    """Say which values lie outside what physics allows, by more than two standard deviations."""
    said = list[str]()
    for t in terms:
        p = next(p for p in term_called(t.term, t.form).parameters if p.name == t.parameter)
        slack = 2.0 * (t.sd or 0.0)
        if p.lower - slack <= t.value <= p.upper + slack:
            continue
        limit = p.lower if t.value < p.lower else p.upper
        hint = (
            TURNED if t.term in ("coulomb", "inertia") else phrase("the moves show no such effect")
        )
        said.append(
            phrase(
                "{key} {parameter} is {value} {unit}, beyond {limit}: {hint}",
                key=t.key,
                parameter=t.parameter,
                value=localized(f"{t.value:.4g}"),
                unit=t.unit,
                limit=localized(f"{limit:g}"),
                hint=hint,
            )
        )
    return said


def _restless(moving: Mapping[str, float]) -> list[str]:
    return [
        phrase(
            "{key}: its shape is determined only to {step} of its standard deviation",
            key=key,
            step=localized(f"{step:.2g}"),
        )
        for key, step in moving.items()
    ]


def plain_fit(rows: Prepared, parts: tuple[ChannelPart, ...]) -> PlainFit:
    """Return ordinary least squares of the parts around their shape."""
    return _plain(rows, linearised(rows, parts))


def _plain(rows: Prepared, problem: Linearised) -> PlainFit:
    """Return ordinary least squares; of columns that cannot be told apart only some are fitted."""
    kept = spanning(problem.columns)
    lags = round(0.2 * rows.rate_hz / rows.protocol.decimate)
    fit = least_squares(problem.columns[:, kept], problem.target, lags=lags)
    rms = float(np.sqrt(np.mean(fit.residual**2)))
    return PlainFit(
        protocol=rows.protocol,
        terms=tuple(
            identified_term(problem.names[i], value, float(sd), rows)
            for i, value, sd in zip(kept, fit.coefficients, fit.sd, strict=True)
        ),
        given=tuple(given_shape(problem.parts, rows)),
        relative_error=rms / float(np.sqrt(np.mean(rows.effort**2))),
        residual_rms=rms,
    )
