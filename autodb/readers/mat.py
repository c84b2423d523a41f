"""MATLAB v5: n×1 and 1×n arrays are channels, scalars and the rest are ignored."""

import contextlib
import faulthandler
import os
import warnings
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from autodb.errors import UnusableInput


def read_mat(path: Path) -> dict[str, NDArray[np.generic]]:
    """Read the numeric vectors of a MAT file; they must share one length."""
    from scipy.io import loadmat

    if not _survives(path):
        raise UnusableInput(f"{path}: not a whole MAT file (its parts do not fit together)")
    try:
        variables = loadmat(path)
    except NotImplementedError:
        raise UnusableInput(f"{path}: MAT v7.3 (HDF5); save it with '-v7'") from None
    except MemoryError:
        raise UnusableInput(f"{path}: not a whole MAT file (it claims impossible sizes)") from None
    except Exception as error:  # a broken file makes SciPy's parser fail in any way
        raise UnusableInput(f"{path}: not a whole MAT file ({error})") from None
    columns: dict[str, NDArray[np.generic]] = {
        name: np.asarray(value, dtype=np.float64).ravel()
        for name, value in variables.items()
        if isinstance(value, np.ndarray) and value.dtype.kind in "fiu" and max(value.shape) > 1
        if sum(n > 1 for n in value.shape) == 1
    }
    lengths = {name: len(value) for name, value in columns.items()}
    if len(set(lengths.values())) > 1:
        raise UnusableInput(f"{path}: vectors of different lengths share no table: {lengths}")
    return columns


def _survives(path: Path) -> bool:
    """Read the file in a forked child first: a damaged one can crash SciPy's parser outright."""
    from scipy.io import loadmat

    if not hasattr(os, "fork"):
        return True
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)  # the child only reads and leaves
        child = os.fork()
    if child == 0:
        with contextlib.suppress(BaseException):
            faulthandler.disable()  # a crash is no news to the user
            os.dup2(os.open(os.devnull, os.O_WRONLY), 2)
            loadmat(path)
        os._exit(0)
    return os.waitpid(child, 0)[1] == 0
