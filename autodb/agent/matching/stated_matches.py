"""Cuts are matched with a prediction by a person's word, and whatever is open is tried again."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from sqlalchemy import delete, func, select
from sqlalchemy.orm import Session

from autodb.agent.matching.asked_jobs import AskedCuts, as_made
from autodb.agent.matching.made_cuts import Link, Matched, linked, match_new
from autodb.agent.matching.taken_by_cuts import offered_calibrations, take_forces
from autodb.agent.rows.machines import find_machine
from autodb.errors import NotThere, UnusableInput, near_words
from autodb.forward.matching import matched
from autodb.store import Also, Store, models, nothing_else
from autodb.store.models.answers import BY_STATEMENT
from autodb.wording import listed, phrase


@dataclass(frozen=True)
class MatchedCut:
    """A cut of a recording, and which cut of which predicted job it is."""

    recording: int
    cut: float
    prediction: int
    job: str
    name: str
    matched_by: str


@dataclass(frozen=True)
class MatchedCuts:
    """The cuts that were linked; ``asked``: in words, what is not sure."""

    cuts: tuple[MatchedCut, ...]
    asked: tuple[str, ...]


def _shown(found: Matched) -> MatchedCuts:
    """Return what was linked, for when the session is closed."""
    return MatchedCuts(
        tuple(
            MatchedCut(
                link.cut.recording_id,
                link.cut.number,
                link.prediction_id,
                link.prediction.job["name"],
                link.name,
                link.matched_by,
            )
            for link in found.links
        ),
        tuple(found.asked),
    )


def match_open(store: Store, machine: str) -> MatchedCuts:
    """Link what can be of all cuts of a machine that are not linked; raises NotThere without it."""
    with store.writing(machine) as session:
        owner = find_machine(session, machine)
        newest = session.scalar(select(func.max(models.Cut.id))) or 0
        found = match_new(session, owner, after=0, upto=newest)
        if found.links:
            take_forces(session, found.links, offered_calibrations(session, owner))
        return _shown(found)


def match_stated(
    store: Store,
    machine: str,
    recording: int,
    prediction: int,
    names: Mapping[float, str],
    *,
    also: Also = nothing_else,
) -> MatchedCuts:
    """Link a recording's cuts with a prediction that they are said to be of.

    ``names``: by number of a cut, which one it is; the others are told by what they say, and by
    their conditions and order. ``also``: what else is written then.

    Raises NotThere for an unknown recording or prediction, UnusableInput for a cut that is neither
    in the recording nor in the job, one that the prediction had learnt, and where none fits.
    """
    with store.writing(machine) as session:
        owner = find_machine(session, machine)
        cuts = _cuts(session, owner, recording)
        asked = _asked(session, owner, prediction)
        _refuse_unknown(asked, cuts, names, recording)
        found = _link(session, asked, cuts, names)
        if not found.links:
            raise UnusableInput(
                phrase(
                    "no cut of recording {recording} fits one of prediction {prediction}; say "
                    "which they are with --cut NUMBER=NAME{names}",
                    recording=recording,
                    prediction=prediction,
                    names=_named(asked),
                )
            )
        take_forces(session, found.links, offered_calibrations(session, owner))
        also(session, recording)
        return _shown(found)


def _cuts(session: Session, owner: models.Machine, recording: int) -> list[models.Cut]:
    row = session.get(models.StoredRecording, recording)
    if row is None or row.machine_id != owner.id:
        raise NotThere(
            phrase(
                "machine '{name}' has no recording {recording}",
                name=owner.name,
                recording=recording,
            )
        )
    cuts = [cut for cut in row.cuts if cut.superseded_at is None]
    if not cuts:
        raise UnusableInput(
            phrase("recording {recording} has no cut that counts", recording=recording)
        )
    return cuts


def _asked(session: Session, owner: models.Machine, prediction: int) -> AskedCuts:
    row = session.get(models.Prediction, prediction)
    if row is None or row.machine_id != owner.id:
        raise NotThere(
            phrase(
                "machine '{name}' has no prediction {prediction}",
                name=owner.name,
                prediction=prediction,
            )
        )
    return AskedCuts(session, prediction)


def _refuse_unknown(
    asked: AskedCuts, cuts: Sequence[models.Cut], names: Mapping[float, str], recording: int
) -> None:
    numbers = {cut.number: cut for cut in cuts}
    for number, name in names.items():
        if number not in numbers:
            raise UnusableInput(
                phrase(
                    "--cut {number}={name}: recording {recording} has no such cut",
                    number=f"{number:g}",
                    name=name,
                    recording=recording,
                )
            )
        (match,) = matched(asked.cuts, [as_made(numbers[number], called=name)])
        if not match.places:
            raise UnusableInput(
                phrase(
                    "--cut {number}={name}: prediction {id} has no cut '{name}'{names}",
                    number=f"{number:g}",
                    name=name,
                    id=asked.row.id,
                    names=_named(asked, name),
                )
            )


def _named(asked: AskedCuts, name: str = "") -> str:
    return near_words(name, [asked.called(place) for place in range(len(asked.cuts))])


def _link(
    session: Session, asked: AskedCuts, cuts: Sequence[models.Cut], names: Mapping[float, str]
) -> Matched:
    """Link the cuts whose place is sure, in place of links that they have."""
    matches = matched(asked.cuts, [as_made(cut, called=names.get(cut.number)) for cut in cuts])
    sure = [(cut, m.place) for cut, m in zip(cuts, matches, strict=True) if m.place is not None]
    ids = [cut.id for cut, _ in sure]
    knew = asked.knew(ids)
    if knew:
        numbers = ", ".join(f"{cut.number:g}" for cut, _ in sure if cut.id in knew)
        raise UnusableInput(
            phrase(
                "prediction {id} had learnt cut {numbers} already: it says nothing of how good "
                "predictions are; use one that was made before",
                id=asked.row.id,
                numbers=numbers,
            )
        )
    session.execute(delete(Link).where(Link.cut_id.in_(ids)))
    found = Matched([linked(session, asked, k, cut, by=BY_STATEMENT) for cut, k in sure])
    session.flush()
    for cut, match in zip(cuts, matches, strict=True):
        if len(match.places) > 1:
            may_be = (f"'{asked.called(place)}'" for place in match.places)
            said = phrase(
                "cut {number} may be {names}: add --cut {number}=NAME",
                number=f"{cut.number:g}",
                names=listed(may_be, phrase(" or ")),
            )
            found.asked.append(said)
    return found
