"""A fit of an axis' parts around their shape, and its parameters by name."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from autodb.fitting.deviation import Deviating
from autodb.sensing.drives.fit.axis_model import ChangedParameter, IdentifiedTerm, unit_in
from autodb.sensing.drives.fit.linearised import Linearised
from autodb.sensing.drives.fit.steady import Deviation
from autodb.sensing.drives.moves.prepared import Prepared
from autodb.terms.channel import ChannelPart
from autodb.terms.term import TermParameter

Array = NDArray[np.float64]
Name = tuple[ChannelPart, TermParameter]


@dataclass(frozen=True)
class Solved:
    """A fit around a shape: ``values`` (p,) and ``covariance`` (p, p) of ``problem.names``;
    ``weights`` (m,) of the deviation's columns.
    """

    problem: Linearised
    fit: Deviating
    deviation: Deviation | None
    values: Array
    covariance: Array
    weights: Array
    moved: tuple[ChangedParameter, ...] = ()

    @property
    def off_law_sds(self) -> Array | None:
        """Sizes (groups,) of what friction is off its laws by; None where it is not."""
        return self.fit.sds[: len(self.deviation.groups)] if self.deviation else None

    def weights_with(self, values: Array) -> Array:
        """Return the deviation's weights (m,), given other ``values`` (p,) of the law.

        By what the rows say of both together: that blocks widen a coefficient's sd moves no other.
        """
        p, covariance = self.fit.columns, self.fit.narrow_covariance
        own = covariance[:p, :p]
        scale = np.sqrt(np.diag(own))
        unit = own / np.outer(scale, scale)
        change = (values - self.values) / scale
        pushed = np.linalg.lstsq(unit, change, rcond=1e-12)[0] / scale
        whole = covariance[p : p + len(self.weights), :p]
        return np.asarray(self.weights + whole @ pushed)


def identified_term(name: Name, value: float, sd: float | None, rows: Prepared) -> IdentifiedTerm:
    """Return a parameter with its value and sd, as a model keeps it."""
    part, parameter = name
    return IdentifiedTerm(
        term=part.term.name,
        parameter=parameter.name,
        value=float(value),
        sd=sd,
        unit=unit_in(parameter, rows.unit, rows.axis),
        form=part.term.form,
        of=part.of,
    )


def given_shape(parts: tuple[ChannelPart, ...], rows: Prepared) -> list[IdentifiedTerm]:
    """Return the shape parameters that were taken as given."""
    return [
        identified_term((part, p), part.shape[p.name], 0.0, rows)
        for part in parts
        for p in part.term.shape
        if p.name not in part.free
    ]
