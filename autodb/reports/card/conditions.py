"""What repeats of one cut say: which rows were cut alike, their scatter, and what moved."""

from collections import Counter
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from autodb import standard
from autodb.records.tables import CutTable
from autodb.sensing.ranges.repeated_cut import CurrentChange, moved_between
from autodb.sensing.ranges.repeats import repeats, sample, sd_words, variance_interval
from autodb.wording import amount_words, msgid, phrase

Array = NDArray[np.float64]

FEWEST = 3
"""Repeats of one condition from which on their scatter is split."""
MOST_SETS = 3
"""Repeated conditions that are shown; further ones are counted."""
NUMBERS = {
    "spindle.speed": (msgid("{value}"), "rpm"),
    "cutting.feed": (msgid("feed {value}"), "mm"),
    "cutting.depth": (msgid("depth {value}"), "mm"),
}
DIAMETER = {"work.diameter": (msgid("Ø{value}"), "mm")}
TEXTS = ("operation", "work.material", "tool")


def condition_words(
    table: CutTable, protocol: standard.CutProtocol | None, *, with_diameter: bool
) -> list[str]:
    """Return the condition (n,) of every row in words; empty where it is not known.

    Standard cuts of a protocol go by their names. A torque also follows the diameter.
    """
    if protocol is None:
        return [_words(table, row, NUMBERS | DIAMETER if with_diameter else NUMBERS)
                for row in range(len(table))]  # fmt: skip
    found = [""] * len(table)
    for cut in protocol.cut:
        for row in np.flatnonzero(standard.rows_of_cut(table, cut)):
            diameter = _words(table, int(row), DIAMETER) if with_diameter else ""
            found[row] = ", ".join(part for part in (cut.name, diameter) if part)
    return found


def _words(table: CutTable, row: int, wanted: dict[str, tuple[str, str]]) -> str:
    """Return the numbers that are known of a row, and whose cut it is; empty without any."""
    known = {name: table[name][row] for name in wanted if name in table}
    if not known or not all(np.isfinite(value) for value in known.values()):
        return ""
    stated = {name: table.texts[name][row] for name in TEXTS if name in table.texts}
    texts = [phrase(one) if name == "operation" and one else one for name, one in stated.items()]
    numbers = [
        phrase(wanted[name][0], value=amount_words(value, wanted[name][1], ".4g"))
        for name, value in known.items()
    ]
    return ", ".join(part for part in (*texts, *numbers) if part)


def condition_scatter(
    said: Sequence[str], reference: Array, estimate: Array, unit: str
) -> tuple[tuple[str, tuple[str, ...]], ...]:
    """Return (condition, sentences) of those repeated most, by conditions ``said`` (n,).

    ``reference`` and ``estimate`` (n,) in ``unit``. Where one reference stands for all repeats,
    they have no scatter of their own to compare with.
    """
    of = np.array(said)
    counts = Counter(one for one in said if one).most_common(MOST_SETS)
    return tuple(
        (name, _lines(reference[of == name], estimate[of == name], unit))
        for name, count in counts
        if count >= FEWEST
    )


def count_repeated(said: Sequence[str]) -> int:
    """Return how many conditions of ``said`` (n,) have FEWEST repeats or more."""
    return sum(count >= FEWEST for name, count in Counter(said).items() if name)


def _lines(reference: Array, estimate: Array, unit: str) -> tuple[str, ...]:
    if np.ptp(reference) > 0.0:
        return tuple(repeats(reference, estimate).lines(unit))
    own = sample(estimate)
    return (
        phrase(
            "{count} repeats, one reference for all of them: process and sensing together have "
            "a standard deviation of {sd}",
            count=own.n,
            sd=sd_words(variance_interval(own), unit),
        ),
    )


def codes(said: Sequence[str]) -> NDArray[np.intp] | None:
    """Return a number for each condition (n,); None where the last cut does not repeat the first.

    ``said`` (n,): conditions in the order of the cuts.
    """
    if len(said) < FEWEST or not said[0] or said[0] != said[-1]:
        return None
    return np.unique(np.array(said), return_inverse=True)[1].ravel()


def last_less_first(values: Array, alike: NDArray[np.intp]) -> CurrentChange | None:
    """Return by how much the last of values (n,) differs from the first, by conditions (n,).

    None where no other condition was repeated: what is chance is not known then.
    """
    try:
        return moved_between(values, alike, first=[0], last=[len(values) - 1])
    except ValueError:
        return None


def movement(said: Sequence[str], signals: dict[str, tuple[Array, str]]) -> tuple[str, ...]:
    """Return by how much values changed from the first to the last cut, where these are alike.

    ``said`` (n,): conditions in the order of the cuts; ``signals``: values (n,) and unit by name.
    """
    alike = codes(said)
    if alike is None:
        return ()
    return tuple(_moved(name, *signal, alike) for name, signal in signals.items())


def _moved(name: str, values: Array, unit: str, alike: NDArray[np.intp]) -> str:
    found = last_less_first(values, alike)
    if found is not None:
        return found.sentence(name, unit)
    return phrase(
        "{channel} {before} moved by {change} from the first cut to the last; no other cut was "
        "repeated, so the scatter is not known",
        channel=name,
        before=amount_words(values[0], unit, ".4g"),
        change=amount_words(values[-1] - values[0], unit, "+.3g"),
    )
