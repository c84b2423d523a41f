"""How an answer to a real axis or table is judged: named, its size, wrong, harmful, sure, right."""

from dataclasses import dataclass, replace
from typing import Protocol

from autodb.proofs.runs.real.real_answers import RealAnswer, SaidEntry
from autodb.proofs.runs.real.real_peers import PeerAnswer

WITHIN_NAMED = (0.5, 2.0)
"""Size of a fair name, of the true one's, with which it counts as named."""
WITHIN_HIT = (0.75, 1.25)
CARRIES = 0.5
"""Share of the concealed size from which a wrong name carries it."""
HARMED = 1.02
RETUNED = 0.3
"""Share of an own term's peak up to which a null's may be called mistuned."""

LONGEST_ERROR = 300


class KnownCase(Protocol):
    """What is known of a case; see `RealCase`."""

    @property
    def name(self) -> str:
        """What the case is called."""

    @property
    def kind(self) -> str:
        """Return `shown`, `left out`, `injected` or `null`."""

    @property
    def machine(self) -> str:
        """Whose recording it is."""

    @property
    def concealed(self) -> str | None:
        """What the simulation lacks."""

    @property
    def strength(self) -> str:
        """How strongly the effect shows."""

    @property
    def tuning(self) -> str:
        """What the simulation's own terms are."""

    @property
    def seen(self) -> bool:
        """Whether the effect shows at all."""

    @property
    def decidable(self) -> bool:
        """Whether no other name does as well."""

    @property
    def fair(self) -> tuple[str, ...]:
        """Names that are right."""

    @property
    def sizes(self) -> dict[str, float]:
        """Peak of each of them."""

    @property
    def true_size(self) -> float | None:
        """Peak of what is concealed."""

    @property
    def rms_full(self) -> float:
        """Held-out error of the full model."""

    @property
    def own_peaks(self) -> dict[str, float]:
        """Peak of each term that the simulation has."""

    @property
    def retuned(self) -> tuple[str, ...]:
        """Terms that were made wrong."""


@dataclass(frozen=True)
class PeerScore:
    """What another method said of the same case; ``fit`` is None where nothing was fitted."""

    names: tuple[str, ...]
    named: bool
    wrong: bool
    silent: bool
    fit: float | None


@dataclass(frozen=True)
class JudgedReal:
    """A case and the answer to it, judged; of one that does not show nothing is asked.

    ``sure``: of each entry that counts, confidence and whether it is right. ``false_name``: the
    same recording without the effect is given its name too; ``false_idle``: and its held-out error
    is as good without (None: not asked). ``idle``: names at 0.9 or more in a null of which that is
    so. ``size_ratio``: of the concealed name.
    """

    name: str
    kind: str
    machine: str
    recording: str
    term: str
    strength: str
    tuning: str
    seen: bool
    decidable: bool
    error: str = ""
    said: tuple[str, ...] = ()
    named: bool = False
    hit: bool = False
    wrong: bool = False
    harm: bool = False
    fit: float | None = None
    size_ratio: float | None = None
    null_ok: bool = False
    own_ok: bool = False
    false_name: bool | None = None
    false_idle: bool | None = None
    sure: tuple[tuple[float, bool], ...] = ()
    idle: tuple[str, ...] = ()
    seconds: float = 0.0
    peers: dict[str, PeerScore] | None = None

    @property
    def asked(self) -> bool:
        """Say whether the command was asked about it."""
        return self.seen

    @property
    def null(self) -> bool:
        """Say whether nothing is concealed."""
        return not self.term


def unjudged(case: KnownCase, recording: str) -> JudgedReal:
    """Return a case of which nothing was asked yet."""
    return JudgedReal(
        case.name, case.kind, case.machine, recording, case.concealed or "", case.strength,
        case.tuning, case.seen, case.decidable,
    )  # fmt: skip


