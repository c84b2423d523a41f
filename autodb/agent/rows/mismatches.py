"""What mismatches were found in and what was decided of them, in words."""

from autodb.store import models
from autodb.terms.sensor import GAIN

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
        return "" if recordings == 1 else f"{recordings} recordings"
    edges = found["edges"]
    on = f", edge{'s' if len(edges) > 1 else ''} {', '.join(edges)}" if edges else ""
    return f"{found['cuts']} cuts of {recordings} recordings, {found['excluded']} excluded{on}"


def decision_words(row: models.MismatchDecision) -> str:
    """Return a decision as a line: what, by whom, when and why."""
    what = {"open": "reopened"}.get(row.status, row.status)
    called = f" as {row.term}" if row.term else ""
    by = f" by {row.decided_by}" if row.decided_by else ""
    why = f": {row.why}" if row.why else ""
    return f"{what}{called}{by} on {row.decided_at}{why}"
