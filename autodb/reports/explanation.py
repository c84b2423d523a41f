"""The answer of explain as one page: verdict first, then where, before and after, and the evidence.

The page loads nothing from outside. ``explanation_fragment`` is the same content for a page
that has a shell of its own.
"""

import math
import re
from collections.abc import Callable, Sequence
from pathlib import Path

from markupsafe import Markup

from autodb.explain.answer import (
    Cause,
    ChannelAnswer,
    ChannelTrace,
    Considered,
    Explained,
)
from autodb.explain.engine.candidates import UNKNOWN
from autodb.reports import amounts, figures
from autodb.reports.explanation_plots import (
    against_signals,
    channel_words,
    close_up,
    drawn_words,
    located,
    stretch_words,
    traces_over_time,
    where_words,
)
from autodb.reports.said_in_pages import told
from autodb.terms.vocabulary import effect_called, statement_parts, title_of, vocabulary
from autodb.wording import (
    ENGLISH,
    Worded,
    language_of,
    listed,
    msgid,
    phrase,
    presentation,
    presented,
)

KIND_WORDS = {
    "missing": (msgid("{causes} is missing"), msgid("{causes} are missing")),
    "mistuned": (msgid("{causes} is set wrong"), msgid("{causes} are set wrong")),
}
SURE = 0.9
"""Confidence from which on a cause is said without a word on how sure it is."""
CERTAINTY = (
    (0.95, msgid("almost certain")),
    (0.8, msgid("very likely")),
    (0.6, msgid("likely")),
    (0.4, msgid("about even")),
    (0.0, msgid("a guess")),
)

VARIABLES = (
    msgid("direction in a corner of position × speed"), msgid("corner of position × speed"),
    msgid("periodic in time"), msgid("periodic"), msgid("components"), msgid("direction"),
    msgid("braking, with effort against the motion"), msgid("acceleration"), msgid("position"),
    msgid("speed"), msgid("time"), msgid("tone"), msgid("bands"), msgid("that comes and goes"),
    msgid("in another shape"), msgid("at"),
)  # fmt: skip
"""What an effect without a name may depend on, beside channels."""
_VARIABLE = rf"(?<![.\w])(?:{'|'.join(VARIABLES)})(?![.\w])"


def render_explanation(explained: Explained) -> str:
    """Return the report of one explanation: a page that loads nothing from outside."""
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
            "shares": shares_of(answer, explained.traces.get(name)),
        }
        for n, (name, answer) in enumerate(explained.explanation.channels.items(), start=1)
    ]
    words = (
        headline,
        smaller_words,
        open_sentences,
        certainty,
        term_words,
        parameter_words,
        effect_called,
        told_statement,
    )
    where = (where_words, stretch_words, share_words, bars)
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
    return phrase(effect_called(term).title)


def told_statement(statement: str) -> Markup:
    """Return what was stated of a cause: what its effect does in the reader's language, where the
    vocabulary has it, the rest in English, as it was kept.
    """
    return Markup(" ").join(map(told, statement_words(statement)))


def statement_words(statement: str) -> list[Worded]:
    """Return what was stated of a cause: what its effect does, and the rest as it was kept."""
    does, *rest = statement_parts(statement)
    return [*([phrase(does)] if does else []), *(Worded(one, "en") for one in rest)]


def move_words(term: str, others: Sequence[str], text: str, called: Callable[[str], str]) -> Worded:
    """Return what would distinguish an effect from others, its sentences in the reader's language
    and the effects in words; in English where one sentence is there in English alone.
    """
    if presentation() != ENGLISH:
        from autodb.wording.kept import SENTENCE_ENDS, said_again  # who says English needs none

        every = SENTENCE_ENDS.split(_with_words(term, others, text, called))
        made = listed(map(said_again, every), " ")
        if language_of(made) == presentation().language:
            return made
    with presented(ENGLISH):
        return Worded(_with_words(term, others, text, called), "en")


def _with_words(term: str, others: Sequence[str], text: str, called: Callable[[str], str]) -> str:
    """Return a text with the pairs of effects in it, joined by ``and`` or ``from``, in words."""
    for other in others:
        for between in (" and ", " from "):
            pair = f"{called(term)}{between}{called(other)}"
            text = text.replace(f"{term}{between}{other}", pair)
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
    words = term_words(term)
    if not rest:
        return words
    what = re.sub(_VARIABLE, lambda found: phrase(found[0]), rest)
    return phrase("{candidate} ({what})", candidate=words, what=what)


