"""Libraries of the extra `formats`, imported when a file needs them."""

from importlib import import_module
from pathlib import Path
from typing import Any

from autodb.errors import UnusableInput


def library(path: Path, name: str) -> Any:
    """Return module ``name``; raises UnusableInput saying how to install it."""
    try:
        return import_module(name)
    except ImportError:
        raise UnusableInput(
            f"{path}: reading {path.suffix} needs {name}; \"pip install 'autodb[formats]'\" would "
            "work, or CSV and Parquet without it"
        ) from None