def judged_answer(
    case: KnownCase, recording: str, answer: RealAnswer, twin: RealAnswer
) -> JudgedReal:
    """Judge an answer, beside that to the recording without the effect; `idle` is left open."""
    judged = replace(
        unjudged(case, recording), error=answer.error[:LONGEST_ERROR], seconds=answer.seconds
    )
    if answer.error or answer.before is None or answer.after is None:
        return judged
    harm = answer.after > HARMED * answer.before
    judged = replace(
        judged, harm=harm, fit=answer.after / case.rms_full,
        said=tuple(
            f"{one.term}{'' if one.kind == 'missing' else ' (mistuned)'}:{one.size:.3g}"
            f"({one.confidence:.2f})" for one in answer.entries
        ),
    )  # fmt: skip
    if case.concealed is None:
        own_ok = own_within(case, answer)
        return replace(judged, own_ok=own_ok, null_ok=own_ok and not harm)
    said = [one for one in answer.entries if one.named]
    sizes = [one.size for one in said if one.term == case.concealed]
    true = case.true_size or 1.0
    return replace(
        judged,
        named=is_named(case, said, WITHIN_NAMED),
        hit=is_named(case, said, WITHIN_HIT),
        wrong=is_wrong(case, said),
        size_ratio=sizes[0] / true if sizes else None,
        false_name=None
        if twin.error
        else any(one.named and one.term == case.concealed for one in twin.entries),
        sure=sure_entries(case, answer, twin),
    )


def size_as(entry: SaidEntry, case: KnownCase, within: tuple[float, float]) -> bool:
    """Say whether an entry's size is about that of its name, or of what is concealed."""
    true = {case.sizes[entry.term], case.sizes[case.fair[0]]}
    return any(within[0] * size <= entry.size <= within[1] * size for size in true)


def is_named(case: KnownCase, said: list[SaidEntry], within: tuple[float, float]) -> bool:
    """Say whether a fair name is among what was said, with its size."""
    return any(one.term in case.fair and size_as(one, case, within) for one in said)


def is_wrong(case: KnownCase, said: list[SaidEntry]) -> bool:
    """Say whether nothing fair is said and a sure name carries half of what is concealed."""
    if any(one.term in case.fair for one in said):
        return False
    return any(one.sure and one.size >= CARRIES * (case.true_size or 0.0) for one in said)


def sure_entries(
    case: KnownCase, answer: RealAnswer, twin: RealAnswer
) -> tuple[tuple[float, bool], ...]:
    """Return confidence and rightness of the entries that are sure, of a case with an effect.

    What the same recording without the effect is told as well does not count: it may be there.
    A retuning is right of a term that was made wrong, and does not count where all were refitted.
    """
    also = {(one.term, one.kind) for one in twin.entries}
    found = []
    for one in answer.entries:
        right = one.term in (case.fair if one.kind == "missing" else case.retuned)
        refitted = one.kind == "mistuned" and len(case.retuned) > 1
        if one.sure and not refitted and (right or (one.term, one.kind) not in also):
            found.append((one.confidence, right))
    return tuple(found)


def own_within(case: KnownCase, answer: RealAnswer) -> bool:
    """Say whether no own term is called mistuned by more than RETUNED of its peak.

    Of a term that is smaller than the held-out error, by more than RETUNED of that.
    """
    tuned = [one for one in answer.entries if one.kind == "mistuned"]
    peaks = ((one, case.own_peaks.get(one.term, 0.0)) for one in tuned)
    return all(one.size <= RETUNED * max(peak, case.rms_full) for one, peak in peaks)


def sure_names(answer: RealAnswer) -> tuple[str, ...]:
    """Return the names of the vocabulary that an answer says are missing, at 0.9 or more."""
    return tuple(one.term for one in answer.entries if one.kind == "missing" and one.sure)


def peer_score(case: KnownCase, found: PeerAnswer) -> PeerScore:
    """Judge what another method said: it has no confidence, so each of its names is sure."""
    said = [SaidEntry(term, "missing", 1.0, size) for term, size in found.sizes.items()]
    fit = None if found.held_out is None else found.held_out / case.rms_full
    names = tuple(f"{one.term}:{one.size:.3g}" for one in said)
    if case.concealed is None:
        return PeerScore(names, False, False, not said, fit)
    return PeerScore(names, is_named(case, said, WITHIN_NAMED), is_wrong(case, said), not said, fit)
