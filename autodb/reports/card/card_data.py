"""Gather what a calibration card shows from a calibration just made."""

from collections.abc import Sequence
from datetime import UTC, datetime

from autodb import standard
from autodb.agent.sense.calibrating import Calibrated, its_own, known_forces
from autodb.reports.card import CalibrationCard, axis_card
from autodb.wording import phrase

SHOWN_OF_CHECKSUM = 12


def card_of_calibrations(
    done: Calibrated,
    *,
    title: str,
    protocol: standard.CutProtocol | None,
    moved: Sequence[tuple[str, ...]],
) -> CalibrationCard:
    """Return the card of calibrations made today; ``protocol`` as they were made with.

    ``moved``: sentences on what moved over the cuts, for each of them.
    """
    forces = known_forces(done.table, protocol)
    sources = [f"{name}, sha256 {sha256[:SHOWN_OF_CHECKSUM]}" for name, sha256 in done.sources]
    if protocol is not None:
        sources.append(phrase("reference forces of the protocol '{name}'", name=protocol.name))
    else:
        sources.append(phrase("reference forces measured in each cut"))
    return CalibrationCard(
        title=title,
        made=datetime.now(UTC).date().isoformat(),
        sources=tuple(sources),
        axes=done.axes,
        cards=tuple(
            axis_card(
                one,
                done.table,
                force_N=its_own(done.table, one, forces),
                protocol=protocol,
                what_moved=sentences,
            )
            for one, sentences in zip(done.calibrations, moved, strict=True)
        ),
        versions=done.versions,
        left_out=tuple(sentence.removeprefix(f"{done.table.path}: ") for sentence in done.left_out),
    )
