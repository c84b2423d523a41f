"""CSV: comma, one header line, UTF-8."""

from pathlib import Path

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray
from pyarrow import csv

from autodb.errors import UnusableInput
from autodb.readers._arrow import numpy_columns


def read_csv(path: Path) -> dict[str, NDArray[np.generic]]:
    """Read a comma-separated file with a header line."""
    try:
        table = csv.read_csv(path)
        names = table.column_names
    except UnicodeDecodeError:
        raise UnusableInput(f"{path}: the header is not UTF-8; save it as UTF-8") from None
    except (pa.ArrowInvalid, pa.ArrowKeyError) as error:
        reason = str(error).splitlines()[0]
        raise UnusableInput(
            f"{path}: not a comma-separated table in UTF-8 ({reason}); commas between columns, "
            "points in numbers and one header line would work"
        ) from None
    if len(names) == 1 and any(mark in names[0] for mark in ";\t|"):
        raise UnusableInput(
            f"{path}: columns are not separated by commas: '{names[0][:60]}'; commas between "
            "columns and points in numbers would work"
        )
    twice = {n for n in names if names.count(n) > 1}
    if twice:
        raise UnusableInput(f"{path}: column '{min(twice)}' stands in the header twice")
    return numpy_columns(table)
