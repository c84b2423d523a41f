"""What a request asks of a cut, from its query or from a line, as a job file would say it."""

from collections.abc import Callable, Mapping
from typing import Any

from pydantic import ValidationError

from autodb.errors import UnusableInput, near
from autodb.files.job_cut import JobCut
from autodb.files.units import typed_number
from autodb.web.http.problems import first_of
from autodb.wording import listed, phrase

TEXTS = ("name", "operation")
PAIR = ("material", "tool")
LOT = "lot"
EXAMPLES = {
    "name": "rough", "operation": "turn", "diameter_mm": 50.0, "depth_mm": 2.0,
    "feed_mm_rev": 0.25, "speed_m_min": 220.0,
}  # fmt: skip


def pair_of(query: Mapping[str, str]) -> tuple[str, str]:
    """Return the material and the tool that a query names; raises UnusableInput."""
    lacking = [name for name in PAIR if not query.get(name)]
    if lacking:
        raise UnusableInput(
            phrase("{keys}: missing; send both of a pair", keys=listed(lacking, phrase(" and ")))
        )
    return query["material"], query["tool"]


def cut_of_query(query: Mapping[str, str]) -> JobCut:
    """Return the cut that a query states, beside the pair; raises UnusableInput."""
    stated: dict[str, str] = {}
    for name, text in query.items():
        if name in (*PAIR, LOT):
            continue
        if name not in JobCut.model_fields:
            raise UnusableInput(f"{name}: no key of a cut{near(name, JobCut.model_fields)}")
        stated[name] = text
    return as_cut(stated)


def as_cut(stated: Mapping[str, str], number: Callable[[str, str], float] = typed_number) -> JobCut:
    """Return the cut that texts state by key; raises UnusableInput naming the key.

    ``number`` reads one, of which the key is said.
    """
    read = {name: text if name in TEXTS else number(name, text) for name, text in stated.items()}
    try:
        return JobCut.model_validate(read)
    except ValidationError as error:
        raise UnusableInput(first_of(error.errors())) from None


def read_cut(line: bytes) -> JobCut:
    """Return the cut that a line of JSON states; raises UnusableInput naming the key."""
    try:
        return JobCut.model_validate_json(line)
    except ValidationError as error:
        raise UnusableInput(first_of(error.errors())) from None


def parameters_of_a_cut() -> list[dict[str, Any]]:
    """Return how a route's document names the query of a look-up."""
    shapes = JobCut.model_json_schema()["properties"]
    made = [
        {"name": "material", "in": "query", "required": True, "schema": {"type": "string"},
         "description": "Work material.", "example": "C45"},
        {"name": "tool", "in": "query", "required": True, "schema": {"type": "string"},
         "description": "Name of the tool.", "example": "CNMG 120408"},
        {"name": LOT, "in": "query", "required": False, "schema": {"type": "string"},
         "description": "Lot of the material: a bar, a heat."},
    ]  # fmt: skip
    for name, shape in shapes.items():
        of_text = _of_text(shape)
        one: dict[str, Any] = {"name": name, "in": "query", "required": False, "schema": of_text}
        if name in EXAMPLES:
            one["example"] = EXAMPLES[name]
        made.append(one)
    return made


def _of_text(shape: dict[str, Any]) -> dict[str, Any]:
    """Return the shape of a value that a query gives or leaves out: it has no word for null."""
    if "anyOf" not in shape:
        return shape
    (said,) = (one for one in shape["anyOf"] if one != {"type": "null"})
    return {"title": shape["title"], **said}
