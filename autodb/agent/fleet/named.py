"""A machine that disagrees with others, in words and as it is kept."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from autodb.fitting import NORMAL_95
from autodb.pairs.disagreeing import DisagreementCause, Disagrees


@dataclass(frozen=True)
class DisagreeingMachine:
    """A machine that disagrees with others: in which pairs, and why.

    ``gain``: what its calibration would be off by along and across, shares, with ``gain_sd``;
    ``likeliest``: the pair whose cutting would be the cause; ``told_by``: what tells the cause.
    """

    machine: str
    pairs: tuple[str, ...]
    cause: str
    gain: tuple[float, float]
    gain_sd: tuple[float, float]
    likeliest: str
    told_by: str

    @property
    def words(self) -> str:
        """Say it in one sentence."""
        along, across = (100.0 * one for one in self.gain)
        sd = (100.0 * NORMAL_95 * one for one in self.gain_sd)
        off = "force along {:+.0f} ± {:.0f} %, across {:+.0f} ± {:.0f} %".format(
            *(one for pair in zip((along, across), sd, strict=True) for one in pair)
        )
        whose = {
            DisagreementCause.CALIBRATION.value: f"is off: {off}",
            DisagreementCause.CUTTING.value: f"is another in {self.likeliest}",
            DisagreementCause.EITHER.value: f"is off ({off}, or {self.likeliest} is cut otherwise)",
        }[self.cause]
        by = f"; told by {self.told_by}" if self.told_by else ""
        hint = (
            "; a standard cut on it would tell which"
            if self.cause == DisagreementCause.EITHER.value
            else ""
        )
        return (
            f"{self.machine} disagrees in {', '.join(self.pairs)}: {self.cause} {whose}{by}{hint}"
        )


def named_of(machine: str, pairs: Sequence[str], told: Disagrees) -> DisagreeingMachine:
    """Return how a machine with these pairs, by name, is named."""
    return DisagreeingMachine(
        machine=machine,
        pairs=tuple(pairs[k] for k in told.pairs),
        cause=told.cause.value,
        gain=told.gain,
        gain_sd=told.gain_sd,
        likeliest=pairs[told.pair],
        told_by=told.told_by,
    )


def as_named(kept: Mapping[str, Any]) -> DisagreeingMachine:
    """Return a machine that disagrees from JSON."""
    tuples = {name: tuple(kept[name]) for name in ("pairs", "gain", "gain_sd")}
    return DisagreeingMachine(**{**kept, **tuples})
