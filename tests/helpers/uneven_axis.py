"""An axis of four symmetric terms, and friction that is uneven by direction: the truth is here."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray
from pyarrow import csv

from autodb.agent.rows.machines import find_machine
from autodb.agent.sense.identifying import newest_model, stored_terms
from autodb.store import models, open_store
from tests.conftest import Cli
from tests.helpers.trapezoids import COULOMB, INERTIA, NOISE, VISCOUS, WEIGHT, moves

Array = NDArray[np.float64]
LEVEL, SLOPE = 0.06, 4e-4
URL = "sqlite:///autodb.sqlite3"
FORCE = "x.drive_force"
Refused = Callable[..., str]


def uneven_effort(channels: dict[str, Array], seed: int, *, uneven: float = 1.0) -> Array:
    """Return the current of the four terms, and of friction that is uneven by direction, (n,)."""
    v, a = channels["x.velocity"], channels["x.acceleration"]
    sense = np.clip(v / 0.05, -1.0, 1.0)
    noise = np.random.default_rng([seed, 2]).normal(0, NOISE, len(v))
    own = COULOMB * sense + VISCOUS * v + INERTIA * a + WEIGHT
    return own + uneven * (LEVEL * np.abs(sense) + SLOPE * np.abs(v)) + noise


def write_uneven(name: str, seed: int, **truth: float) -> Path:
    channels = moves(seed)
    csv.write_csv(pa.table({**channels, "x.current": uneven_effort(channels, seed, **truth)}), name)
    return Path(name)


def stored_version(version: int, channel: str = "x.current") -> list[Any]:
    store = open_store(URL)
    with store.reading() as session:
        row = newest_model(session, find_machine(session, "mill").id, channel)
        assert row is not None
        assert row.version == version
        terms = stored_terms(row)
    store.close()
    return terms


def keep_mismatch(recording: Path, cli: Cli, term: str, **columns: Any) -> int:
    """Keep a cause as explain would, and return its number."""
    cli("import", recording, "--machine", "mill")
    store = open_store(URL)
    with store.writing() as session:
        named = session.query(models.StoredRecording).filter(
            models.StoredRecording.path.endswith(recording.name)
        )
        row = models.Mismatch(
            **{
                "recording_id": named.one().id, "channel": "x.current", "term": term,
                "kind": "missing", "confidence": 0.9, "parameters": {}, "statement": "It differs.",
                "alternatives": [], **columns,
            }
        )  # fmt: skip
        session.add(row)
        session.flush()
        number = row.id
    store.close()
    return number
