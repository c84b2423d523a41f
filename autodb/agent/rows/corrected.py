"""A calibration whose gain is off since some cut, corrected by the factor that a person confirmed.

What is sensed from that cut on is divided by the factor: value, error of the cut alone, and what
the coefficients' errors move. The factor's own error is shared by all of these cuts.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

from autodb.sensing.ranges.chosen import SensedCut
from autodb.store import models


def is_after(correction: Mapping[str, Any], cut: models.Cut) -> bool:
    """Say whether a cut is one of those that a correction is of."""
    since = correction["recording"], correction["t_s"]
    return (cut.recording_id, float(cut.conditions.get("t", 0.0))) >= since


def corrected(
    current: Sequence[models.CalibrationVersion], cut: models.Cut, read: SensedCut
) -> SensedCut:
    """Return what one of an axis' calibrations sensed of a cut, as its corrections have it."""
    if read.by is None or read.force_N is None:
        return read
    by = [one for one in current[read.by].corrections or () if is_after(one, cut)]
    for one in by:
        factor = one["factor"]
        assert read.force_N is not None
        assert read.sd_N is not None
        read = replace(
            read,
            force_N=read.force_N / factor,
            sd_N=read.sd_N / factor,
            common=[value / factor for value in read.common or ()],
        )
    return read
