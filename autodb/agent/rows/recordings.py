"""What stored recordings state of themselves."""

from datetime import UTC, datetime

from autodb.store import models


def stated_start(row: models.StoredRecording) -> datetime | None:
    """Return when a recording began, as its side file states; None: it does not, or not so that
    it is read. A start without an offset is this computer's.
    """
    said = row.side.get("recording", {}).get("start")
    try:
        return datetime.fromisoformat(said).astimezone(UTC) if said else None
    except (ValueError, OverflowError):
        return None
