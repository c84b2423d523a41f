"""How far a tool point gives way to a force that alternates: modes, or a measured receptance.

    G(w) = sum over modes (w_n²/k)/(w_n² - w² + 2 i z w_n w)

in mm/N of each machine axis; tool and work add up. Sections of a TOML file state modes, a CSV file
has a column `frequency_Hz` and, of each axis, real and imaginary part: `x_real_m_N`, `x_imag_m_N`.
"""

import csv
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from autodb.errors import UnusableInput, near_words
from autodb.files.toml import NotNegative, Positive, Section, read_toml
from autodb.wording import amount_words, localized, phrase

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

AXES = ("x", "y", "z")
SHARE = 0.1
"""Relative standard deviation of a receptance nobody states. Chosen: two measurements of one tool
point, clamped anew, differ by about that."""
FREQUENCY, PARTS = "frequency_Hz", ("real_m_N", "imag_m_N")
COLUMNS = (FREQUENCY, *(f"{axis}_{part}" for axis in AXES for part in PARTS))
LEAST_ROWS = 10
"""Of a measured receptance. Chosen: a resonance has as many."""
MM = 1000.0
HIGHEST_HZ = 1e5
PEAKS = 30.0
"""Lines over the half-width of a mode. Chosen."""
BEYOND = 3.0
"""Times the highest mode's frequency up to which chatter is looked for. Chosen."""


class ModeSection(Section):
    """A mode of the tool point in one machine axis.

    ``share``: relative standard deviation of its compliance.
    """

    axis: Literal["x", "y", "z"]
    frequency_Hz: Annotated[Positive, Field(le=HIGHEST_HZ)]
    damping_ratio: Annotated[Positive, Field(lt=1.0)]
    stiffness_N_m: Annotated[Positive, Field(ge=1e3, le=1e12)]
    share: Annotated[NotNegative, Field(lt=1.0)] = SHARE


class ModesFile(Section):
    """The modes of a tool point; those of the work are named with them."""

    mode: Annotated[tuple[ModeSection, ...], Field(min_length=1, max_length=100)]


@dataclass(frozen=True)
class ToolPoint:
    """Receptances of a tool point: ``receptance`` (f, 3) in mm/N at ``frequency_Hz`` (f,), rising.

    ``share`` (3,): relative standard deviation of each axis'; ``source``: the file's name.
    """

    source: str
    frequency_Hz: Array
    receptance: Complex
    share: Array


def read_tool_point(path: Path) -> ToolPoint:
    """Read modes (TOML) or a measured receptance (CSV); raises UnusableInput with key or row."""
    if path.suffix.lower() == ".csv":
        return _measured(path)
    return of_modes(read_toml(path, ModesFile).mode, source=str(path))


def modes_in_words(modes: Iterable[ModeSection]) -> Iterator[str]:
    """Yield each mode in a line."""
    for one in modes:
        yield phrase(
            "{axis} gives way at {frequency}, damping ratio {damping}, stiffness {stiffness}, "
            "compliance known to ± {share} %",
            axis=one.axis,
            frequency=amount_words(one.frequency_Hz, "Hz", ".6g"),
            damping=localized(f"{one.damping_ratio:g}"),
            stiffness=amount_words(one.stiffness_N_m / MM, "N/mm", ".4g"),
            share=localized(f"{100.0 * one.share:.3g}"),
        )


def of_modes(modes: tuple[ModeSection, ...], *, source: str) -> ToolPoint:
    """Return the receptances of modes, on lines that are close where they resonate."""
    highest = BEYOND * max(one.frequency_Hz for one in modes)
    narrowest = min(one.damping_ratio * one.frequency_Hz for one in modes)
    lowest = 0.2 * min(one.frequency_Hz for one in modes)
    lines = [np.linspace(lowest, highest, 600)]
    for one in modes:
        half = one.damping_ratio * one.frequency_Hz
        lines.append(one.frequency_Hz + half * np.sinh(np.linspace(-5.0, 5.0, int(12 * PEAKS))))
    every = np.unique(np.concatenate(lines))
    every = every[(every >= min(lowest, narrowest)) & (every <= highest)]
    receptance = np.zeros((len(every), 3), dtype=np.complex128)
    variance, size = np.zeros(3), np.zeros(3)
    for one in modes:
        k = AXES.index(one.axis)
        ratio = every / one.frequency_Hz
        flexible = MM / one.stiffness_N_m
        receptance[:, k] += flexible / (1.0 - ratio**2 + 2j * one.damping_ratio * ratio)
        peak = flexible / one.damping_ratio
        variance[k] += (one.share * peak) ** 2
        size[k] = max(size[k], peak)
    share = np.sqrt(np.divide(variance, size**2, out=np.zeros(3), where=size > 0.0))
    return ToolPoint(source, every, receptance, share)


