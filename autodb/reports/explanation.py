"""The answer of explain as one page: verdict first, then where, before and after, and the evidence.

The page is one file that loads nothing. ``explanation_fragment`` is the same content for a page
that has a shell of its own.
"""

import math
import re
from pathlib import Path

from markupsafe import Markup

from autodb.explain.answer.answer import (
    Cause,
    ChannelAnswer,
    ChannelTrace,
    Considered,
    Explained,
    Regime,
)
from autodb.explain.engine.candidates import UNKNOWN
from autodb.files.channels import unit_of
from autodb.reports import figures
from autodb.reports.explanation_plots import (
    against_signals,
    channel_words,
    close_up,
    drawn_words,
    located,
    traces_over_time,
)
from autodb.terms.vocabulary import effect_called, vocabulary

KIND_WORDS = {
    "missing": ("is missing", "are missing"),
    "mistuned": ("is set wrong", "are set wrong"),
}
CERTAINTY = (
    (0.95, "almost certain"),
    (0.8, "very likely"),
    (0.6, "likely"),
    (0.4, "about even"),
    (0.0, "a guess"),
)


def render_explanation(explained: Explained) -> str:
    """Return the report of one explanation: one HTML file that loads nothing."""
    return figures.whole_page(
        "explanation.html.j2",
        title=Path(explained.explanation.recording).name,
        content=Markup(explanation_fragment(explained)),
    )


def explanation_fragment(explained: Explained) -> str:
    """Return the report's content, headings from h3, for a page made by ``figures.whole_page``."""
    channels = [
        {
            "id": f"explain-{n}-{re.sub('[^a-z0-9]+', '-', name.lower())}",
            "name": name,
            "words": channel_words(name),
            "answer": answer,
            "trace": explained.traces.get(name),
        }
        for n, (name, answer) in enumerate(explained.explanation.channels.items(), start=1)
    ]
    words = (headline, certainty, term_words, move_words, parameter_words, effect_called)
    where = (where_words, regime_words, bars)
    plots = (
        traces_over_time,
        located,
        close_up,
        against_signals,
        ranked,
        candidate_words,
        drawn_words,
    )
    return str(
        figures.fragment(
            "_explanation.html.j2",
            channels=channels,
            notes=explained.notes,
            **{function.__name__: function for function in (*words, *where, *plots)},
        )
    )


# Words


def term_words(term: str) -> str:
    """Return a term in shop words; a name beyond the vocabulary as it is written."""
    return effect_called(term).title


def move_words(cause: Cause) -> str | None:
    """Return what would distinguish a cause from its alternatives, with the pairs in shop words."""
    text = cause.to_tell_apart
    for other in cause.alternatives if text else ():
        pair = f"{term_words(cause.term)} and {term_words(other)}"
        text = str(text).replace(f"{cause.term} and {other}", pair)
    return text


def candidate_words(name: str) -> str:
    """Return a candidate in shop words, with what it acts on where its name says more than a term.

    >>> candidate_words("gain force.x 1"), candidate_words("direction × time")
    ('a changed scale (force.x)', 'an effect without a known name (direction × time)')
    """
    said = re.sub(r" \d+$", "", name)
    term, _, rest = said.partition(" ")
    if term not in vocabulary():
        term, rest = UNKNOWN, said.removeprefix(UNKNOWN).strip()
    rest = re.sub(r"\bways\b", "components", rest)
    return f"{term_words(term)} ({rest})" if rest else term_words(term)


def parameter_words(name: str) -> str:
    """Return a parameter's name as a reader would say it."""
    return name.replace("_", " ")


def headline(answer: ChannelAnswer) -> str:
    """Return the channel's answer as a headline."""
    if not answer.missing:
        return "A mismatch without a cause found" if answer.mismatch else "No mismatch beyond noise"
    count = len(answer.missing)
    by_kind = (_causes_of_kind(answer, kind) for kind in KIND_WORDS)
    return f"{count} cause{'s' if count > 1 else ''} found: {'; '.join(filter(None, by_kind))}"


def _causes_of_kind(answer: ChannelAnswer, kind: str) -> str:
    """Return "A, B and C are missing", or nothing."""
    names = [_cause_words(cause) for cause in answer.missing if cause.kind == kind]
    if not names:
        return ""
    *others, last = names
    named = f"{', '.join(others)} and {last}" if others else last
    return f"{named} {KIND_WORDS[kind][bool(others)]}"


def _cause_words(cause: Cause) -> str:
    """Return a cause in shop words; of own terms of which one is off, all of them."""
    if cause.term == UNKNOWN and cause.kind == "mistuned":
        return " or ".join(term_words(name) for name in cause.alternatives)
    return term_words(cause.term)


def certainty(cause: Cause) -> tuple[str, int]:
    """Return how sure the name is: words with per cent, and how many of five marks to fill.

    All five only from 95 %.
    """
    return certainty_words(cause.confidence), max(1, int(5.0 * cause.confidence + 0.25))


def certainty_words(probability: float) -> str:
    """Return a probability in words with per cent."""
    words = next(words for least, words in CERTAINTY if probability >= least)
    percent = "over 99" if probability > 0.99 else f"{100.0 * probability:.0f}"
    return f"{words}, {percent} %"


def where_words(answer: ChannelAnswer, trace: ChannelTrace | None) -> list[str]:
    """Return where the mismatch sits, one line a stretch or a regime."""
    in_cuts = trace is not None and trace.x_name == "cut"
    lines = [
        f"Cuts {low:g} to {high:g}" if in_cuts else f"From {_second(low)} to {_second(high)} s"
        for low, high in answer.where.intervals
    ]
    return lines + [regime_words(regime) for regime in answer.where.regime]


def regime_words(regime: Regime) -> str:
    """Return a regime as a line: its signal, its range, and its share of the mismatch."""
    reach = figures.span(regime.low, regime.high, unit_of(regime.signal) or "")
    return f"{channel_words(regime.signal)} {reach}: {100.0 * regime.share:.0f} % of the mismatch"


def _second(t_s: float) -> str:
    """A time is never rounded beyond a second."""
    return figures.number(t_s) if abs(t_s) < 1000.0 else f"{t_s:.0f}"


def bars(answer: ChannelAnswer) -> list[tuple[str, str, float, float]]:
    """Return rows of errors: tone, what, value, length in per cent of the longest.

    Without a mismatch nothing was changed, so that there is no after.
    """
    fit = answer.fit
    whole = [("simulation", "Before, whole recording", fit.rms_before)]
    kept_out = [("simulation", "Before, parts kept out of the fit", fit.heldout_before)]
    if answer.mismatch:
        whole.append(("corrected", "After, whole recording", fit.rms_after))
        kept_out.append(("corrected", "After, parts kept out of the fit", fit.heldout_after))
    else:
        whole, kept_out = [("simulation", "Simulation", fit.rms_before)], []
    rows = [*whole, *kept_out, ("recording", "Noise of the recording", fit.noise_floor)]
    longest = max((value for *_, value in rows if math.isfinite(value)), default=0.0)
    return [(tone, what, value, _per_cent(value, longest)) for tone, what, value in rows]


def _per_cent(value: float, whole: float) -> float:
    return 100.0 * value / whole if whole > 0.0 and math.isfinite(value) else 0.0


def ranked(trace: ChannelTrace) -> list[Considered]:
    """Return what was considered, the strongest first."""
    return sorted(trace.considered, key=lambda candidate: -candidate.evidence)


# Plots
