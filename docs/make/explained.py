"""What `explain` can name, read off the candidates that it builds."""

from functools import cache
from pathlib import Path

import numpy as np

from autodb.explain.axis.look import AxisField
from autodb.explain.axis.signals import axis_signals
from autodb.explain.cuts.candidates.effect_parameters import READ
from autodb.explain.engine.bench import WhiteRows
from autodb.explain.engine.noise import Whitener
from autodb.explain.waves.answers import STATEMENTS
from autodb.records.tables import Recording

RATE_HZ = 50.0
LASTS_S = 60.0
LOADED_S = (20.0, 30.0)


@cache
def names() -> frozenset[str]:
    """Return the terms that explain can name as missing: of an axis, of cuts, of a mill."""
    return frozenset({*axis_names(), *READ, *STATEMENTS})


def axis_names() -> frozenset[str]:
    """Return the terms of the candidates of an axis that moves to and fro beside another."""
    recording = _moves()
    signals = axis_signals(recording, recording["x.current"], "x.current")
    inside = (recording.t_s > LOADED_S[0]) & (recording.t_s < LOADED_S[1])
    left = np.where(inside, 1.0, 0.0)
    field = AxisField(signals, WhiteRows(left, {}, 1))
    none = np.empty((len(left), 0))
    candidates = [*field.standing(), *field.scanned(none, Whitener(np.zeros(1)), 0)]
    return frozenset(candidate.term for candidate in candidates if candidate.named)


def _moves() -> Recording:
    """Return a recording in which everything is excited that a candidate needs."""
    t_s = np.arange(0.0, LASTS_S, 1.0 / RATE_HZ)
    channels = {
        "t": t_s,
        "x.position": 100.0 * np.sin(t_s),
        "y.position": 80.0 * np.sin(0.7 * t_s),
        "x.current": np.clip(1.5 * np.cos(t_s), -1.0, 1.0),
    }
    return Recording(path=Path("moves.csv"), channels=channels)
