"""Libraries of the extra `formats`, imported when a file needs them."""

import logging
from importlib import import_module
from pathlib import Path
from typing import Any

from autodb.errors import UnusableInput


def library(path: Path, name: str) -> Any:
    """Return module ``name``; raises UnusableInput saying how to install it.

    What it would log of a damaged file is left to the one line that we say of it.
    """
    try:
        found = import_module(name)
    except ImportError:
        raise UnusableInput(
            f"{path}: reading {path.suffix} needs {name}; \"pip install 'autodb[formats]'\" would "
            "work, or CSV and Parquet without it"
        ) from None
    for logger in logging.root.manager.loggerDict:
        if logger.split(".")[0] == name:
            logging.getLogger(logger).setLevel(logging.CRITICAL + 1)
    return found
