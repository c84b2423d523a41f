"""Read a TOML file into a model; every refusal is one line that names the file and the key."""

import re
import tomllib
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Annotated, Any, TypeVar

from pydantic import BaseModel, ConfigDict, Field, ValidationError, model_validator
from pydantic_core import ErrorDetails

from autodb.errors import UnusableInput, behind_name, near_words, no_such_file
from autodb.wording import listed, localized, phrase

Finite = Annotated[float, Field(strict=True, allow_inf_nan=False)]
NotNegative = Annotated[float, Field(strict=True, ge=0, allow_inf_nan=False)]
Positive = Annotated[float, Field(strict=True, gt=0, allow_inf_nan=False)]


LARGEST_MIB = 1
"""Size of a file. Chosen: files of ours have some kilobytes."""
MOST_MISTAKES = 8
"""That are said of one file."""
DECIMAL_COMMA = re.compile(r"^[^#\"'\n]*=\s*(?P<value>[-+]?\d+,\d+)\s*(?:#.*)?$", re.MULTILINE)
"""A line that states such a number, which TOML takes for two."""
MOST_DOTS = 500
"""On a line: of a key with as many parts the parser takes memory by their square. Chosen."""


class Section(BaseModel):
    """A part of a file: unknown keys are refused, values do not change."""

    model_config = ConfigDict(extra="forbid", frozen=True, defer_build=True)


class ReferenceValue(Section):
    """A reference value with its bounds; where it is from, how sure, and since when."""

    value: Finite
    lower: Finite | None = None
    upper: Finite | None = None
    source: str | None = None
    status: str | None = None
    date: str | None = None

    @model_validator(mode="after")
    def _in_order(self) -> "ReferenceValue":
        low = self.value if self.lower is None else self.lower
        high = self.value if self.upper is None else self.upper
        if not low <= self.value <= high:
            raise ValueError(
                phrase(
                    "value {value} must lie between lower and upper",
                    value=localized(f"{self.value:g}"),
                )
            )
        return self


Model = TypeVar("Model", bound=BaseModel)


def read_toml(path: Path, model: type[Model], *, made_by: str = "", called: str = "") -> Model:
    """Read and check a TOML file.

    ``made_by``: how such a file is made, where there is none; ``called``: what messages call it.
    Raises UnusableInput with file and all keys that are wrong, for an unknown one with near ones.
    """
    where = called or str(path)
    return checked(_parsed(path, where, made_by), model, where=where)


def checked(said: Mapping[str, Any], model: type[Model], *, where: str) -> Model:
    """Return what was said as a model; raises UnusableInput as ``read_toml`` does."""
    try:
        return model.model_validate(said)
    except ValidationError as error:
        raise UnusableInput(behind_name(where, _say(error, model))) from None


def _parsed(path: Path, where: str, made_by: str) -> dict[str, Any]:
    try:
        if path.stat().st_size > LARGEST_MIB * 2**20:
            raise UnusableInput(
                phrase(
                    "{file}: larger than {largest_mib} MiB; use a file of some kilobytes",
                    file=where,
                    largest_mib=LARGEST_MIB,
                )
            )
        text = path.read_text(encoding="utf-8-sig")
        for number, line in enumerate(text.split("\n"), start=1):
            if line.count(".") > MOST_DOTS:
                said = phrase(
                    "line {number} has more than {most_dots} dots; use several lines",
                    number=number,
                    most_dots=MOST_DOTS,
                )
                raise UnusableInput(behind_name(where, said))
        return tomllib.loads(text)
    except FileNotFoundError:
        raise no_such_file(path, made_by) from None
    except IsADirectoryError:
        raise UnusableInput(phrase("{file}: is a folder; give a file in it", file=where)) from None
    except RecursionError:
        raise UnusableInput(
            phrase("{file}: nested too deeply; use a few levels", file=where)
        ) from None
    except (OSError, ValueError) as error:  # also of text, of TOML, of too many digits
        if isinstance(error, tomllib.TOMLDecodeError) and (comma := DECIMAL_COMMA.search(text)):
            said = phrase(
                "line {number}: {value} has a decimal comma; write a decimal point",
                number=text.count("\n", 0, comma.start("value")) + 1,
                value=comma["value"],
            )
            raise UnusableInput(behind_name(where, said)) from None
        raise UnusableInput(
            phrase("{file}: not a readable TOML file ({error})", file=where, error=error)
        ) from None


def _say(error: ValidationError, model: type[BaseModel]) -> str:
    """Return every mistake: the first of each place, and no place that another in it made wrong."""
    schema = model.model_json_schema()
    found = {_place(one): _mistake(one, schema) for one in reversed(error.errors())}
    places = [place for place in reversed(found) if not _holds_another(place, found)]
    said = [found[place] for place in places]
    more = (
        [phrase("{most_mistakes} more mistakes", most_mistakes=len(said) - MOST_MISTAKES)]
        if len(said) > MOST_MISTAKES
        else []
    )
    return listed([*said[:MOST_MISTAKES], *more], "; ")


def _holds_another(place: str, places: Iterable[str]) -> bool:
    return any(other.startswith(f"{place}.") for other in places)


def _place(mistake: ErrorDetails) -> str:
    parts = (part + 1 if isinstance(part, int) else part for part in mistake["loc"])
    return ".".join(map(str, parts))


def _mistake(mistake: ErrorDetails, schema: dict[str, Any]) -> str:
    from autodb.wording.mistakes import mistake_words  # most files have none

    where = _place(mistake)
    if mistake["type"] == "extra_forbidden":
        *section, key = map(str, mistake["loc"])
        return phrase(
            "{where}: unknown key{hint}", where=where, hint=near_words(key, _keys(schema, section))
        )
    if mistake["type"] in {"tuple_type", "list_type"} and isinstance(mistake["input"], dict):
        return phrase("{where}: begin each with [[{where}]], in place of [{where}]", where=where)
    message = mistake_words(mistake)
    return behind_name(where, message) if where else message


def _keys(schema: dict[str, Any], section: Iterable[str]) -> list[str]:
    """Return the keys that a section of a model knows; all of the model's where it is not found."""
    parts = [schema]
    for name in section:
        parts = [inner for part in parts for inner in _inside(part, name, schema)]
    known = {key for part in parts for key in part.get("properties", {})}
    every = [schema, *schema.get("$defs", {}).values()]
    return sorted(known or {key for part in every for key in part.get("properties", {})})


def _inside(part: dict[str, Any], name: str, schema: dict[str, Any]) -> list[dict[str, Any]]:
    """Return what may stand under a name, or at a number, of a part of a schema."""
    held = part.get("properties", {}).get(name) or part.get("items")
    held = held or part.get("additionalProperties")
    return _choices(held, schema) if isinstance(held, dict) else []


def _choices(part: dict[str, Any], schema: dict[str, Any]) -> list[dict[str, Any]]:
    """Return a part of a schema, or those that it refers to."""
    if "$ref" in part:
        return _choices(schema["$defs"][part["$ref"].rsplit("/", 1)[-1]], schema)
    several = part.get("anyOf", part.get("oneOf", []))
    return [one for each in several for one in _choices(each, schema)] if several else [part]
