"""Numbers as they are typed: a comma or a point, and what could be two numbers is refused."""

import pytest

from autodb.errors import UnusableInput
from autodb.files.units import typed_number


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("0,25", 0.25), ("0.25", 0.25), (" 2,5 ", 2.5), ("−1,5", -1.5), ("-0,125", -0.125),
        ("12,3456", 12.3456), ("1234,5", 1234.5), ("0,250", 0.25), ("1.234", 1.234), ("7", 7.0),
        ("1e-3", 1e-3), (",5", 0.5), ("1234,567", 1234.567),
    ],
)  # fmt: skip
def test_a_comma_is_a_decimal_sign(text: str, value: float) -> None:
    assert typed_number("depth_mm", text) == value


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("1,234", "depth_mm: '1,234' may be 1.234 or 1234; type one of them"),
        ("-12,500", "may be -12.500 or -12500"),
        ("1.234,5", "more than a decimal sign"),
        ("1,234.5", "more than a decimal sign"),
        ("1,234,567", "more than a decimal sign"),
        ("1_000", "is not a number; send a number such as 2.5"),
        ("1 234,5", "is not a number"),
        ("", "is not a number"),
        ("two", "depth_mm: 'two' is not a number"),
    ],
)
def test_what_may_be_two_numbers_is_refused(text: str, said: str) -> None:
    with pytest.raises(UnusableInput) as refused:
        typed_number("depth_mm", text)
    assert said in str(refused.value)
