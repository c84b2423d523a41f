"""Several recordings together: does a mismatch sit in machine, tool, material, sensor, calibration?

What sits in the tool goes with the tool, whatever else changes. Each effect that was found is
therefore held against every way in which the recordings may be grouped: by one of FACTORS, by the
work-tool pair, all alike, or each by itself. Groups are judged by

    χ² + k ln n,    χ² = Σ ((y_i − mean of its group) / s_i)²

over n recordings in k groups, y_i a number of the effect there, s_i its spread; an effect that was
searched for and not found counts as none. Ways that fit about as well are all named, with the cut
that would distinguish them. Source: analysis of crossed designs, as in Montgomery, Design and
Analysis of Experiments, ch. 3 and 5; the price of a group is that of Schwarz 1978.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict

from autodb.explain.answer import Cause, ChannelAnswer, IntervalValue
from autodb.fitting.gaussian import NORMAL_95
from autodb.records.tables import CutTable, Recording
from autodb.terms.vocabulary import effect_called
from autodb.wording import msgid, stored_msgid

Array = NDArray[np.float64]

FACTORS = (
    msgid("machine"), msgid("tool"), msgid("material"), msgid("sensor"), msgid("calibration"),
)  # fmt: skip
PAIR = "pair"
SCALE = ("shear", "gain")
"""Terms of one recording that are one effect in several: all of a force is larger or smaller."""
LOOSE = 0.15
"""Share of itself by which a number of one effect differs from cut to cut all the same. Chosen."""
BLIND = 3.0
"""A recording this many times as noisy as where an effect was found says nothing of it. Chosen."""
NEAR = 6.0
"""Ways of grouping whose score is no more above the best are named with it: odds of e³."""
CEILING = 0.99
SHOWS = stored_msgid("{channel}: {causes} shows in {count} of {n} recordings")
UNNAMED = stored_msgid("{found}; their side files do not name the {causes} of every one.")
WITH_NONE = stored_msgid("{found} and goes with none of what their side files name.")
SHARED_BY_ALL = stored_msgid(
    "{found}, which share their {causes}: nothing here tells which it sits in."
)
WITH_ONE = stored_msgid("{found} and goes with the {causes}.")
WITH_SEVERAL = stored_msgid(
    "{found} and goes with the {causes}; or with the {causes_other}, which change with it here."
)
SWAPPED = stored_msgid(
    "Repeat {one} with the {causes} of {other} and all else as it is: what sits in the {causes} "
    "changes with it, what sits in the {causes_other} stays."
)
CHANGED = stored_msgid(
    "Repeat {one} with another {causes} and all else as it is: what sits in the {causes} changes "
    "with it, what sits in the {causes_other} stays."
)


class _Part(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)


class RecordingSetup(_Part):
    """What a recording was made with; None: its side file does not say."""

    recording: str
    machine: str | None
    tool: str | None
    material: str | None
    sensor: str | None
    calibration: str | None

    def level(self, factor: str) -> str | None:
        """Return what stands for a factor, the pair of tool and material among them."""
        if factor == PAIR:
            known = self.tool is not None and self.material is not None
            return f"{self.material} / {self.tool}" if known else None
        found: str | None = getattr(self, factor)
        return found


class Seat(_Part):
    """Where an effect may sit, and the probability of that."""

    factor: str
    confidence: float


class Located(_Part):
    """One effect: its number in each recording, None where it could not show, and where it sits.

    ``quantity``: the parameter that is compared; ``sits_in``: likeliest first, empty where the
    recordings differ without any of the factors.
    """

    channel: str
    term: str
    quantity: str
    values: tuple[IntervalValue | None, ...]
    sits_in: tuple[Seat, ...]
    statement: str
    to_tell_apart: str | None = None


class ExplainedTogether(_Part):
    """What several recordings say together."""

    recordings: tuple[RecordingSetup, ...]
    effects: tuple[Located, ...]


def setup_of(recording: Recording | CutTable) -> RecordingSetup:
    """Return what a recording was made with, by its side file, or a table's one tool and work."""
    side = recording.side
    tool, work = side.tool.name, side.recording.work
    if isinstance(recording, CutTable):
        tool = tool or _only(recording, "tool")
        work = work or _only(recording, "work.material")
    return RecordingSetup(
        recording=str(recording.path),
        machine=side.recording.machine,
        tool=tool,
        material=work,
        sensor=side.recording.sensor,
        calibration=side.recording.calibration,
    )


