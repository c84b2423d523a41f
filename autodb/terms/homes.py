"""Where confirmed effects are kept, in words: what each changes in the commands that come after."""

from autodb.terms.term import Home
from autodb.terms.vocabulary import all_terms, where_kept
from autodb.wording import Worded, msgid, phrase

KEPT: dict[Home, tuple[str, str]] = {
    "machine": (
        msgid("the drive model of the axis"),
        msgid(
            "the next version of the model has it, which `reconstruct`, `explain` and the sensing "
            "of cuts by that drive use"
        ),
    ),
    "pair": (
        msgid("the parameters of the work-tool pair"),
        msgid(
            "the next version has it, learnt with the cuts that were excluded for it: `predict`, "
            "`lookup`, `plan` and pages contain it with its uncertainty; cards and exports hold "
            "what the law has numbers for"
        ),
    ),
    "lot": (
        msgid("the parameters of the work-tool pair, under the name of the lot"),
        msgid(
            "`predict` and `lookup` contain it where the job or `--lot` names that lot, and say so "
            "where none is named"
        ),
    ),
    "tool": (
        msgid("the tool, as it is clamped"),
        msgid(
            "peaks and forces over the spindle's turn contain it with its uncertainty, until the "
            "decision is taken back because the tool was clamped anew"
        ),
    ),
    "calibration": (
        msgid("the calibration of the force"),
        msgid(
            "a corrected version senses the force of cuts from the change on, and the pair is "
            "learnt with it"
        ),
    ),
    "recording": (msgid("nowhere but its recording"), msgid("it is noted; no prediction changes")),
}
"""By where a term belongs: the place, and what changes."""


def kept_words(name: str, channel: str) -> str:
    """Return where an effect found in a channel is kept once confirmed, and what changes."""
    place, changes = (phrase(words) for words in KEPT[where_kept(name, channel)])
    law = [number for term in all_terms() if term.name == name for number in term.in_law]
    if law and where_kept(name, channel) == "pair":
        place = phrase("{place} ({numbers})", place=place, numbers=", ".join(law))
    kept = phrase("{place}: {changes}", place=place, changes=changes)
    return Worded(kept.replace("`", ""), kept.language)
