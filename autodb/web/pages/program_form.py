"""The form of an NC program: the stock that it meets, its tools, and how it is read."""

from typing import Any

from autodb.files.job_words import CORNERS, KINDS, TOOL_FIELDS
from autodb.wording import msgid, phrase, shop_amount

CONTROLS = {
    "fanuc-a": msgid("Fanuc, Haas (A)"),
    "fanuc-b": msgid("Fanuc (B)"),
    "fanuc-c": msgid("Fanuc (C)"),
    "linuxcnc": msgid("LinuxCNC"),
    "okuma": msgid("Okuma OSP"),
    "sinumerik": msgid("Sinumerik"),
}
"""Controls whose words differ, by what a job calls them."""
MILLED = ("end_mill", "drill")
"""Kinds of tools that a mill's program may have."""


def form_of_program() -> dict[str, Any]:
    """Return what the template shows of the form of a program."""
    return {
        "tool_kinds": [(kind, phrase(words)) for kind, (words, _keys) in KINDS.items()],
        "tool_keys": {kind: keys for kind, (_words, keys) in KINDS.items()},
        "tool_fields": [
            (one.key, phrase(one.called), "" if one.unit == "1" else shop_amount(1.0, one.unit)[1])
            for one in TOOL_FIELDS
        ],
        "corners": [(corner, phrase(words)) for corner, words in CORNERS.items()],
        "of_mills": MILLED,
        "controls": [(control, phrase(words)) for control, words in CONTROLS.items()],
        "length_unit": shop_amount(1.0, "mm")[1],
    }