def _only(table: CutTable, name: str) -> str | None:
    """Return the one text of all cuts, None where they differ or there is none."""
    texts = set(table.texts.get(name, ()))
    return texts.pop() if len(texts) == 1 else None


def explain_together(
    setups: Sequence[RecordingSetup], answers: Sequence[Mapping[str, ChannelAnswer]]
) -> ExplainedTogether:
    """Return where each effect sits that was found in one of several recordings.

    ``answers``: by channel, of each recording in the order of ``setups``.
    """
    keys = {
        (channel, _effect(cause)): None
        for answer in answers
        for channel, found in answer.items()
        for cause in found.missing
    }
    effects = [_located(setups, answers, channel, term) for channel, term in keys]
    return ExplainedTogether(recordings=tuple(setups), effects=tuple(effects))


def _effect(cause: Cause) -> str:
    return "scale" if cause.term in SCALE else cause.term


@dataclass(frozen=True)
class _Seen:
    """An effect in some of the recordings: their numbers, what it is there (n,), its spread."""

    setups: tuple[RecordingSetup, ...]
    term: str
    y: Array
    sd: Array


def _located(
    setups: Sequence[RecordingSetup],
    answers: Sequence[Mapping[str, ChannelAnswer]],
    channel: str,
    term: str,
) -> Located:
    found = [
        next((c for c in answer[channel].missing if _effect(c) == term), None)
        if channel in answer
        else None
        for answer in answers
    ]
    quantity = _compared([cause for cause in found if cause is not None])
    none = _none(quantity)
    noise = [answer[channel].fit.noise_floor if channel in answer else None for answer in answers]
    quietest = min(
        n for n, cause in zip(noise, found, strict=True) if cause is not None and n is not None
    )
    values: list[IntervalValue | None] = [
        cause.parameters[quantity]
        if cause is not None
        else None
        if floor is None or floor > BLIND * quietest
        else IntervalValue(value=none, low=none, high=none, unit="")
        for cause, floor in zip(found, noise, strict=True)
    ]
    seen = _seen(setups, values, term, none)
    seats = _seats(seen)
    return Located(
        channel=channel,
        term=term,
        quantity=quantity,
        values=tuple(values),
        sits_in=tuple(seats),
        statement=_statement(seen, channel, seats),
        to_tell_apart=_separating(seen, seats),
    )


def _where(term: str) -> tuple[str, ...]:
    """Return where an effect can sit by its physics, the likeliest first."""
    names = SCALE if term == "scale" else (term,)
    return tuple(dict.fromkeys(seat for name in names for seat in effect_called(name).sits))


def _compared(causes: Sequence[Cause]) -> str:
    """Return the parameter that is compared: the first of the law that shows in all, else the size.

    An axis that is off shows nothing of teeth that stand out in turn.
    """
    laws = [name for name in causes[0].parameters if name != "size"]
    return next((n for n in laws if all(_shows(n, c.parameters.get(n)) for c in causes)), "size")


def _shows(name: str, value: IntervalValue | None) -> bool:
    """Whether a parameter is there and its interval leaves out none."""
    none = _none(name)
    return value is not None and not value.low <= none <= value.high


def _none(quantity: str) -> float:
    """Return the value at which a parameter changes nothing."""
    return 1.0 if quantity == "factor" else 0.0