def parameter_words(name: str) -> str:
    """Return a parameter's name as a reader would say it."""
    said, of_edge, edge = name.partition(" edge ")
    if of_edge:
        return phrase("{parameter}, edge {edge}", parameter=parameter_words(said), edge=edge)
    said, _, number = name.rpartition("_")
    if said and number.isdecimal():
        return phrase("{parameter} {number}", parameter=parameter_words(said), number=number)
    return phrase(name.replace("_", " "))


def headline(answer: ChannelAnswer, trace: ChannelTrace | None = None) -> str:
    """Return the first sentence: the largest cause, and the share of the error that it takes away.

    The share is of the squared error, `ChannelTrace.takes`.
    """
    if not answer.missing:
        return (
            phrase("A mismatch without a cause found")
            if answer.mismatch
            else phrase("No mismatch beyond noise")
        )
    first, (share, *_) = answer.missing[0], shares_of(answer, trace)
    which = phrase("The largest cause") if len(answer.missing) > 1 else phrase("The cause")
    if first.confidence < SURE:
        sure = certainty_words(first.confidence)
        which = phrase("{which} ({certainty})", which=which, certainty=sure)
    is_so = phrase(KIND_WORDS[first.kind][0], causes=_cause_words(first))
    said = phrase("{which}: {cause} ({size})", which=which, cause=is_so, size=_size_words(first))
    if share is None:
        return phrase("{said}.", said=said)
    taken = share_words(share)
    return phrase("{said}; it takes away {share} of the squared error.", said=said, share=taken)


def shares_of(answer: ChannelAnswer, trace: ChannelTrace | None) -> list[float | None]:
    """Return the share of the squared error that each cause takes away; None: not known."""
    if trace is None or len(trace.takes) != len(answer.missing):
        return [None] * len(answer.missing)
    return list(trace.takes)


def smaller_words(answer: ChannelAnswer, trace: ChannelTrace | None = None) -> str:
    """Return the sentence on the other causes that are sure; "" where there is none."""
    shares = shares_of(answer, trace)
    others = [
        (cause, share)
        for cause, share in zip(answer.missing[1:], shares[1:], strict=True)
        if cause.confidence >= SURE
    ]
    if not others:
        return ""
    by_kind = listed(filter(None, (_sure_of_kind(others, kind) for kind in KIND_WORDS)), "; ")
    least = f"{100.0 * SURE:.0f}"
    return phrase(
        "With less effect, at least {least} % sure: {causes}.", least=least, causes=by_kind
    )


def _sure_of_kind(causes: Sequence[tuple[Cause, float | None]], kind: str) -> str:
    """Return "A, B and C are missing", each with its size and share, or nothing."""
    names = []
    for cause, share in causes:
        if cause.kind == kind:
            sizes = [_size_words(cause), *([] if share is None else [share_words(share)])]
            of = listed(sizes)
            names.append(phrase("{cause} ({size})", cause=_cause_words(cause), size=of))
    if not names:
        return ""
    return phrase(KIND_WORDS[kind][len(names) > 1], causes=_listed(names, phrase(" and ")))


def _listed(names: Sequence[str], word: str) -> str:
    """Return "A, B and C", with the word before the last."""
    *others, last = names
    return listed([listed(others), last], word) if others else last


def _size_words(cause: Cause) -> str:
    size = cause.parameters["size"]
    return amounts.quantity(size.value, size.unit)


def share_words(share: float) -> str:
    """Return a share in per cent.

    >>> share_words(0.87), share_words(0.004), share_words(0.998)
    ('87 %', 'less than 1 %', 'over 99 %')
    """
    if share < 0.01:
        return phrase("less than 1 %")
    return phrase("over 99 %") if share > 0.99 else f"{100.0 * share:.0f} %"


def open_words(answer: ChannelAnswer, called: Callable[[str], str] | None = None) -> str:
    """Return what ``open_sentences`` are, as one paragraph; "" where a recording tells all."""
    return " ".join(open_sentences(answer, called))


