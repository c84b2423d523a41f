"""Cuts as they are asked for, in words: what a form calls their numbers, and one line of each."""

from dataclasses import dataclass

from autodb.files.job_cut import JobCut
from autodb.wording import amount_words, listed, msgid, phrase, shop_amount


@dataclass(frozen=True)
class FormField:
    """A number of a cut in a form: its key, what it is called, its unit, and in a sentence."""

    key: str
    called: str
    unit: str
    said: str


FIELDS = (
    FormField("diameter_mm", msgid("Diameter"), "mm", msgid("diameter {value}")),
    FormField("end_diameter_mm", msgid("End diameter"), "mm", msgid("end diameter {value}")),
    FormField("length_mm", msgid("Length"), "mm", msgid("length {value}")),
    FormField("depth_mm", msgid("Depth"), "mm", msgid("depth {value}")),
    FormField("width_mm", msgid("Width"), "mm", msgid("width {value}")),
    FormField("feed_mm_rev", msgid("Feed"), "mm/rev", msgid("feed {value}")),
    FormField("feed_mm_tooth", msgid("Feed"), "mm/tooth", msgid("feed {value}")),
    FormField("speed_m_min", msgid("Cutting speed"), "m/min", msgid("cutting speed {value}")),
    FormField("speed_rpm", msgid("or spindle speed"), "rpm", msgid("spindle speed {value}")),
    FormField("direction_deg", msgid("Direction"), "deg", msgid("direction {value}")),
    FormField("ramp_deg", msgid("Ramp"), "deg", msgid("ramp {value}")),
    FormField("pocket_diameter_mm", msgid("Pocket"), "mm", msgid("pocket {value}")),
    FormField("cutting_time_s", msgid("Edge has cut"), "s", msgid("edge has cut {value}")),
    FormField("flank_wear_mm", msgid("Flank wear"), "mm", msgid("flank wear {value}")),
)


def shown_fields() -> list[tuple[str, str, str]]:
    """Return the numbers of a cut as a form shows them: key, what it is called, its unit."""
    return [(one.key, phrase(one.called), shop_amount(1.0, one.unit)[1]) for one in FIELDS]


def cut_in_words(cut: JobCut) -> str:
    """Return a cut in one line."""
    stated = ((one, getattr(cut, one.key)) for one in FIELDS)
    said = [
        phrase(one.said, value=amount_words(value, one.unit))
        for one, value in stated
        if value is not None
    ]
    return listed([phrase(cut.operation), *said])
