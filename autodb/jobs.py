"""Job files (TOML): the cuts of a part that a planner wants forces for."""

import tomllib
from pathlib import Path
from typing import Annotated, Literal, get_args

from pydantic import BaseModel, ConfigDict, Field, ValidationError, model_validator

from autodb.errors import UnusableInput

Turning = Literal["turn", "face", "taper", "contour"]
"""Turning operations: along the axis, across it, along a cone, along any profile."""
OPERATIONS: tuple[str, ...] = get_args(Turning)

Positive = Annotated[float, Field(gt=0, allow_inf_nan=False)]


class _Section(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)


class JobCut(_Section):
    """One turning cut; give the spindle speed or the cutting speed.

    ``diameter_mm`` is the machined diameter at the tool tip; ``depth_mm`` lies across the feed.
    """

    name: str = ""
    operation: Turning = "turn"
    diameter_mm: Positive
    depth_mm: Positive
    feed_mm_rev: Positive
    speed_rpm: Positive | None = None
    speed_m_min: Positive | None = None

    @model_validator(mode="after")
    def _one_speed(self) -> "JobCut":
        if (self.speed_rpm is None) == (self.speed_m_min is None):
            raise ValueError("give either speed_rpm or speed_m_min, and only one of them")
        return self


class Job(_Section):
    """A job: machine, material, tool, and its cuts in order."""

    name: str
    material: str
    tool: str
    cut: tuple[JobCut, ...] = Field(min_length=1)


def read_job(path: Path) -> Job:
    """Read and check a job file.

    Raises UnusableInput with file and key.
    """
    try:
        raw = tomllib.loads(path.read_text(encoding="utf-8"))
        return Job.model_validate(raw)
    except FileNotFoundError:
        raise UnusableInput(f"{path}: no such file") from None
    except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
        raise UnusableInput(f"{path}: not a readable TOML file ({error})") from None
    except ValidationError as error:
        first = error.errors()[0]
        where = ".".join(str(part + 1 if isinstance(part, int) else part) for part in first["loc"])
        message = first["msg"].removeprefix("Value error, ")
        raise UnusableInput(f"{path}: {where}: {message}") from None
