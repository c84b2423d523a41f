"""What plain rows are made from, of a course of time or of a table."""

from collections.abc import Mapping, Sequence
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from autodb.explain.engine.candidates import CandidateForm, Choice

Array = NDArray[np.float64]


class RowsSource(Protocol):
    """Where plain rows come from: a difference (m,), own columns, and those of candidates' forms.

    ``own`` terms by name, with the coefficients ``own_sizes`` in the simulation; ``gap``: rows over
    which noise is correlated; ``progress`` (n,): the share of the course that lies behind each row
    as recorded, None: of the rows.
    """

    gap: int
    progress: Array | None
    own_sizes: Array

    @property
    def own(self) -> Mapping[str, object]:
        """The simulation's own terms."""

    @property
    def reduced_difference(self) -> Array:
        """The difference, (m,)."""

    def chosen(self, choices: Sequence[Choice]) -> Array:
        """Return own and chosen columns, (m, p)."""

    def columns(self, key: tuple[str, int], form: CandidateForm) -> Array:
        """Return a form's columns, (m, p)."""
