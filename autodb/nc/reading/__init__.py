"""Turning programs read: the moves of the tool, with feed, speed and the line they stand on."""

from autodb.nc.reading.paths import (
    Arc,
    CuttingSpeed,
    Feed,
    FeedPerMinute,
    Linear,
    Move,
    PerRev,
    Point,
    Rapid,
    Revolutions,
    Speed,
)
from autodb.nc.reading.turning_program import (
    TurningProgram,
    line_texts,
    program_text,
    read_program,
    turning_program,
)

__all__ = [
    "Arc",
    "CuttingSpeed",
    "Feed",
    "FeedPerMinute",
    "Linear",
    "Move",
    "PerRev",
    "Point",
    "Rapid",
    "Revolutions",
    "Speed",
    "TurningProgram",
    "line_texts",
    "program_text",
    "read_program",
    "turning_program",
]
