"""Drawn layouts of text: separator, marks, encoding, lines above, units, blanks; read as written.

`AUTODB_MUTATIONS=50` draws fifty times as many.
"""

import os
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose
from numpy.typing import NDArray

from autodb.readers import open_bases

DRAWS = 48 * int(os.environ.get("AUTODB_MUTATIONS", "1"))
SEED = 3901
ABOVE = (
    "Machine: lathe 4",
    "Datum 26.11.2026",
    "# made by hand on a Thursday in November at half past nine",
    "",
    "Sample rate 500 Hz",
    "Kanal 1",
)
UNITS = ("s", "mm", "[A]", "(kN)", "mm/s", "V")


@dataclass(frozen=True)
class Drawn:
    """A text, and what stands in it."""

    text: bytes
    names: list[str]
    values: NDArray[np.float64]


def _cell(value: float, digits: int, mark: str, *, exponent: bool) -> str:
    text = f"{value:.9e}" if exponent else f"{value:.{digits}f}"
    return "" if np.isnan(value) else text.replace(".", mark)


def _drawn(rng: np.random.Generator) -> Drawn:
    separator = str(rng.choice([",", ";", "\t", "|", " ", "   "]))
    mark = "." if separator == "," else str(rng.choice([".", ","]))
    rows, columns = int(rng.choice([4, 12, 90, 3000])), int(rng.integers(2, 8))
    digits = rng.integers(0, 5, columns)
    scales = 10.0 ** rng.uniform(-2, 4, columns)
    values = np.column_stack(
        [np.round(rng.normal(0.0, s, rows), d) for s, d in zip(scales, digits, strict=True)]
    )
    values[:, 0] = np.arange(rows) * 0.25
    digits[0] = 2
    if separator.strip() and rng.random() < 0.3:
        values[1:-1, 1:][rng.random((rows - 2, columns - 1)) < 0.3] = np.nan
    header = rng.random() < 0.85
    above = [str(rng.choice(ABOVE)) for _ in range(int(rng.choice([0, 0, 1, 4])))]
    lines = [*above, ""] if above else []
    names = [f"{rng.choice(['Zeit', 'Kraft', 'I_Z', 'speed'])}{k}" for k in range(columns)]
    if header:
        lines.append(separator.join(names))
        if rng.random() < 0.4:
            lines.append(separator.join(str(rng.choice(UNITS)) for _ in names))
    lines += [
        separator.join(
            _cell(v, d, mark, exponent=rng.random() < 0.05)
            for v, d in zip(row, digits, strict=True)
        )
        for row in values.tolist()
    ]
    ending = str(rng.choice(["\n", "\r\n"]))
    text = ending.join(lines) + (ending if rng.random() < 0.8 else "")
    encoding = str(rng.choice(["utf-8", "utf-8-sig", "cp1252", "utf-16"]))
    counted = [f"column {k + 1}" for k in range(columns)]
    return Drawn(text.encode(encoding), names if header else counted, values)


@pytest.mark.parametrize("part", range(4))
def test_a_drawn_layout_is_read_as_it_was_written(tmp_path: Path, part: int) -> None:
    rng = np.random.default_rng([SEED, part])
    path = tmp_path / "a.txt"
    for _ in range(DRAWS // 4):
        drawn = _drawn(rng)
        path.write_bytes(drawn.text)
        (base,) = open_bases(path)
        said = f"{base.layout}: {drawn.text[:300]!r}"
        assert list(base.columns) == drawn.names, said
        read = base.read(drawn.names)
        found = np.column_stack([np.asarray(read[name], np.float64) for name in drawn.names])
        assert_allclose(found, drawn.values, rtol=1e-8, atol=1e-9, err_msg=said)
