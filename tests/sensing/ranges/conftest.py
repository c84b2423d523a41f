"""Calibrations that are made once for the same cuts."""

import numpy as np
import pytest
from numpy.typing import NDArray

from autodb.records.tables import CutTable
from autodb.sensing.ranges import calibration
from autodb.sensing.ranges.forms import LINE
from tests.helpers.lathe_tables import AXES, Array

KEPT: dict[tuple[object, ...], calibration.Calibration] = {}


@pytest.fixture
def calibrated_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """An axis is fitted once for the same cuts, whatever is done to the other axes' currents, and
    by a line alone.

    Which axes are calibrated, and on what, is asked in every test; how well is tested elsewhere.
    """
    calibrate = calibration.calibrate

    def once(
        table: CutTable,
        axis: str,
        *,
        force_N: Array | None = None,
        reference_share: float = 0.0,
        other_way: NDArray[np.bool_] | None = None,
    ) -> calibration.Calibration:
        assert other_way is None, "these tables have one direction"
        others = tuple(f"{other}.current" for other in AXES if other != axis)
        own = {n: v.tobytes() for n, v in table.channels.items() if not n.startswith(others)}
        force = None if force_N is None else force_N.tobytes()
        key = (axis, reference_share, force, *own.items(), str(table.texts))
        if key not in KEPT:
            KEPT[key] = calibrate(table, axis, force_N=force_N, reference_share=reference_share)
        return KEPT[key]

    monkeypatch.setattr(calibration, "calibrate", once)
    monkeypatch.setattr(calibration, "_forms", lambda *_: (LINE,))
