"""Identify a feed axis from its moves: the terms of its drive effort (P0 section 2.2, P2).

Air moves give the drive's own unit: amperes stay amperes. Kilograms and newtons need an effort in
newtons (a torque constant from the data sheet, a known mass, a push against a load cell).
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from autodb.errors import UnusableInput, near_words
from autodb.records.tables import Recording
from autodb.sensing.drives.fit.axis_fit import fit_axis, plain_fit
from autodb.sensing.drives.fit.axis_model import (
    Identified,
    IdentifiedTerm,
    PlainFit,
    Posteriors,
    predicted_effort,
)
from autodb.sensing.drives.fit.cogging import TriedCogging, with_best_cogging
from autodb.sensing.drives.fit.discrepancy import FrictionDiscrepancy
from autodb.sensing.drives.fit.linearised import linearised, shaped
from autodb.sensing.drives.fit.ripples import Ripple, strongest_ripple
from autodb.sensing.drives.fit.steady import friction_deviation
from autodb.sensing.drives.moves.motion import axis_kind, protocol_of, term_inputs
from autodb.sensing.drives.moves.passes import is_sweep
from autodb.sensing.drives.moves.prepared import Prepared, prepared
from autodb.sensing.drives.moves.protocol import (
    WAY_MM,
    FilterProtocol,
    decimated_means,
    default_protocol,
    means_by_way,
)
from autodb.terms.channel import ChannelPart, parts_over
from autodb.terms.drive import COGGING
from autodb.terms.ripple import NODES
from autodb.terms.term import Channel, Contribution, Term, TermParameter
from autodb.terms.vocabulary import terms_on
from autodb.wording import listed, phrase

Array = NDArray[np.float64]

WAVE_ROWS = 4
"""Rows that show a wave of a ripple: at its crests and between them. Chosen."""
RECOVERS_LATE = 3.0
"""Levelling of `warmup` where no earlier version knows it. With it friction falls by 8 and 19 % in
10 and 50 s at 10 000 mm/min (P2: 5 to 10 and 15 to 20 %) and comes back in minutes. At 0 one time
constant stands for both: long rests and slow passes show that of the recovery, and the fall was as
slow, and twice as deep as P2's. Recordings cannot choose it: what friction is off its laws hides
the difference. Chosen of 0 to 20 on sweeps of virtual axes (seeds 101 to 103)."""
SPREAD_CUTOFFS_HZ = (50.0, 75.0, 100.0, 150.0, 200.0)


def identify(
    recording: Recording,
    *,
    axis: str | None = None,
    protocol: FilterProtocol | None = None,
    terms: Sequence[str] | None = None,
    posteriors: Posteriors | None = None,
    by_way: bool | None = None,
) -> Identified:
    """Identify the terms of one axis' effort; ``default_terms`` if ``terms`` are not given.

    With ``axis`` `spindle` those of the spindle's torque or current over its speed.

    Shape parameters by variable projection on ordinary least squares; then all parameters again, on
    means of as many rows as the protocol keeps one of, with friction free to deviate from its law
    over speed and with coloured noise (``fitting.deviation``), which is what their values and
    covariance come from. ``posteriors``: what an earlier version knows, its given shape included:
    the other numbers are about that shape. ``by_way``: the moves are a sweep over speeds, whose
    slow passes count by the way gone (``means_by_way``); None: where their passes say so
    (``is_sweep``).

    Raises UnusableInput for names that cannot be identified, without effort or position, or when
    no term is excited.
    """
    given = posteriors.others if posteriors else {}
    begun = _begun(recording, axis, protocol, terms, given)
    rows = begun.rows
    way = is_sweep(recording, rows.axis) if by_way is None else by_way
    means = rows.by(_by_way(begun) if way else decimated_means(rows.protocol))
    parts, tried = shaped(means, begun.parts), tuple[TriedCogging, ...]()
    if begun.ripple is not None and begun.ripple.term is COGGING:
        parts, tried = with_best_cogging(means, parts, begun.ripple)
    found = fit_axis(means, parts, posteriors, published=rows, uneven=way)
    return replace(found, cogging=tried)


def _by_way(begun: "_Begun") -> FilterProtocol:
    """Return means by the way gone, short enough to show what is periodic: WAVE_ROWS over each wave
    of friction at least, one a node of a table of cogging.
    """
    rows, ripple, way_mm = begun.rows, begun.ripple, WAY_MM
    if ripple is not None:
        shortest = ripple.pole / NODES if ripple.term is COGGING else ripple.period / WAVE_ROWS
        way_mm = min(WAY_MM, shortest)
    return means_by_way(rows.protocol, rows.inputs["velocity"], timing=rows.timing, way_mm=way_mm)


def ordinary_least_squares(
    recording: Recording,
    *,
    axis: str | None = None,
    protocol: FilterProtocol | None = None,
    terms: Sequence[str] | None = None,
) -> PlainFit:
    """Return ordinary least squares of the same terms: what published methods print."""
    begun = _begun(recording, axis, protocol, terms, {})
    return plain_fit(begun.rows, shaped(begun.rows, begun.parts))


@dataclass(frozen=True)
class _Begun:
    """The rows at the protocol, and the parts where a search for their shape begins."""

    rows: Prepared
    parts: tuple[ChannelPart, ...]
    ripple: Ripple | None


def _begun(
    recording: Recording,
    axis: str | None,
    protocol: FilterProtocol | None,
    terms: Sequence[str] | None,
    given: Mapping[tuple[str, str], float],
) -> _Begun:
    """Return where a search for the shape of the terms begins.

    `cogging` is looked for at the full rate in what the other terms leave; where friction carries
    the ripple it becomes periodic position friction. Rows are then kept often enough to show it.
    """
    rows = prepared(recording, axis=axis, protocol=protocol)
    kind = axis_kind(rows.axis)
    terms, known = terms or default_terms(kind), identifiable_terms(kind)
    for name in terms:
        if name not in known:
            raise UnusableInput(
                phrase(
                    "--terms: '{name}' cannot be identified from moves of {axis}{hint}; known: "
                    "{names}",
                    name=name,
                    axis=rows.axis,
                    hint=near_words(name, known),
                    names=", ".join(known),
                )
            )
    asked = [known[name] for name in terms if name != "cogging"]
    parts = tuple(part for term in asked for part in _starting(rows, term, given))
    if not any(isinstance(part.term, Contribution) for part in parts):
        raise UnusableInput(
            phrase(
                "--terms: {names} only change what others add; name {names_2} beside them",
                names=", ".join(terms),
                names_2=",".join(default_terms(kind)),
            )
        )
    found = None
    if "cogging" in terms:
        found = find_ripple(rows, parts)
        if found is None:
            raise UnusableInput(
                phrase(
                    "{file}: no ripple over the travel stands out of the residual of the other "
                    "terms; leave out 'cogging'",
                    file=rows.path,
                )
            )
        parts = (*parts, ChannelPart(found.term, {"period": found.period}, ("period",)))
        if protocol is None:
            rows = rows.by(_fine_enough(rows, found.period))
    return _Begun(rows, parts, found)


def default_terms(kind: Channel) -> tuple[str, ...]:
    """Return the terms that any move excites: of a feed axis the symmetric model of Janot 2019."""
    return tuple(name for name, term in identifiable_terms(kind).items() if term.any_moves)


def identifiable_terms(kind: Channel) -> dict[str, Term]:
    """Return the machine's terms that an axis' effort may have, by name.

    A search for their shape begins at their starts, or at what is given; `cogging` is looked for.
    """
    return {
        name: term
        for name, term in terms_on(kind).items()
        if term.belongs_to == "machine"
        and (term is COGGING or all(p.given or p.starts for p in term.shape))
    }


def _fine_enough(rows: Prepared, period: float) -> FilterProtocol:
    """Return the protocol with WAVE_ROWS rows a wave of the ripple at the top speed."""
    passing_hz = float(np.max(np.abs(rows.inputs["velocity"]))) / period
    factor = int(rows.rate_hz / (WAVE_ROWS * passing_hz))
    return replace(rows.protocol, decimate=max(1, min(rows.protocol.decimate, factor)))


def _starting(
    rows: Prepared, term: Term, given: Mapping[tuple[str, str], float]
) -> list[ChannelPart]:
    """Return the parts of a term at the shape where a search begins, or at the one given.

    Raises UnusableInput without what it takes.
    """
    shape = {p.name: _start(p, rows) for p in term.shape}
    fixed = [p.name for p in term.shape if p.given]
    shape |= {name: given[term.name, name] for name in fixed if (term.name, name) in given}
    free = tuple(name for name in shape if name not in fixed)
    made = parts_over(term, rows.inputs, shape, free)
    if not made:
        raise UnusableInput(
            phrase(
                "{file}: {term} needs {names}",
                file=rows.path,
                term=term.name,
                names=listed(term.needs, phrase(" and ")),
            )
        )
    return made


def _start(parameter: TermParameter, rows: Prepared) -> float:
    if parameter.name == "middle":
        return rows.middle_mm
    return RECOVERS_LATE if parameter.name == "levelling" else parameter.starts[0]


def find_ripple(rows: Prepared, parts: tuple[ChannelPart, ...]) -> Ripple | None:
    """Return the strongest ripple over the travel in what ``parts`` leave, at the full rate.

    What their friction may deviate by is taken off first: it is no ripple.
    """
    whole = rows.by(replace(decimated_means(rows.protocol), decimate=1))
    problem = linearised(whole, parts)
    deviation = friction_deviation(whole, problem)
    design = np.column_stack([problem.columns, *(deviation.groups if deviation else [])])
    left = whole.effort - design @ np.linalg.lstsq(design, whole.effort, rcond=1e-10)[0]
    return strongest_ripple(
        whole.sampled("position"),
        whole.sampled("direction"),
        left,
    )


def spread_over_filters(
    recording: Recording, *, axis: str | None = None, terms: Sequence[str] | None = None
) -> list[PlainFit]:
    """Return plain least squares at 50 to 200 Hz, with and without the anti-alias filter.

    It shows how much of a result is owed to the filter; a recording too slow for 50 Hz has none.
    """
    base = default_protocol(recording.timing.rate_hz)
    return [
        ordinary_least_squares(
            recording,
            axis=axis,
            protocol=replace(base, cutoff_hz=hz, anti_alias=anti_alias),
            terms=terms,
        )
        for anti_alias in (True, False)
        for hz in SPREAD_CUTOFFS_HZ
        if hz < 0.5 * recording.timing.rate_hz
    ]


def predict_effort(
    recording: Recording,
    axis: str,
    terms: Sequence[IdentifiedTerm],
    off_law: FrictionDiscrepancy | None = None,
) -> Array:
    """Return the effort (n,) that identified terms give for a recording's motion.

    With ``off_law`` what friction is off their laws is in it.
    """
    cutoff_hz = protocol_of(recording, axis).cutoff_hz
    return predicted_effort(terms, term_inputs(recording, axis, cutoff_hz=cutoff_hz), off_law)


def cross_test(
    recording: Recording,
    axis: str,
    protocol: FilterProtocol,
    terms: Sequence[IdentifiedTerm],
    off_law: FrictionDiscrepancy | None = None,
) -> float:
    """Return the relative error of a model on a recording that it was not fitted to."""
    rows = prepared(recording, axis=axis, protocol=protocol)
    left = rows.effort - rows.reduced(predicted_effort(terms, rows.inputs, off_law))
    return float(np.sqrt(np.mean(left**2) / np.mean(rows.effort**2)))


def without_ripple(terms: Sequence[IdentifiedTerm]) -> list[IdentifiedTerm]:
    """Return the terms that are not periodic over the travel."""
    ripples = {t.key for t in terms if t.parameter == "period"}
    return [t for t in terms if t.key not in ripples]
