"""What mismatches were found in and what was decided of them, in words."""

from autodb.store import models
from autodb.terms.sensor import GAIN
from autodb.wording import day, listed, msgid, phrase, phrase_many

STATES = (msgid("open"), msgid("confirmed"), msgid("rejected"))
"""What a mismatch may be."""
KINDS = (msgid("missing"), msgid("mistuned"))
GAIN_TERM = GAIN.name
SINCE = "since"
"""Of what a drifted gain was found in: the recording, by id, from which on an axis reads so."""

NEW_EDGE = "new_edge"
"""Of what an edge change was inferred in: the first cut, by id, that a new edge made."""


def is_of_axis(row: models.Mismatch) -> bool:
    """Say whether a mismatch is of what senses a force, and of no pair: its gain has drifted."""
    return row.found_in is not None and SINCE in row.found_in


def is_cause(row: models.Mismatch) -> bool:
    """Say whether a mismatch may be why cuts are excluded: no drifted gain, and no new edge."""
    return row.found_in is None or not {SINCE, NEW_EDGE} & row.found_in.keys()


def found_words(row: models.Mismatch) -> str:
    """Return in how many cuts, recordings and edges a mismatch was found; empty: in one recording.

    Of one that was found in several recordings before these were counted only their number is said.
    """
    recordings = len(row.recordings)
    found = row.found_in
    if recordings == 1 or found is None:
        return "" if recordings == 1 else phrase("{count} recordings", count=recordings)
    said = phrase(
        "{cuts} cuts of {count} recordings, {excluded} excluded",
        cuts=found["cuts"],
        count=recordings,
        excluded=found["excluded"],
    )
    edges = found["edges"]
    if not edges:
        return said
    names = ", ".join(edges)
    on = phrase_many("edge {edges}", "edges {edges}", len(edges), edges=names)
    return listed([said, on])


def decision_words(row: models.MismatchDecision) -> str:
    """Return a decision as a line: what, by whom, when and why."""
    status = {"open": msgid("reopened")}.get(row.status, row.status)
    what = decided_words(status, row.term, row.decided_by)
    said = phrase("{decided} on {day}", decided=what, day=day(row.decided_at))
    return phrase("{said}: {why}", said=said, why=row.why) if row.why else said


def decided_words(status: str, term: str | None, by: str | None) -> str:
    """Return what was decided, as which term and by whom, as far as that is known."""
    said = phrase(status)
    if term:
        said = phrase("{decided} as {term}", decided=said, term=term)
    return phrase("{decided} by {who}", decided=said, who=by) if by else said
