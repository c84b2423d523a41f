"""Part files (TOML): what a turned part was measured to be, and how stiff work and machine are."""

from pathlib import Path
from typing import Literal

from pydantic import model_validator

from autodb.errors import UnusableInput
from autodb.files.toml import Finite, NotNegative, Positive, Section, read_toml
from autodb.wording import localized, phrase

SHARE = 0.05
"""Relative sd of the compliance of a bar, of its modulus and where the jaws hold it. Chosen."""


class BarSection(Section):
    """The round bar while it was cut: diameter and free length, between centres all of it.

    ``modulus_MPa``: Young's modulus (steel about 210 000, aluminium 70 000); ``share``: relative
    standard deviation of its compliance.
    """

    diameter_mm: Positive
    length_mm: Positive
    modulus_MPa: Positive
    held: Literal["chuck", "centres"] = "chuck"
    share: NotNegative = SHARE


class MeasuredSection(Section):
    """Diameters as measured less those wanted, at distances from the jaws, or from one centre.

    ``noise_mm``: standard deviation of one of them; ``setting_mm``: of what the radius is off by
    everywhere, left out where it is unknown; ``largest_N``: the passive force lies within it.
    """

    place_mm: list[NotNegative]
    diameter_error_mm: list[Finite]
    noise_mm: Positive
    setting_mm: Positive | None = None
    largest_N: Positive = 1000.0

    @model_validator(mode="after")
    def _alike(self) -> "MeasuredSection":
        if len(self.place_mm) != len(self.diameter_error_mm):
            raise ValueError(
                phrase(
                    "{n} places and {n_2} errors; give as many places as errors",
                    n=len(self.place_mm),
                    n_2=len(self.diameter_error_mm),
                )
            )
        return self


class PartFile(Section):
    """A part: its bar, what was measured, how far a newton moves holder, slide and headstock."""

    bar: BarSection
    measured: MeasuredSection
    machine_compliance_mm_N: NotNegative = 0.0


def read_part(path: Path) -> PartFile:
    """Read a part file.

    Raises UnusableInput with file and key, and where a place lies off the bar.
    """
    part = read_toml(path, PartFile)
    beyond = [place for place in part.measured.place_mm if place > part.bar.length_mm]
    if beyond:
        raise UnusableInput(
            phrase(
                "{file}: measured.place_mm: {beyond} is beyond the bar's length_mm, {length}",
                file=path,
                beyond=localized(f"{beyond[0]:g}"),
                length=localized(f"{part.bar.length_mm:g}"),
            )
        )
    return part
