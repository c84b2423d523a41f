"""Which form an axis' cogging takes: one sine, harmonics of a pole, or a look-up table of it.

P0 (section 2.2) took the table because it was more accurate than a Fourier series. Here blocks of
motion that the terms were not fitted to decide, machine by machine.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from autodb.sensing.drives.fit.held_out import held_out_effort
from autodb.sensing.drives.fit.linearised import linearised
from autodb.sensing.drives.fit.ripples import Ripple
from autodb.sensing.drives.moves.motion import motion_blocks
from autodb.sensing.drives.moves.prepared import Prepared
from autodb.terms.channel import ChannelPart
from autodb.terms.drive import COGGING
from autodb.terms.ripple import COGGING_HARMONICS, COGGING_TABLE, NODES, ORDERS
from autodb.wording import msgid, phrase

Array = NDArray[np.float64]

CLEARLY = 2.0
"""Standard errors over blocks by which a richer form must be better. Chosen."""
MATTERS = 0.05
"""Share by which it must leave less: 35 numbers more are not for a trifle. Chosen."""
CALLED = {
    COGGING.form: msgid("one sine"),
    COGGING_HARMONICS.form: msgid("{orders} harmonics"),
    COGGING_TABLE.form: msgid("a table of {nodes} nodes"),
}


@dataclass(frozen=True)
class TriedCogging:
    """A form of the cogging: its period, what it leaves of blocks left out over the effort's rms,
    and whether it was kept.
    """

    form: str
    period: float
    held_out_error: float
    kept: bool

    @property
    def called(self) -> str:
        """What it is, in words."""
        return phrase(CALLED[self.form], nodes=NODES, orders=ORDERS)


def with_best_cogging(
    rows: Prepared, parts: tuple[ChannelPart, ...], ripple: Ripple
) -> tuple[tuple[ChannelPart, ...], tuple[TriedCogging, ...]]:
    """Return the parts with their one sine in the form to keep, and all forms that were tried.

    The plainest that no richer one clearly beats: a richer one must leave less of the blocks, by
    CLEARLY standard errors and by MATTERS. Where the sine is but a part of the pole, the first is
    enough: it says where nothing repeats. All are fitted around the shape that the parts have.
    """
    sine = next(part for part in parts if part.term is COGGING)
    pole = sine.shape["period"] * ripple.pole / ripple.period
    forms = [
        sine,
        *(
            ChannelPart(term, {"period": pole}, sine.free)
            for term in (COGGING_HARMONICS, COGGING_TABLE)
        ),
    ]
    blocks = motion_blocks(rows.sampled("t"), rows.sampled("direction"))
    models = [tuple(form if part is sine else part for part in parts) for form in forms]
    left = [held_out_effort(rows, linearised(rows, model)) for model in models]
    best = 0
    for k in range(1, len(forms)):
        share = MATTERS if np.isclose(forms[best].shape["period"], pole) else 0.0
        matters = _rms(left[k]) < (1.0 - share) * _rms(left[best])
        if matters and _less(left[k], left[best], blocks) > CLEARLY:
            best = k
    tried = [
        TriedCogging(form.term.form, form.shape["period"], _rms(one) / _rms(rows.effort), False)
        for form, one in zip(forms, left, strict=True)
    ]
    return models[best], _kept(tried, best)


def _rms(values: Array) -> float:
    return float(np.sqrt(np.mean(values**2)))


def _kept(tried: Sequence[TriedCogging], best: int) -> tuple[TriedCogging, ...]:
    return tuple(replace(one, kept=k == best) for k, one in enumerate(tried))


def _less(errors: Array, others: Array, blocks: NDArray[np.intp]) -> float:
    """Return by how many standard errors over blocks the sum of squared errors is less."""
    gain = np.bincount(blocks, others**2 - errors**2)
    spread = float(np.std(gain, ddof=1)) if len(gain) > 1 else np.inf
    return float(np.mean(gain) * np.sqrt(len(gain)) / max(spread, np.finfo(float).tiny))
