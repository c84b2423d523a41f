"""What came of a machine's learning that a page began."""

from dataclasses import dataclass

from autodb.agent.learn.passes import RefreshReport


@dataclass(frozen=True)
class MachineLearnt:
    """``report`` of the refresh; before it ``new_calibrations``, None: none was asked for, and
    ``not_calibrated``: sentences why not the other axes.
    """

    report: RefreshReport
    new_calibrations: int | None = None
    not_calibrated: tuple[str, ...] = ()
