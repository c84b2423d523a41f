"""Text in tables is calculated by no spreadsheet, and comes back as it was."""

import csv
import io

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from autodb.files.csvtext import FORMULA, neutral, restored, rows_as_csv

TEXTS = st.text(st.sampled_from("'=+-@\t\r\n＝,;\"1.eC45 ")) | st.text()


@given(TEXTS)
def test_a_cell_comes_back_as_it_was(text: str) -> None:
    assert restored(neutral(text)) == text


@given(st.lists(st.lists(TEXTS, min_size=2), min_size=1))
def test_no_cell_of_a_table_begins_as_a_formula(rows: list[list[str]]) -> None:
    """Whatever breaks lines or cells in it stays within its own."""
    again = list(csv.reader(io.StringIO(rows_as_csv(rows), newline="")))
    assert [[restored(cell) for cell in row] for row in again] == rows
    begin = [cell for row in again for cell in row if cell.startswith(tuple(FORMULA))]
    assert np.array(begin, dtype=np.float64).size == len(begin)  # numbers all of them


@pytest.mark.parametrize("number", ["-3.5", "+1", "1e-07", "-1.5e+03", "-inf", "nan", "-.5"])
def test_numbers_stay_numbers(number: str) -> None:
    assert neutral(number) == number


@pytest.mark.parametrize("text", ["-1+1", "-1_0", "+x", "-", "-1 ", "－1", "-٣"])
def test_what_only_looks_like_a_number_is_none(text: str) -> None:
    assert neutral(text) == f"'{text}"
