"""Fitted cutting coefficients as a file (JSON): each tool by its ISO 13399 property codes.

ISO 13399 has codes for what a tool is, none for what a machine has learnt of cutting with it. So
the tool is what the codes say, and the coefficients stand beside it under our names, with units and
95 % bounds. ``format`` counts changes that a reader would notice.
"""

import json
from pathlib import Path
from typing import Literal

from pydantic import Field, ValidationError

from autodb.errors import UnusableInput, behind_name
from autodb.files.toml import Finite, Section
from autodb.files.tool import Geometry, ToolKind
from autodb.wording import phrase


class BoundedValue(Section):
    """A value with its 95 % bounds."""

    value: Finite
    lower: Finite
    upper: Finite
    unit: str


class ToolCoefficients(Section):
    """A tool: ``iso13399`` by property code, in mm and degrees; ``geometry`` what has none here."""

    name: str
    kind: ToolKind | None = None
    iso13399: dict[str, Finite] = Field(default_factory=dict)
    geometry: Geometry = Geometry()


class CutsBehind(Section):
    """Cuts behind the coefficients: how many, their operations, lowest and highest of a channel."""

    cuts: int
    operations: list[str]
    ranges: dict[str, tuple[Finite, Finite]] = Field(default_factory=dict)


class OrthogonalEdge(Section):
    """Coefficients of an orthogonal edge of this normal rake, at a speed, over a range of chips.

    ``linear``: K_tc, K_te, K_rc, K_re of F = K_c h + K_e; ``kienzle``: k_c1.1 and m_c; empty where
    k_c grows with the chip.
    """

    rake_deg: Finite
    speed_m_min: Finite
    thinnest_mm: Finite
    thickest_mm: Finite
    linear: dict[str, BoundedValue]
    kienzle: dict[str, BoundedValue]


class LawCoefficients(Section):
    """The law's numbers as a normal posterior: mean (p,), covariance (p, p) of their coordinates.

    ``coordinates``: ``plain`` is the number in its unit, ``ln`` its logarithm, ``ln tan`` that of
    an angle's tangent.
    """

    name: str
    numbers: list[str]
    units: list[str]
    coordinates: list[Literal["plain", "ln", "ln tan"]]
    mean: list[Finite]
    covariance: list[list[Finite]]


class PairCoefficients(Section):
    """What a machine has learnt of a work-tool pair; ``version`` is its own count."""

    material: str
    tool: ToolCoefficients
    version: int
    learnt_at: str
    learnt_from: CutsBehind
    orthogonal_edge: OrthogonalEdge
    law: LawCoefficients


class Coefficients(Section):
    """The file: who wrote it, of which machine, and its pairs."""

    format: Literal[1] = 1
    autodb: str
    written_at: str
    machine: str
    pairs: list[PairCoefficients]


def read_coefficients(path: Path) -> Coefficients:
    """Read a file of coefficients; raises UnusableInput with file and key."""
    try:
        return Coefficients.model_validate(json.loads(path.read_text(encoding="utf-8")))
    except (json.JSONDecodeError, UnicodeDecodeError) as error:
        raise UnusableInput(
            phrase("{file}: is no JSON ({error})", file=path, error=error)
        ) from None
    except ValidationError as error:
        from autodb.wording.mistakes import mistake_words

        first = error.errors()[0]
        where = ".".join(str(one) for one in first["loc"])
        raise UnusableInput(behind_name(path, behind_name(where, mistake_words(first)))) from None
