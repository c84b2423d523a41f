"""What mismatches were found in and what was decided of them, in words."""

from collections.abc import Iterable
from typing import Any

from autodb.store import models
from autodb.terms.sensor import GAIN
from autodb.wording import ENGLISH, day, msgid, phrase, presented, stored_msgid

STATES = (msgid("open"), msgid("confirmed"), msgid("rejected"))
"""What a mismatch may be."""
KINDS = (stored_msgid("missing"), stored_msgid("mistuned"))
GAIN_TERM = GAIN.name
SINCE = "since"
"""Of what a drifted gain was found in: the recording, by id, from which on an axis reads so."""

NEW_EDGE = "new_edge"
"""Of what an edge change was inferred in: the first cut, by id, that a new edge made."""
IN_BAND, IN_HARDER = "in_band", "harder"
"""Of what a band of speeds, and harder work, were inferred in: their cuts, by id."""

LINES = {
    ("", ""): stored_msgid("mismatch {number}: {channel}: {term} ({kind})"),
    ("in", ""): stored_msgid("mismatch {number}: {channel}: {term} ({kind}), in {found}"),
    ("said", ""): stored_msgid("mismatch {number}: {channel}: {term} ({kind}): {said}"),
    ("", "now"): stored_msgid("mismatch {number}: now {channel}: {term} ({kind})"),
    ("in", "now"): stored_msgid("mismatch {number}: now {channel}: {term} ({kind}), in {found}"),
    ("said", "now"): stored_msgid("mismatch {number}: now {channel}: {term} ({kind}): {said}"),
}
"""What a refresh says of a mismatch, by what is said besides, and of one that was there before."""
FOUND = stored_msgid("{cuts} cuts of {count} recordings, {excluded} excluded")
ON_EDGES = stored_msgid("{cuts} cuts of {count} recordings, {excluded} excluded, edges {edges}")
ON_EDGE = stored_msgid("{cuts} cuts of {count} recordings, {excluded} excluded, edge {edges}")
RECORDINGS = stored_msgid("{count} recordings")


def mismatch_line(row: models.Mismatch, *, again: bool, said: str = "") -> str:
    """Return a mismatch as a refresh says it; ``said``: its statement, where that is to be there.

    ``again``: it was there before.
    """
    with presented(ENGLISH):  # it is stored
        found = "" if said else found_words(row)
    kind = "said" if said else "in" if found else ""
    return LINES[kind, "now" if again else ""].format(
        number=row.id, channel=row.channel, term=row.term, kind=row.kind, found=found, said=said
    )


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
        return "" if recordings == 1 else phrase(RECORDINGS, count=recordings)
    edges = found["edges"]
    sentence = FOUND if not edges else ON_EDGE if len(edges) == 1 else ON_EDGES
    return phrase(
        sentence,
        cuts=found["cuts"],
        count=recordings,
        excluded=found["excluded"],
        **({"edges": ", ".join(edges)} if edges else {}),
    )


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


def recordings_of(causes: Iterable[models.Mismatch]) -> set[int]:
    """Return the recordings, by id, that mismatches were found in."""
    return {one.id for row in causes for one in row.recordings}


def around(value: float, half: float, unit: str) -> dict[str, Any]:
    """Return a parameter of a mismatch as it is stored: a value, and so far to both sides of it."""
    return {"value": value, "low": value - half, "high": value + half, "unit": unit}
