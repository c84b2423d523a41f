"""Shapes of candidates whose columns are there already."""

from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from autodb.explain.engine.candidates import CandidateForm

Array = NDArray[np.float64]


def form(columns: Array, shape: Mapping[str, float] | None = None, **options: Any) -> CandidateForm:
    """Return a shape of columns (C, n, p), with what is known of it by name."""
    return CandidateForm(keep_shape(columns), shape or {}, **options)


def keep_shape(columns: Array) -> Callable[..., Array]:
    """Return a function that gives columns, whatever their shape is called."""
    return partial(_as_is, columns)


def _as_is(columns: Array, **shape: float) -> Array:
    del shape
    return columns


def shape_columns(shape: CandidateForm) -> Array:
    """Return a shape's columns (C, n, p)."""
    return np.asarray(shape.law(**shape.shape))
