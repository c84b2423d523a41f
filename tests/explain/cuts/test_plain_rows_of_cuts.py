"""The cuts of a table as plain rows."""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from autodb.explain.cuts.candidates.library import of_forces
from autodb.explain.cuts.cut_search import stack_of
from autodb.explain.cuts.plain_rows import TableRows
from autodb.records.tables import CutTable

Array = NDArray[np.float64]


def test_rows_hold_the_components_of_a_cut_together_over_their_scatter() -> None:
    rng = np.random.default_rng(1)
    n, forces = 12, ("force.x", "force.y")
    known = {
        "cut": np.arange(1.0, n + 1), "cutting.feed": rng.uniform(0.1, 0.4, n),
        "cutting.depth": rng.uniform(0.5, 2.0, n),
    }  # fmt: skip
    recorded = {name: rng.uniform(100.0, 200.0, n) for name in forces}
    stack = stack_of(
        CutTable(Path("cuts.csv"), {**known, **recorded}),
        {name: values - 5.0 for name, values in recorded.items()},
        ["shear"],
    )
    rows = TableRows(stack, of_forces(["shear"]).own(stack))
    difference: Array = (stack.recording - stack.simulation) / stack.sd
    assert rows.reduced_difference.tolist() == difference.T.ravel().tolist()
    chip: Array = rows.chosen(())
    assert chip.shape == (2 * n, 2)
    assert np.count_nonzero(chip[0::2, 1]) == np.count_nonzero(chip[1::2, 0]) == 0
