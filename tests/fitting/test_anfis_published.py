"""Sugeno systems on published examples."""

import numpy as np

from autodb.fitting import anfis
from benchmarks.anfis import cube, three_inputs


def test_jangs_protocol_reaches_his_errors_of_three_inputs() -> None:
    """Jang 1993, example 2: 0.043 % of the training rows, 1.066 % of the check rows."""
    train, check = cube(np.arange(1.0, 7.0)), cube(np.arange(1.5, 6.0))
    model = anfis.fit_anfis(
        train, three_inputs(train), [anfis.premise_grid((2, 2, 2))], learner=anfis.Hybrid(200)
    )
    for cut, published in ((train, 0.00043), (check, 0.01066)):
        off = anfis.evaluate(model, cut) / three_inputs(cut) - 1.0
        assert np.mean(np.abs(off)) <= published