def _seen(
    setups: Sequence[RecordingSetup], values: Sequence[IntervalValue | None], term: str, none: float
) -> _Seen:
    kept = [(setup, v) for setup, v in zip(setups, values, strict=True) if v is not None]
    y = np.array([v.value - none for _, v in kept])
    own = np.array([0.5 * (v.high - v.low) / NORMAL_95 for _, v in kept])
    least = float(np.min(np.abs(y[y != 0.0]), initial=np.inf))
    sd = np.hypot(own, LOOSE * np.where(y == 0.0, least, np.abs(y)))
    return _Seen(tuple(setup for setup, _ in kept), term, y, sd)


def _seats(seen: _Seen) -> list[Seat]:
    """Return where an effect may sit, likeliest first."""
    where = _where(seen.term)
    score = {f: s for f in where if (s := _score(seen, _groups(seen, f))) is not None}
    each = _score(seen, tuple(range(len(seen.setups))))
    if not score or each is None:
        return []
    best = min(score.values())
    weight = {f: float(np.exp(-0.5 * (s - best))) for f, s in score.items()}
    alone = float(np.exp(-0.5 * (each - best))) if each < best else 0.0
    whole = sum(weight.values()) + alone
    if alone > sum(weight.values()):
        return []
    near = [f for f in sorted(score, key=lambda f: score[f]) if score[f] - best <= NEAR]
    return [Seat(factor=f, confidence=min(CEILING, weight[f] / whole)) for f in near]


def _groups(seen: _Seen, factor: str) -> tuple[int, ...] | None:
    """Return the group of each recording by a factor; None where one does not say its level."""
    levels = [setup.level(factor) for setup in seen.setups]
    if any(level is None for level in levels):
        return None
    numbers = {level: k for k, level in enumerate(dict.fromkeys(levels))}
    return tuple(numbers[level] for level in levels)


def _score(seen: _Seen, groups: tuple[int, ...] | None) -> float | None:
    """Return χ² + k ln n of recordings in groups."""
    if groups is None:
        return None
    weight, place = 1.0 / seen.sd**2, np.array(groups)
    mean = np.bincount(place, weight * seen.y) / np.bincount(place, weight)
    chi2 = float(np.sum(weight * (seen.y - mean[place]) ** 2))
    return chi2 + len(mean) * float(np.log(max(len(place), 2)))


def _statement(seen: _Seen, channel: str, seats: Sequence[Seat]) -> str:
    count, n = int(np.count_nonzero(seen.y)), len(seen.y)
    what = msgid("a change of scale") if seen.term == "scale" else seen.term.replace("_", " ")
    shown = SHOWS.format(channel=channel, causes=what, count=count, n=n)
    where = _where(seen.term)
    unsaid = [factor for factor in where if _groups(seen, factor) is None]
    if len(unsaid) == len(where):
        return UNNAMED.format(found=shown, causes=", ".join(map(_words, unsaid)))
    if not seats:
        return WITH_NONE.format(found=shown)
    others = ", ".join(_words(seat.factor) for seat in seats)
    if np.ptp(_groups(seen, seats[0].factor) or (0,)) == 0:
        return SHARED_BY_ALL.format(found=shown, causes=others)
    if len(seats) == 1:
        return WITH_ONE.format(found=shown, causes=others)
    first, _, rest = others.partition(", ")
    return WITH_SEVERAL.format(found=shown, causes=first, causes_other=rest)


def _words(factor: str) -> str:
    return msgid("work-tool pair") if factor == PAIR else factor


def _separating(seen: _Seen, seats: Sequence[Seat]) -> str | None:
    """Return the cut that would distinguish the likeliest two: one of them changed alone."""
    if len(seats) < 2:
        return None
    first, second = (seat.factor for seat in seats[:2])
    order = np.argsort(-np.abs(seen.y), kind="stable")
    strong = seen.setups[int(order[0])]
    other = next(
        (
            seen.setups[int(k)]
            for k in order[::-1]
            if seen.setups[int(k)].level(first) != strong.level(first)
        ),
        None,
    )
    both = {"causes": _words(first), "causes_other": _words(second)}
    if other is None:
        return CHANGED.format(one=strong.recording, **both)
    return SWAPPED.format(one=strong.recording, other=other.recording, **both)
