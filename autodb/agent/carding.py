"""Gather what a calibration card shows from a calibration just made."""

from collections.abc import Mapping
from datetime import UTC, datetime

from autodb import standard
from autodb.agent.calibrating import Calibrated, known_forces
from autodb.card import Card, axis_card

SHOWN_OF_CHECKSUM = 12


def card_of(
    done: Calibrated,
    *,
    title: str,
    protocol: standard.Protocol | None,
    moved: Mapping[str, tuple[str, ...]],
) -> Card:
    """Return the card of calibrations made today; ``protocol`` as they were made with.

    ``moved``: sentences on what moved over the cuts, by axis.
    """
    forces = known_forces(done.table, protocol)
    sources = [f"{name}, sha256 {sha256[:SHOWN_OF_CHECKSUM]}" for name, sha256 in done.sources]
    if protocol is not None:
        sources.append(f"reference forces of the protocol '{protocol.name}'")
    else:
        sources.append("reference forces measured in each cut")
    return Card(
        title=title,
        made=datetime.now(UTC).date().isoformat(),
        sources=tuple(sources),
        axes=done.axes,
        cards=tuple(
            axis_card(
                one,
                done.table,
                force_N=forces[one.component],
                protocol=protocol,
                what_moved=moved[one.axis],
            )
            for one in done.calibrations
        ),
        versions=done.versions,
        left_out=tuple(sentence.removeprefix(f"{done.table.path}: ") for sentence in done.left_out),
    )
