"""Job files (TOML): the cuts of a part that a planner wants forces for."""

from pathlib import Path
from typing import Literal, get_args

from pydantic import Field, model_validator

from autodb.tomlfile import NotNegative, Positive, Section, read_toml

Turning = Literal["turn", "face", "taper", "contour"]
"""Turning operations: along the axis, across it, along a cone, along any profile."""
OPERATIONS: tuple[str, ...] = get_args(Turning)


class JobCut(Section):
    """One turning cut; give the spindle speed or the cutting speed.

    ``diameter_mm`` is the machined diameter at the tool tip, ``end_diameter_mm`` the one at the end
    of a cut whose radius changes; ``depth_mm`` lies across the feed.
    """

    name: str = ""
    operation: Turning = "turn"
    diameter_mm: Positive
    end_diameter_mm: NotNegative | None = None
    depth_mm: Positive
    feed_mm_rev: Positive
    speed_rpm: Positive | None = None
    speed_m_min: Positive | None = None

    @property
    def largest_diameter_mm(self) -> float:
        """The larger of the diameters at its start and end."""
        return max(self.diameter_mm, self.end_diameter_mm or 0.0)

    @model_validator(mode="after")
    def _turning_keeps_its_diameter(self) -> "JobCut":
        if self.operation == "turn" and self.end_diameter_mm is not None:
            raise ValueError(
                "operation 'turn' keeps its diameter; 'face', 'taper' or 'contour' would work "
                "with end_diameter_mm"
            )
        return self

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
