"""Jobs in words, as sheets say what was asked."""

from typing import Any

import pytest

from autodb.files.job import Job
from autodb.files.job_words import KINDS, TOOL_FIELDS, job_in_words
from autodb.files.units import INCH, shop_units
from autodb.wording import Presentation, presented

BAR = {"stock_diameter_mm": 60.0, "stock_face_mm": 1.0, "bore_diameter_mm": 20.0}
BLANK = {"stock": [[-50, 60], [-20, 60], [-20, 40], [0, 40]]}
PLATE = {
    "block_mm": [0, 100, 0, 60, -20.5, 0],
    "tools": {
        "3": {"kind": "end_mill", "diameter_mm": 10, "teeth": 4, "offset_mm": 0},
        "other": {"kind": "drill", "diameter_mm": 6.8},
    },
}


def _said(program: dict[str, Any]) -> list[str]:
    job = {"name": "a", "material": "b", "tool": "c", "program": {"file": "p.nc"} | program}
    return list(job_in_words(Job.model_validate(job)))


@pytest.mark.parametrize(
    ("program", "said"),
    [
        (
            BAR | {"control": "fanuc-a", "feeds": "minute", "diameter": False},
            [
                "a bar: diameter 60 mm, face at z = 1 mm, bored to 20 mm",
                "read as: fanuc-a, X in radii, F a minute",
            ],
        ),
        (
            BAR | {"tools": {"5": {"kind": "grooving", "width_mm": 3}}},
            [
                "a bar: diameter 60 mm, face at z = 1 mm, bored to 20 mm",
                "tool 5: grooving, parting, blade 3 mm wide, its corner towards the chuck is "
                "programmed",
            ],
        ),
        (BLANK, ["a blank: z -50 mm to 0 mm, diameter up to 60 mm"]),
        (
            PLATE,
            [
                "a block: x 0 mm to 100 mm, y 0 mm to 60 mm, z -20.5 mm to 0 mm",
                "tool 3: end mill, diameter 10 mm, 4 teeth, offset 0 mm",
                "all other tools: drill, diameter 6.8 mm",
            ],
        ),
    ],
)
def test_a_program_is_asked_with_what_it_meets(program: dict[str, Any], said: list[str]) -> None:
    assert _said(program) == ["program p.nc", *said]


def test_a_program_in_another_language_and_units() -> None:
    with presented(Presentation("de", shop_units(INCH))):
        said = _said({"stock_diameter_mm": 63.5})
    assert said[1:] == ["eine Stange: Durchmesser 2,5 in, Planfläche bei z = 0 in"]


def test_a_form_has_every_field_that_a_kind_has() -> None:
    known = {one.key for one in TOOL_FIELDS} | {"corner"}
    assert {key for _words, keys in KINDS.values() for key in keys} == known
