"""Codes of inserts and holders: shape, nose, entering angle; names that are none tell nothing."""

import pytest
from numpy.testing import assert_allclose

from autodb.files.tool_sources.designations import geometry_of_code

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
    "A16R-SDUCR 07": (55, None, 93),
    "S40T-PTFNR16": (60, None, 90),
    "S16Q-SDQCR07": (55, None, 107.5),
    "C5-PDUNR-22110-15": (55, None, 93),
    "PTFNR 2525M16": (60, None, None),
    "MTGNR 16-3D": (60, None, 90),
    "CCMT 32.51": (80, 25.4 / 64, None),
    "CCMT 3(2.5)1": (80, 25.4 / 64, None),
    "CCGT 21.50.5": (80, 25.4 / 128, None),
    "TPG 321": (60, 25.4 / 64, None),
    "CNMP 432": (80, 2 * 25.4 / 64, None),
    "RCMT1204M0": (None, 6.0, None),
    "RNGN120700": (None, 6.35, None),
    "RCMX 16 06 00": (None, 8.0, None),
    "PRGCR 2525M12": (None, None, None),
    "T1CNMG120408": (80, 0.8, None),
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


@pytest.mark.parametrize(
    "name",
    ["carbide insert", "ins", "mill D10", "TOOL 1", "face mill", "", "MGMN300-M", "GARANT 202364",
     "16ER 1.5 ISO", "N123H2-0400-0004-GM", "APKT1604PDR", "R390-11T308M-PM", "SER 2525M16",
     "MGEHR 2525-3"],
)  # fmt: skip
def test_a_name_that_is_no_code_tells_nothing(name: str) -> None:
    assert geometry_of_code(name) == {}
