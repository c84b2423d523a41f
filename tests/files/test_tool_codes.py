"""Codes of inserts and holders: shape, nose, entering angle; names that are none tell nothing."""

import pytest
from numpy.testing import assert_allclose

from autodb.files.tool import geometry_of_code

KNOWN = {
    "CNMG120408": (80, 0.8, None),
    "DNMG 15 06 12-PM": (55, 1.2, None),
    "VBMT160404": (35, 0.4, None),
    "WNMG080408-PM 4325": (80, 0.8, None),
    "CCMT09T304": (80, 0.4, None),
    "CNMG 432": (80, 2 * 25.4 / 64, None),
    "PCLNR2525M12": (80, None, 95),
    "PDJNL 2020 K15": (55, None, 93),
    "MTGNR 2525M16": (60, None, 90),
    "S25T-PCLNR 12": (80, None, 95),
    "A16R-SDUCR 07": (55, None, None),
    "C4-PCLNL-27050-12": (80, None, 95),
    "PCLNR 2525M12 / CNMG 120412": (80, 1.2, 95),
}


@pytest.mark.parametrize("code", KNOWN)
def test_a_code_tells_shape_nose_and_entering_angle(code: str) -> None:
    names = ("included_deg", "nose_radius_mm", "kappa_deg")
    expected = {n: v for n, v in zip(names, KNOWN[code], strict=True) if v is not None}
    found = geometry_of_code(code)
    assert found.keys() == expected.keys()
    for name, value in expected.items():
        assert_allclose(found[name], value)


@pytest.mark.parametrize("name", ["carbide insert", "ins", "mill D10", "TOOL 1", "face mill", ""])
def test_a_name_that_is_no_code_tells_nothing(name: str) -> None:
    assert geometry_of_code(name) == {}
