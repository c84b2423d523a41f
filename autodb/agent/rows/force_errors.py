"""Errors of measured forces, as rows keep them and as a pair's posterior shares them."""

from autodb.pairs.posterior import DAY, GAIN
from autodb.sensing.dynamometer import ForceError
from autodb.store import models


def errors_of(row: models.SensedForce) -> list[ForceError]:
    """Return the errors of a measured force."""
    return [ForceError(**one) for one in row.errors or ()]


def shared_key(error: ForceError, recording: int) -> str:
    """Return the key under which a pair's posterior keeps an error that forces share."""
    return (
        f"{DAY} of {error.of}, recording {recording}" if error.passing else f"{GAIN} of {error.of}"
    )
