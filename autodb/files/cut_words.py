"""Cuts as they are asked for, in words: what a form calls their numbers, and one line of each."""

from collections.abc import Iterator
from dataclasses import dataclass

from autodb.files.job import Job, JobCut


@dataclass(frozen=True)
class FormField:
    """A number of a cut in a form: its key, what it is called, and its unit."""

    key: str
    called: str
    unit: str


FIELDS = (
    FormField("diameter_mm", "Diameter", "mm"),
    FormField("end_diameter_mm", "End diameter", "mm"),
    FormField("length_mm", "Length", "mm"),
    FormField("depth_mm", "Depth", "mm"),
    FormField("width_mm", "Width", "mm"),
    FormField("feed_mm_rev", "Feed", "mm/rev"),
    FormField("feed_mm_tooth", "Feed", "mm/tooth"),
    FormField("speed_m_min", "Cutting speed", "m/min"),
    FormField("speed_rpm", "or spindle speed", "rpm"),
    FormField("direction_deg", "Direction", "deg"),
    FormField("ramp_deg", "Ramp", "deg"),
    FormField("pocket_diameter_mm", "Pocket", "mm"),
    FormField("cutting_time_s", "Edge has cut", "s"),
    FormField("flank_wear_mm", "Flank wear", "mm"),
)


def cut_in_words(cut: JobCut) -> str:
    """Return a cut in one line."""
    stated = ((one, getattr(cut, one.key)) for one in FIELDS)
    said = [
        f"{one.called.removeprefix('or ').lower()} {value:g} {one.unit}"
        for one, value in stated
        if value is not None
    ]
    return ", ".join([cut.operation, *said])


def job_in_words(job: Job) -> Iterator[str]:
    """Yield what a job asks for, a line a cut, or one of its program."""
    for number, cut in enumerate(job.cut, start=1):
        yield f"{cut.name or f'cut {number}'}: {cut_in_words(cut)}"
    if job.program is not None:
        yield f"program {job.program.file}"
