"""By which noise the rows of the final fit are weighed: the one found, or none.

White rows give the least uncertain coefficients of laws that are exact. Where laws are not, white
rows weigh most what is fast, where the laws are wrong (friction as it turns), and their levels
follow that. Plain rows are less certain but follow what is large. So coefficients of both are
compared: further apart than both are uncertain, they say that the laws are not exact, and the plain
ones are taken. Source: Hausman 1978, Specification tests in econometrics.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from autodb.explain.engine.bench import WhiteRows
from autodb.explain.engine.candidates import Choice
from autodb.explain.engine.noise import Noise, Whitener
from autodb.explain.engine.normal import normal

Array = NDArray[np.float64]

APART_SDS = 3.0
"""Standard deviations of the difference from which on coefficients are further apart than chance
makes them."""


def weighing(
    bench: WhiteRows,
    choices: Sequence[Choice],
    noise: Noise,
    *,
    of: Choice | None = None,
    own: bool = False,
) -> Noise:
    """Return the noise by which rows are weighed for the coefficients of plain laws.

    ``of``: the choice whose coefficients count, None: of all; ``own``: those of the bench's own
    terms count, too, of which some are laws that were found.
    """
    counted = _places(bench, choices, of)
    if own:
        counted = np.concatenate([np.arange(bench.firm), counted])
    plain = unweighed(noise)
    columns, difference = bench.chosen(choices), bench.reduced_difference
    white, variance = _least_squares(columns, difference, noise)
    robust, its_variance = _least_squares(columns, difference, plain)
    sd = np.sqrt(np.maximum(its_variance - variance, 0.0))
    apart = np.abs(white - robust) > np.maximum(APART_SDS * sd, np.sqrt(its_variance))
    return plain if np.any(apart[counted] & (sd[counted] > 0)) else noise


def unweighed(noise: Noise) -> Noise:
    """Return the noise that leaves rows as they are, with the variance that slow noise has.

    It is that of a row times what its slow correlation adds, which is safe for slow columns.
    """
    whitener, variance = noise
    return Whitener(np.zeros(0)), variance / float(whitener.power(np.zeros(1))[0])


def _places(bench: WhiteRows, choices: Sequence[Choice], of: Choice | None) -> NDArray[np.intp]:
    """Return the places of the plain laws' coefficients among those of own and chosen columns."""
    widths = [bench.columns(c.key, c.shape).shape[1] for c in choices]
    counts = np.repeat([of in (None, c) and bool(c.shape.names) for c in choices], widths)
    return len(bench.own) + np.flatnonzero(counts.astype(bool))


def _least_squares(columns: Array, difference: Array, noise: Noise) -> tuple[Array, Array]:
    """Return coefficients (p,) and their variances (p,)."""
    whitener, variance = noise
    equations = normal(whitener(columns), whitener(difference))
    inverse = equations.inverse()
    return np.asarray(inverse @ equations.right), np.asarray(variance * np.diag(inverse))