def open_sentences(
    answer: ChannelAnswer, called: Callable[[str], str] | None = None
) -> list[Worded]:
    """Return what the recording cannot tell of a channel; nothing where it tells all.

    What it is not sure of, what each cause may also be and what would tell, and what is
    unexplained. ``called``: how terms are written, where not in shop words.
    """
    name = called or term_words
    unsure = [c for c in answer.missing if c.confidence < SURE]
    said = []
    if unsure:
        names = [
            phrase(
                "{cause} ({certainty})",
                cause=_named(c, name),
                certainty=certainty_words(c.confidence),
            )
            for c in unsure
        ]
        said.append(phrase("It is not sure of {causes}.", causes=_listed(names, phrase(" and "))))
    several = [c for c in answer.missing if c.alternatives]
    for cause in several:
        others = _listed([name(one) for one in cause.alternatives], phrase(" or "))
        plain = _named(cause, name)
        first = plain if called else Worded(plain[:1].upper() + plain[1:], language_of(plain))
        may_be = (
            phrase("{cause} may be {others}.", cause=first, others=others)
            if cause.term == UNKNOWN
            else phrase("{cause} may also be {others}.", cause=first, others=others)
        )
        said.append(may_be)
    moves = [
        _ended(move_words(c.term, c.alternatives, c.to_tell_apart, name))
        for c in several
        if c.to_tell_apart
    ]
    said += [phrase("To find out: {move}", move=move) for move in dict.fromkeys(moves)]
    if len(moves) < len(several):
        said.append(
            phrase("No simple move or cut is known that separates the others.")
            if moves
            else phrase("No simple move or cut is known that separates them.")
        )
    if answer.unexplained:
        said.append(phrase("Still unexplained: {what}", what=_ended(answer.unexplained)))
    return said


def _named(cause: Cause, name: Callable[[str], str]) -> str:
    """Return a cause, and over what where it has no name."""
    if not cause.variables or cause.term != UNKNOWN:
        return name(cause.term)
    over = _listed(cause.variables, phrase(" and "))
    return phrase("{cause} over {variables}", cause=name(cause.term), variables=over)


def _ended(text: str) -> Worded:
    """Return a sentence that explaining says with its full stop, in the language that it is in."""
    return Worded(text if text.endswith(".") else f"{text}.", language_of(text))


def _cause_words(cause: Cause) -> str:
    """Return a cause in shop words; of own terms of which one is off, all of them."""
    if cause.term == UNKNOWN and cause.kind == "mistuned":
        return listed((term_words(name) for name in cause.alternatives), phrase(" or "))
    return phrase(title_of(cause.term, cause.variables))


def certainty(cause: Cause) -> tuple[str, int]:
    """Return how sure the name is: words with per cent, and how many of five marks to fill.

    All five only from 95 %.
    """
    return certainty_words(cause.confidence), max(1, int(5.0 * cause.confidence + 0.25))


def certainty_words(probability: float) -> str:
    """Return a probability in words with per cent."""
    words = next(words for least, words in CERTAINTY if probability >= least)
    if probability > 0.99:
        return phrase("{words}, over 99 %", words=phrase(words))
    return phrase("{words}, {percent} %", words=phrase(words), percent=f"{100.0 * probability:.0f}")


def bars(answer: ChannelAnswer) -> list[tuple[str, str, float, float]]:
    """Return rows of errors: tone, what, value, length in per cent of the longest.

    Without a mismatch nothing was changed, so that there is no after.
    """
    fit = answer.fit
    whole = [("simulation", phrase("Before, whole recording"), fit.rms_before)]
    kept_out = [("simulation", phrase("Before, parts kept out of the fit"), fit.heldout_before)]
    if answer.mismatch:
        whole.append(("corrected", phrase("After, whole recording"), fit.rms_after))
        kept_out.append(
            ("corrected", phrase("After, parts kept out of the fit"), fit.heldout_after)
        )
    else:
        whole, kept_out = [("simulation", phrase("Simulation"), fit.rms_before)], []
    rows = [*whole, *kept_out, ("recording", phrase("Noise of the recording"), fit.noise_floor)]
    longest = max((value for *_, value in rows if math.isfinite(value)), default=0.0)
    return [(tone, what, value, _per_cent(value, longest)) for tone, what, value in rows]


def _per_cent(value: float, whole: float) -> float:
    return 100.0 * value / whole if whole > 0.0 and math.isfinite(value) else 0.0


def ranked(trace: ChannelTrace) -> list[Considered]:
    """Return what was considered, the strongest first."""
    return sorted(trace.considered, key=lambda candidate: -candidate.evidence)


# Plots
