"""Standard cuts: a protocol is data, its reference forces stand in for a dynamometer.

A reference is a value with lower and upper 95 % bounds and its source; the bounds are an error that
every cut sensed with the calibration shares. Source of the idea: P1 section 9.
"""

import tomllib
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, Field, PositiveFloat, PositiveInt, ValidationError

from autodb.assets import kit
from autodb.errors import UnusableInput, near
from autodb.records import CutTable

Array = NDArray[np.float64]

MATCH = 0.03
"""Relative difference of speed, feed and depth up to which a cut counts as a standard cut."""


class _Section(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)


class Reference(_Section):
    """A reference force, N, with 95 % bounds; where it is from, how sure, and since when."""

    value: float
    lower: float
    upper: float
    source: str
    status: str
    date: str


class StandardCut(_Section):
    """One cut of a protocol. ``reference`` has the components that were measured."""

    name: str
    operation: str
    speed_rpm: PositiveFloat
    feed_mm_rev: PositiveFloat
    depth_mm: PositiveFloat
    repeats: PositiveInt
    reference: dict[str, Reference] = Field(default_factory=dict)


class Protocol(_Section):
    """A list of standard cuts on one work-tool pair."""

    name: str
    material: str
    tool: str
    note: str = ""
    cut: tuple[StandardCut, ...]


@dataclass(frozen=True)
class References:
    """Reference force of each row (NaN: none) and the relative sd that all of them share."""

    force_N: Array
    share: float


def read_protocol(name: str) -> Protocol:
    """Read a protocol by name from the calibration kit, or from a file.

    Raises UnusableInput naming the protocols that ship.
    """
    path = Path(name)
    if path.suffix != ".toml":
        path = kit("calibration") / f"{name}.toml"
    try:
        return Protocol.model_validate(tomllib.loads(path.read_text(encoding="utf-8")))
    except FileNotFoundError:
        shipped = [p.stem for p in kit("calibration").glob("*.toml")]
        raise UnusableInput(f"no protocol '{name}'{near(name, shipped)}") from None
    except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
        raise UnusableInput(f"{path}: not a readable TOML file ({error})") from None
    except ValidationError as error:
        first = error.errors()[0]
        where = ".".join(str(part + 1 if isinstance(part, int) else part) for part in first["loc"])
        raise UnusableInput(f"{path}: {where}: {first['msg']}") from None


def references(table: CutTable, protocol: Protocol, component: str) -> References:
    """Return the reference force of every row that is a standard cut of the protocol.

    Raises UnusableInput when no row is one, or none of those has a reference.
    """
    force = np.full(len(table), np.nan)
    shares: list[float] = []
    matched = 0
    for cut in protocol.cut:
        rows = _is_cut(table, cut)
        matched += int(rows.sum())
        reference = cut.reference.get(component)
        if reference is not None and rows.any():
            force[rows] = reference.value
            shares.append((reference.upper - reference.lower) / 3.92 / abs(reference.value))
    if not matched:
        raise UnusableInput(f"{table.path}: no row is a standard cut of '{protocol.name}'")
    if not shares:
        raise UnusableInput(
            f"protocol '{protocol.name}': no reference for force.{component} yet; "
            "measure its cuts once with a dynamometer"
        )
    return References(force, float(np.mean(shares)))


def _is_cut(table: CutTable, cut: StandardCut) -> NDArray[np.bool_]:
    operations = table.texts.get("operation", [cut.operation] * len(table))
    same = np.array([operation == cut.operation for operation in operations])
    for channel, value in (
        ("spindle.speed", cut.speed_rpm),
        ("cutting.feed", cut.feed_mm_rev),
        ("cutting.depth", cut.depth_mm),
    ):
        same &= np.abs(table[channel] / value - 1.0) < MATCH
    return same
