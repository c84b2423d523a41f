"""The effects of the vocabulary that cutting forces may hold, each with its ladder of shapes."""

from autodb.explain.cuts.candidates.chip import (
    band_suspects,
    edge_force_suspects,
    size_suspects,
    speed_suspects,
)
from autodb.explain.cuts.candidates.engaged import (
    deflection_suspects,
    depth_suspects,
    nose_suspects,
)
from autodb.explain.cuts.candidates.sensors import drift_suspects, gain_suspects
from autodb.explain.cuts.candidates.warming import warming_suspects
from autodb.explain.cuts.candidates.worn import wear_suspects
from autodb.explain.cuts.table import Stack
from autodb.explain.engine.candidates import Suspect


def named_effects(stack: Stack, own: frozenset[str]) -> list[Suspect]:
    """Return the named effects that a table can tell of; ``own``: terms that are re-tuned."""
    found = [
        *edge_force_suspects(stack, own), *size_suspects(stack), *speed_suspects(stack),
        *band_suspects(stack), *wear_suspects(stack, own), *depth_suspects(stack),
        *nose_suspects(stack), *deflection_suspects(stack), *drift_suspects(stack),
        *gain_suspects(stack), *warming_suspects(stack),
    ]  # fmt: skip
    return [suspect for suspect in found if suspect.rungs]
