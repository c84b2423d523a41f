"""Explain one axis effort over time."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Self

import numpy as np
from numpy.typing import NDArray

from autodb.errors import UnusableInput
from autodb.explain.answer import (
    ChannelAnswer,
    ChannelTrace,
    Considered,
    FitQuality,
    Where,
    considered,
    largest_first,
)
from autodb.explain.axis.causes import causes
from autodb.explain.axis.effects import acting_candidates, candidates_of_axis
from autodb.explain.axis.loads import TURNING, pulsed_loads
from autodb.explain.axis.read_off import READ_OFF
from autodb.explain.axis.reading import (
    GAP_S,
    AxisReading,
    best_reading,
    left_out_error,
    parts_of_causes,
    signals_of_causes,
    sized_anew,
)
from autodb.explain.axis.scan import Left, proposals_of_axis
from autodb.explain.axis.sensors_of_axis import SpeedControl, less_sure, speed_control
from autodb.explain.axis.signals import NO_PARTS, AxisSignals, axis_signals
from autodb.explain.axis.tilt import CONSTANT
from autodb.explain.axis.unknown import unknown_candidates
from autodb.explain.engine.bench import WhiteRows
from autodb.explain.engine.cancelling import most_cancelled
from autodb.explain.engine.candidates import Candidate, Choice
from autodb.explain.engine.fit import SAME, no_difference, rms
from autodb.explain.engine.fitted import fit_white_rows
from autodb.explain.engine.inquiry import Inquiry, inquire
from autodb.explain.engine.locate import regimes
from autodb.explain.engine.noise import Whitener
from autodb.explain.engine.search import FoundSet
from autodb.explain.engine.tuning import tuned_together
from autodb.explain.engine.weighing import weighing
from autodb.files.channels import axis_of
from autodb.records.tables import Recording
from autodb.sensing.drives.moves.dead_bands import is_on_change, refuse_unknown_rests
from autodb.wording import localized, phrase, significant

Array = NDArray[np.float64]

WORKING_HZ = 250.0
"""Rate that the search works at: means of more rows blur reversals, where lag, play and limits of
the drive show."""
WORKING_ROWS = 60_000
"""Long recordings are searched in fewer rows: some 600 columns of them take 0.3 GiB a copy."""
FINE_ROWS = 500
"""Rows that a short recording keeps, whatever its rate: two seconds at ``WORKING_HZ``. Of a stroke
on a drive's oscilloscope those at that rate are too few. Chosen."""
SHORTEST_ROWS = 200
GLITCH = 1000.0
GLITCH_ROWS = 20
"""A value GLITCH times the 20th largest is a glitch of the logger, not an effort."""
AT_STARTS = frozenset({"stribeck", "presliding", "backlash", "compliance"})
"""Terms that act where a motion begins or ends, and nowhere else to speak of."""
REST = 0.02
"""Share of a simulation that its own terms do not give, from which on the rest is kept as one: less
is how well they could be read, and turned round it would bend friction over speed. Chosen."""


def explain_axis(
    recording: Recording,
    simulation: Array,
    channel: str,
    includes: list[str] | None,
    parts: Mapping[str, Array] = NO_PARTS,
) -> tuple[ChannelAnswer, ChannelTrace]:
    """Say what the simulation of one effort channel leaves out.

    ``simulation`` (n,) on the recording's time; ``includes`` the terms it already has, read off it
    when None; ``parts`` what of it is known to come from which term, (n,) each.

    Raises UnusableInput on a recording too short to judge, one without the effort at rest, or a
    glitch that outweighs everything.
    """
    measured, unit = recording[channel], recording.unit(channel)
    _check(recording, channel, measured, simulation)
    refuse_unknown_rests(recording, axis_of(channel))
    signals = axis_signals(recording, simulation, channel, parts, includes)
    trace = ChannelTrace(
        x_name="t",
        x=recording.t_s,
        recording=measured,
        simulation=simulation,
        corrected=simulation,
        regime_signals={
            signals.channel("position"): signals.position,
            signals.channel("velocity"): signals.velocity,
        },
        cutoff_hz=signals.cutoff_hz,
        lowered=signals.lowered,
    )
    difference = measured - simulation
    if rms(difference) <= SAME * max(rms(measured), rms(simulation)):
        return no_difference(unit), trace
    own = _own_columns(signals)
    factor = _factor(recording)
    bench = WhiteRows(
        difference,
        own,
        factor,
        recording.timing,
        own_sizes=[signals.own_size(name) for name in own],
        gap=round(GAP_S / (factor * recording.timing.step_s)),
        progress=_progress(signals),
    )
    inquiry = inquire(bench, AxisField(signals, bench, unseen_terms(recording, axis_of(channel))))
    had = frozenset(own) | frozenset(includes or ())
    trace = replace(trace, considered=_considered(inquiry))
    read = [_read(bench, one, signals, had, unit) for one in _plainer(inquiry)]
    fit, reading = best_reading(read, trace)
    if left_out_error(fit) > fit.heldout_before:
        return _nothing(fit, unit), trace
    return _answer(reading, fit, trace, recording)