def _measured(path: Path) -> ToolPoint:
    names, rows = _table(path)
    known = [axis for axis in AXES if f"{axis}_{PARTS[0]}" in names]
    values = np.array(rows)
    column = {name: values[:, k] for k, name in enumerate(names)}
    frequency = column[FREQUENCY]
    back = np.flatnonzero(np.diff(frequency) <= 0.0)
    if len(back) or frequency[0] < 0.0:
        row = int(back[0]) + 3 if len(back) else 2
        raise UnusableInput(
            phrase(
                "{file}: row {row}: {frequency} has to rise from 0 on; sort the rows",
                file=path,
                row=row,
                frequency=FREQUENCY,
            )
        )
    receptance = np.zeros((len(frequency), 3), dtype=np.complex128)
    for axis in known:
        real, imaginary = (column[f"{axis}_{part}"] for part in PARTS)
        receptance[:, AXES.index(axis)] = MM * (real + 1j * imaginary)
    if np.max(receptance.imag) >= -np.min(receptance.imag):
        raise UnusableInput(
            phrase(
                "{file}: the imaginary parts are mostly positive: a receptance lags its force; "
                "give displacement over force, in m/N, and not its conjugate or an accelerance",
                file=path,
            )
        )
    flexible = np.any(receptance != 0.0, axis=0)
    return ToolPoint(str(path), frequency, receptance, np.where(flexible, SHARE, 0.0))


def _table(path: Path) -> tuple[list[str], list[list[float]]]:
    """Return the names and rows of a CSV file of receptances; raises UnusableInput."""
    try:
        with path.open(encoding="utf-8-sig", newline="") as file:
            lines = [row for row in csv.reader(file) if row]
    except (OSError, UnicodeDecodeError) as error:
        said = error.strerror if isinstance(error, OSError) else "is no text"
        raise UnusableInput(
            phrase("{file}: {said}; name a CSV file of receptances", file=path, said=said)
        ) from None
    names = [one.strip() for one in lines[0]] if lines else []
    for name in names:
        if name not in COLUMNS:
            raise UnusableInput(
                phrase(
                    "{file}: column '{name}' is none of ours{hint}",
                    file=path,
                    name=name,
                    hint=near_words(name, COLUMNS),
                )
            )
    twins = [f"{axis}_{part}" for axis in AXES for part in PARTS]
    axes = {one[0] for one in names if one in twins}
    lacking = [one for one in twins if one[0] in axes and one not in names]
    if FREQUENCY not in names or not axes or lacking or len(set(names)) < len(names):
        raise UnusableInput(
            phrase(
                "{file}: needs the columns {frequency} and, of one axis at least, such as "
                "{twins} and {twins_2}, each once",
                file=path,
                frequency=FREQUENCY,
                twins=twins[0],
                twins_2=twins[1],
            )
        )
    if len(lines) <= LEAST_ROWS:
        raise UnusableInput(
            phrase(
                "{file}: {n} rows; give {least_rows} lines at least",
                file=path,
                n=len(lines) - 1,
                least_rows=LEAST_ROWS,
            )
        )
    return names, [_numbers(path, k, row, names) for k, row in enumerate(lines[1:], start=2)]


def _numbers(path: Path, number: int, row: list[str], names: list[str]) -> list[float]:
    if len(row) != len(names):
        raise UnusableInput(
            phrase(
                "{file}: row {number}: {n} cells, not {n_2}",
                file=path,
                number=number,
                n=len(row),
                n_2=len(names),
            )
        )
    found = []
    for name, cell in zip(names, row, strict=True):
        try:
            value = float(cell)
        except ValueError:
            value = np.nan
        if not np.isfinite(value):
            raise UnusableInput(
                phrase(
                    "{file}: row {number}: {name} '{cell}' is no number; write 1.2e-7",
                    file=path,
                    number=number,
                    name=name,
                    cell=cell,
                )
            )
        found.append(value)
    return found
