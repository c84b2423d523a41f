"""Columns of every edge, projected out edge by edge, against the same columns written out."""

from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose
from numpy.typing import NDArray

from autodb.explain.cuts.cut_search import look_in_cuts, stack_of
from autodb.explain.cuts.scatter import OfEdges, of_edges, over_range, residual, with_noise
from autodb.explain.cuts.stack import Conditions, table_conditions
from autodb.records.tables import CutTable

Array = NDArray[np.float64]

COUNT, EDGES = 240, 6
SHEAR = ["shear"]


def _table(seed: int) -> dict[str, Array]:
    """Return cuts of six edges in turn; those of the third are all of one depth and feed."""
    rng = np.random.default_rng(seed)
    edge = np.arange(COUNT) * EDGES // COUNT
    begun_s = np.cumsum(rng.uniform(5.0, 25.0, COUNT))
    first = np.searchsorted(edge, edge)
    depth, feed = rng.choice([0.5, 1.0, 2.0], COUNT), rng.choice([0.1, 0.2, 0.3], COUNT)
    depth[edge == 2], feed[edge == 2] = 1.0, 0.2
    return {
        "cut": np.arange(COUNT) + 1.0, "t": begun_s, "cutting.feed": feed,
        "cutting.depth": depth, "tool.edge": edge + 1.0,
        "tool.cutting_time": begun_s - begun_s[first] + rng.uniform(1.0, 9.0, COUNT),
    }  # fmt: skip


def _force(table: dict[str, Array]) -> Array:
    depth = table["cutting.depth"]
    return np.asarray(2000.0 * depth * table["cutting.feed"] + 40.0 * depth)


def _worn(table: dict[str, Array]) -> Array:
    rate = 0.05 * (1.0 + 0.3 * np.sin(2.0 * np.arange(EDGES)))
    edge = np.arange(COUNT) * EDGES // COUNT
    return np.asarray(rate[edge] * table["cutting.depth"] * table["tool.cutting_time"])


def _known(table: dict[str, Array]) -> Conditions:
    return table_conditions(CutTable(Path("cuts"), {**table, "force.y": _force(table)}))


def _written(known: Conditions, force: Array, most: int) -> Array:
    """Return the columns of edges written out, (n, ``most``)."""
    assert known.cutting_time_s is not None
    risen = over_range(known.cutting_time_s)
    made = [
        (known.edge == edge) * risen * scale
        for edge in known.edges[1:]
        for scale in (force, known.depth_mm)
    ]
    return np.column_stack(made[:most])


def _fitted(matrix: Array, difference: Array, sd: Array) -> tuple[Array, Array, int]:
    """Return what a fit of a whole matrix leaves, its leverages, and its rank."""
    whole = matrix / sd[:, None]
    basis, size, _ = np.linalg.svd(whole / np.linalg.norm(whole, axis=0), full_matrices=False)
    basis = basis[:, size > 1e-12]
    fitted = basis @ (basis.T @ (difference / sd))
    return difference - sd * fitted, np.sum(basis**2, axis=1), basis.shape[1]


@pytest.mark.parametrize("most", [3, 100])
def test_projection_edge_by_edge_is_that_of_columns_written_out(most: int) -> None:
    """One column is there twice, one is that of an edge, and one edge has a single kind of cut."""
    table, rng = _table(1), np.random.default_rng(2)
    known, force = _known(table), _force(table)
    sd = np.hypot(6.0, 0.02 * force)
    written = _written(known, force, most)
    design = np.column_stack([force, known.depth_mm, rng.normal(size=COUNT), written[:, 1], force])
    difference = sd * rng.normal(size=COUNT)
    left, leverage = residual(
        design, of_edges(known, (force, known.depth_mm), most), difference, sd
    )
    expected, expected_leverage, rank = _fitted(np.column_stack([design, written]), difference, sd)
    assert rank == {3: 6, 100: 12}[most]  # of edges 3; or 10 less that of the single kind
    assert_allclose(left, expected, atol=1e-9)
    assert_allclose(leverage, expected_leverage, atol=1e-9)


def test_columns_that_nearly_depend_on_each_other_count_wherever_they_stand() -> None:
    """Two columns that differ by 1e-9 span two directions, also where one is that of an edge."""
    table, rng = _table(3), np.random.default_rng(4)
    known, force = _known(table), _force(table)
    ones, written = np.ones(COUNT), _written(known, force, 2)
    apart = rng.normal(size=COUNT) * (known.edge == 2.0)
    beside = written[:, 0] / np.linalg.norm(written[:, 0]) + 1e-9 * apart
    edges = of_edges(known, (force, known.depth_mm), 2)
    none = OfEdges(edges.edge, np.zeros((COUNT, 2)))
    difference = apart + written @ [0.02, 3.0]
    for design, of in (
        (np.column_stack([ones, beside]), edges),
        (np.column_stack([ones, beside, written]), none),
    ):
        left, leverage = residual(design, of, difference, ones)
        assert_allclose(left, 0.0, atol=1e-5)
        assert_allclose(leverage.sum(), 4.0, rtol=1e-6)


def test_names_of_edges_do_not_matter() -> None:
    """The answer is one whichever edge is called the first."""
    table = _table(5)
    force, rng = _force(table), np.random.default_rng(6)
    sensed: Array = force + _worn(table) + np.hypot(6.0, 0.02 * force) * rng.normal(size=COUNT)
    found = []
    for names in ([1.0, 2.0, 3.0, 4.0, 5.0, 6.0], [5.0, 3.0, 6.0, 1.0, 2.0, 4.0]):
        edge: Array = np.repeat(names, COUNT // EDGES)
        recording = CutTable(Path("cuts"), {**table, "tool.edge": edge, "force.y": sensed})
        stack = stack_of(recording, {"force.y": force}, SHEAR)
        seen, freedom = with_noise(stack)
        result = look_in_cuts(stack, SHEAR)
        found.append((seen.sd, freedom, result.stack.sd, result.found))
    (sd, freedom, last, one), (other_sd, other_freedom, other_last, other) = found
    assert_allclose(other_freedom, freedom, rtol=1e-9)
    assert_allclose(other_sd, sd, rtol=1e-9)
    assert_allclose(other_last, last, rtol=1e-6)
    assert one.keys == other.keys
    assert "tool_wear" in one.keys
    assert_allclose(other.score, one.score, rtol=1e-6)