def _plainer(inquiry: Inquiry) -> list[Inquiry]:
    """Return what was found, and the laws alone that plain rows need: it has to predict better."""
    if not inquiry.found.choices:
        return [inquiry]
    return [inquiry, replace(inquiry, found=FoundSet())]


def _read(
    bench: WhiteRows,
    inquiry: Inquiry,
    signals: AxisSignals,
    had: frozenset[str],
    unit: str,
) -> AxisReading:
    """Return the final fit of what was found, less what is of its kind no more once it is tuned, or
    not what was recorded, and what the others cancel.
    """
    found = inquiry.found
    beside = inquiry.bench.loosened(found.choices)
    choices = tuned_together(beside, found.choices, inquiry.noise)
    unshown = next((choice for choice in choices if not choice.shape.is_shown), None)
    unlike = unshown or beside.of_another_kind(choices, inquiry.whitener)
    if unlike is not None:
        return _read(bench, _without(inquiry, unlike), signals, had, unit)
    noise = weighing(beside, choices, inquiry.noise, own=bool(inquiry.laws))
    if inquiry.laws and noise[0] is not inquiry.whitener:
        noise = inquiry.plain_noise
    laws = inquiry.founded
    fitted = fit_white_rows(beside, choices, noise, laws, also=sized_anew(inquiry, noise, beside))
    rows = inquiry.bench
    cancelled = most_cancelled(
        [rows.reduce(effect)[:, 0] for effect in fitted.effects],
        rows.chosen(()),
        rows.reduced_difference,
        named=[choice.candidate.named for choice in choices],
    )
    if cancelled is not None:
        return _read(bench, _without(inquiry, choices[cancelled]), signals, had, unit)
    return AxisReading(beside, inquiry, noise, choices, fitted, signals, had, unit, bench)


def _without(inquiry: Inquiry, choice: Choice) -> Inquiry:
    """Return an inquiry that did not find a choice."""
    rest = inquiry.found.without(choice.candidate.key)
    return replace(inquiry, found=inquiry.search.scored(rest))


def unseen_terms(recording: Recording, axis: str) -> frozenset[str]:
    """Return the terms that rows written on change cannot show: when a motion begins and ends is
    known to a dead band only, where its speed is derived from its place.
    """
    derived = f"{axis}.velocity" not in recording
    return AT_STARTS if derived and is_on_change(recording) else frozenset()


@dataclass(frozen=True)
class AxisField:
    """The candidates of an axis; those that the simulation has as own terms are left out.

    One that it has as a known part is none of them: it may be there in another form. ``unseen``:
    terms that the recording cannot show.
    """

    signals: AxisSignals
    bench: WhiteRows
    unseen: frozenset[str] = frozenset()

    def standing(self) -> list[Candidate]:
        """Return every candidate but those that scans find."""
        s, pulsed = self.signals, pulsed_loads(self.signals, self.bench.difference)
        return self._open([*candidates_of_axis(s), *pulsed, *unknown_candidates(s)])

    def beside(self, retuned: Array, parts: list[tuple[str, Array]]) -> list[Candidate]:
        """Return the effects that act on others, on all that has been found."""
        return self._open(acting_candidates(self.signals.beside(retuned, parts)))

    def scanned(self, columns: Array, whitener: Whitener, number: int) -> list[Candidate]:
        """Return what scans of what columns (m, p) leave at the working rate point to."""
        s, factor, rate = self.signals, self.bench.factor, self.bench.rate
        t_s, position, velocity, sense = (
            rate.reduced(values) for values in (s.t_s, s.position, s.velocity, s.sense)
        )
        step_s = factor * float(np.median(np.diff(s.t_s)))
        left = self.bench.left(columns, whitener)
        rows = Left(t_s, position, velocity, sense, left, columns, whitener, factor, step_s)
        return proposals_of_axis(s, rows, number)

    def completed(self, bench: WhiteRows, retuned: Array, parts: list[tuple[str, Array]]) -> Self:
        """Return the candidates of a simulation that holds what was found too."""
        return type(self)(self.signals.completed(retuned, parts), bench, self.unseen)

    def _open(self, candidates: list[Candidate]) -> list[Candidate]:
        had = self.bench.own.keys()
        own = had & READ_OFF
        if self.signals.rotary and "gravity" in own:
            own = own - {"gravity"} | {TURNING} | ({"gravity"} if CONSTANT in had else set())
        closed = own | self.unseen
        return [c for c in candidates if not {c.term, c.key} & closed and c.key not in had]


