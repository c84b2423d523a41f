"""Which other names are fair in a component: those that alone explain about as much."""

import numpy as np

from autodb.proofs.cases.real.held_out import fitted_sizes
from autodb.proofs.cases.real.rival_names import AS_GOOD, TAKEN
from autodb.proofs.cases.tables.published_tables import Array
from autodb.proofs.cases.tables.table_columns import (
    COMMON,
    OF_ONE_COMPONENT,
    TABLE_NAMES,
    ModelledComponent,
    shapes_of,
)
from autodb.proofs.cases.tables.table_models import (
    PublishedModel,
    held_out_beside,
    mixed_held_out,
)


def rival_laws(
    concealed: str, refitted: PublishedModel, name: str, force: Array, rms_full: float
) -> dict[str, float]:
    """Return the other names that are fair, with the peak (N) of what each then contributes.

    ``refitted`` is the simulation's own laws on the forces as they are. Where components are
    several, what a sensor does is no rival of what a cut does, nor the other way round.
    """
    channel = ModelledComponent(refitted, name)
    before = mixed_held_out(channel.model.columns, force)
    most = min(AS_GOOD * rms_full, np.sqrt(max(before**2 - TAKEN * (before**2 - rms_full**2), 0.0)))
    found = {}
    for other in names_beside(concealed, single=len(refitted.channels) == 1):
        if other in refitted.terms:
            continue
        error, peak = best_of_law(other, channel, force)
        if error <= most:
            found[other] = peak
    return found


def names_beside(concealed: str, *, single: bool) -> tuple[str, ...]:
    """Return the names that can stand in the place of one."""
    own = OF_ONE_COMPONENT if concealed in OF_ONE_COMPONENT else COMMON
    return tuple(name for name in (TABLE_NAMES if single else own) if name != concealed)


def best_of_law(name: str, channel: ModelledComponent, force: Array) -> tuple[float, float]:
    """Return held-out error and peak of a name beside the own laws, at its best shape."""
    shapes = shapes_of(name, channel)
    own = channel.model.columns
    errors = held_out_beside(own, shapes, force)
    if not len(errors):
        return np.inf, 0.0
    best = int(np.argmin(errors))
    sizes = fitted_sizes(np.concatenate([own, shapes[best]]), force)[len(own) :]
    return float(errors[best]), float(np.max(np.abs(sizes @ shapes[best])))
