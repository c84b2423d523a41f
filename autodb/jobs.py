"""Job files (TOML): the cuts of a part that a planner wants forces for."""

from pathlib import Path
from typing import Literal, get_args

from pydantic import Field, model_validator

from autodb.tomlfile import Positive, Section, read_toml

Turning = Literal["turn", "face", "taper", "contour"]
"""Turning operations: along the axis, across it, along a cone, along any profile."""
OPERATIONS: tuple[str, ...] = get_args(Turning)


class JobCut(Section):
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


class Job(Section):
    """A job: machine, material, tool, and its cuts in order."""

    name: str
    material: str
    tool: str
    cut: tuple[JobCut, ...] = Field(min_length=1)


def read_job(path: Path) -> Job:
    """Read and check a job file.

    Raises UnusableInput with file and key.
    """
    return read_toml(path, Job)
