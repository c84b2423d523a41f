"""Units of a shop: what they are by definition, and there and back again."""

import numpy as np
import pytest

from autodb.files.channels import OUR_UNITS
from autodb.files.units import INCH, SI, shop_units, shown_system
from autodb.wording import Presentation, amount_words, presented, shop_amount

LBF_N = 0.45359237 * 9.80665
"""International avoirdupois pound times standard gravity."""
INCH_MM = 25.4
BY_DEFINITION = {
    "N": ("lbf", LBF_N),
    "mm": ("in", INCH_MM),
    "mm/rev": ("in/rev", INCH_MM),
    "mm/tooth": ("in/tooth", INCH_MM),
    "mm/min": ("in/min", INCH_MM),
    "m/min": ("ft/min", 12.0 * INCH_MM / 1000.0),
    "N·m": ("ft·lbf", 12.0 * INCH_MM / 1000.0 * LBF_N),
    "W": ("hp", 550.0 * 12.0 * INCH_MM / 1000.0 * LBF_N),
    "N/mm²": ("ksi", 1000.0 * LBF_N / INCH_MM**2),
    "N/mm": ("lbf/in", LBF_N / INCH_MM),
    "cm³": ("in³", (INCH_MM / 10.0) ** 3),
    "cm³/min": ("in³/min", (INCH_MM / 10.0) ** 3),
    "N/A": ("lbf/A", LBF_N),
    "N·m/A": ("ft·lbf/A", 12.0 * INCH_MM / 1000.0 * LBF_N),
}
"""Unit of the shop by ours, and how many of ours it is, by its definition (NIST SP 811)."""


@pytest.mark.parametrize("ours", BY_DEFINITION)
def test_a_unit_is_what_its_definition_says(ours: str) -> None:
    name, factor = BY_DEFINITION[ours]
    found = shop_units(INCH)[ours]
    assert found.name == name
    np.testing.assert_allclose(1.0 / found.factor, factor, rtol=1e-12)


def test_there_and_back_again_nothing_is_lost() -> None:
    value = 1234.5678
    for ours, unit in shop_units(INCH).items():
        with presented(Presentation(units=shop_units(INCH))):
            shown, name = shop_amount(value, ours)
        assert name == unit.name
        np.testing.assert_allclose(shown / unit.factor, value, rtol=1e-15)


def test_what_has_no_unit_of_the_shop_stays() -> None:
    with presented(Presentation(units=shop_units(INCH))):
        assert shown_system() == INCH
        assert amount_words(900.0, "N") == "202.328 lbf"
        for stays in ("rpm", "deg", "s", "A", "°C", "1"):
            assert shop_amount(3.0, stays) == (3.0, stays)
        unknown = [one for one in OUR_UNITS if "mm" in one and shop_amount(1.0, one)[1] == one]
        assert unknown == [], "lengths that stay in mm on an inch page"
    assert (shown_system(), shop_units(SI)) == (SI, {})
