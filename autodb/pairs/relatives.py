"""Where a tool starts on a material that a machine has cut with several others.

Each pair's own cuts say something of the material and of its tool (``autodb.pairs.hierarchy``); the
errors of the machine's calibrations are in all of them alike. So the material's numbers are worked
out as if there were none of these errors, θ_0, and the errors δ are put back as the first pair has
them, θ = θ_0 + G δ with G its regression of the law on them: neither several tools nor many cuts
make a force surer than the gain.
"""

from collections.abc import Mapping

import numpy as np

from autodb.fitting import Gaussian
from autodb.pairs.hierarchy import InformationOfCuts, KnownMaterial
from autodb.pairs.posterior import OWN, PairPosterior
from autodb.pairs.prior import of_relative


def of_relatives(
    first: PairPosterior, start: Gaussian, own_cuts: Mapping[str, InformationOfCuts], tool: str
) -> PairPosterior:
    """Return what pairs of one material say of it with another tool.

    ``first``: one of them, with the errors of all calibrations that sensed any; ``start``: what was
    known of the law before any was cut; ``own_cuts``: what each tool's cuts say as if these errors
    were none.
    """
    known = KnownMaterial(start)
    for name, information in own_cuts.items():
        known = known.changed(name, more=information)
    law, relative = known.pair(tool), of_relative(first)
    mean, covariance = relative.state.mean.copy(), relative.state.covariance.copy()
    errors = slice(OWN, len(mean))
    regression = covariance[:OWN, errors] @ np.linalg.pinv(covariance[errors, errors])
    mean[:OWN] = law.mean + regression @ mean[errors]
    covariance[:OWN, :OWN] = law.covariance + regression @ covariance[errors, :OWN]
    return PairPosterior(
        Gaussian(mean, covariance), relative.shared, first.scatter, 0, first.off_law
    )