def _factor(recording: Recording) -> int:
    rows = len(recording) / WORKING_ROWS
    finest = min(recording.timing.rate_hz / WORKING_HZ, len(recording) / FINE_ROWS)
    return max(1, int(finest), int(np.ceil(rows)))


def _progress(signals: AxisSignals) -> Array:
    """Return the share of the course that lies behind each row, (n,): half of the time, half of the
    way. While an axis rests, each row says the same of what its motion makes.
    """
    way = np.cumsum(np.abs(signals.velocity))
    time = np.arange(1.0, len(way) + 1.0) / len(way)
    return time if way[-1] <= 0.0 else 0.5 * (time + way / way[-1])


def _own_columns(signals: AxisSignals) -> dict[str, Array]:
    """Return the columns of the simulation's own terms, and what of it they do not give."""
    own = dict(signals.own)
    rest = signals.simulation
    if own:
        matrix = np.column_stack(list(own.values()))
        rest = rest - matrix @ np.linalg.lstsq(matrix, rest, rcond=None)[0]
    if rms(rest) > REST * rms(signals.simulation) > 0:
        own["rest"] = rest
    return own


def _nothing(fit: FitQuality, unit: str) -> ChannelAnswer:
    """Return the answer where nothing that was tried predicts rows left out better."""
    kept = fit.model_copy(update={"rms_after": fit.rms_before, "heldout_after": fit.heldout_before})
    return ChannelAnswer(unit=unit, mismatch=False, where=Where(), missing=(), fit=kept)


def _answer(
    reading: AxisReading, fit: FitQuality, trace: ChannelTrace, recording: Recording
) -> tuple[ChannelAnswer, ChannelTrace]:
    found = causes(reading)
    if not found:
        return _nothing(fit, reading.unit), trace
    control = speed_control(trace.recording, reading.signals.velocity)
    if control is not None:
        found, trace = less_sure(found), replace(trace, remark=_said(control, reading))
    difference, correction = trace.recording - trace.simulation, reading.correction
    parts = parts_of_causes(found, reading)
    missing, takes = largest_first(found, parts, correction=correction, difference=difference)
    intervals = tuple(one for choice in reading.everything for one in _intervals(choice))
    acted = {} if intervals else signals_of_causes(missing, reading, recording)
    answer = ChannelAnswer(
        unit=reading.unit,
        mismatch=True,
        where=Where(intervals=intervals, regime=regimes(difference, correction, acted)),
        missing=missing,
        fit=fit,
    )
    return answer, replace(trace, corrected=trace.simulation + correction, takes=takes)


def _said(control: SpeedControl, reading: AxisReading) -> str:
    signals = reading.signals
    return phrase(
        "{share} of the effort is what a speed controller makes of {velocity} ({gain} {unit} for "
        "each unit of speed that lacks): it hides what the axis needs, and no name is sure; record "
        "moves whose speed is meant to change",
        share=localized(f"{control.share:.0%}"),
        velocity=signals.channel("velocity"),
        gain=significant(control.gain),
        unit=reading.unit,
    )


def _intervals(choice: Choice) -> Sequence[tuple[float, float]]:
    """Return the stretches that an effect is confined to."""
    if choice.candidate.interval is None:
        return choice.candidate.stretches
    return [(choice.shape.shape["start"], choice.shape.shape["end"])]


def _considered(inquiry: Inquiry) -> tuple[Considered, ...]:
    """Return the laws that plain rows need with what they lower there, and every candidate of the
    first round; one found later with its evidence in its set.
    """
    found, laws, rows = inquiry.found, inquiry.founded, inquiry.rows
    worth = {**dict(zip(found.keys, found.evidence, strict=True)), **inquiry.considered}
    if rows is not None:
        worth |= {c.candidate.key: rows.evidence(laws, c) for c in laws}
    return considered(worth, {*found.keys, *(c.candidate.key for c in laws)})


def _check(recording: Recording, channel: str, measured: Array, simulation: Array) -> None:
    """Refuse what no search can judge: too short, or a glitch that outweighs everything."""
    if len(recording) < SHORTEST_ROWS:
        raise UnusableInput(
            phrase(
                "{file}: {n} rows are too few to hold parts out of the fit; record at least "
                "{shortest_rows} rows",
                file=recording.path,
                n=len(recording),
                shortest_rows=SHORTEST_ROWS,
            )
        )
    for name, values in (("recording", measured), ("simulation", simulation)):
        size = np.abs(values)
        row, others = int(np.argmax(size)), float(np.partition(size, -GLITCH_ROWS)[-GLITCH_ROWS])
        if size[row] > GLITCH * others > 0:
            raise UnusableInput(
                phrase(
                    "{file}: {channel} of the {name}, row {row}: {values} is over {glitch} times "
                    "all but a few rows; remove that row",
                    file=recording.path,
                    channel=channel,
                    name=name,
                    row=row + 1,
                    values=significant(values[row]),
                    glitch=localized(f"{GLITCH:g}"),
                )
            )
