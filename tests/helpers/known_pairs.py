"""A posterior of a pair to a share of what any metal may have, and an insert."""

from dataclasses import replace

from autodb.fitting.gaussian import Gaussian
from autodb.forward.prediction import ToolOf
from autodb.pairs.posterior import PairPosterior
from autodb.pairs.prior import any_metal

INSERT = ToolOf(
    "insert",
    {
        "nose_radius_mm": 0.8, "kappa_deg": 93.0, "rake_deg": -6.0, "inclination_deg": -6.0,
        "included_deg": 55.0,
    },
)  # fmt: skip


def known(share: float = 0.1) -> PairPosterior:
    """Return any metal's numbers, known a share as far."""
    posterior = any_metal()
    return replace(
        posterior, state=Gaussian(posterior.state.mean, share**2 * posterior.state.covariance)
    )
