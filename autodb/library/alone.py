"""Without a database: explain a recording by a simulation, identify an axis from its moves."""

from collections.abc import Callable, Sequence
from pathlib import Path

from autodb.agent.ingest.gathering import cuts_of_files
from autodb.agent.sense.calibrating import (
    Calibrated,
    calibrate_table,
    with_errors_of_dynamometer,
)
from autodb.agent.sense.identifying import check_moves, refuse_faults
from autodb.explain import explain
from autodb.files.checksums import checksum
from autodb.library.found import ExplainResult, IdentifyResult
from autodb.library.given import ColumnsGiven, Given, Units, pair_taken, taken
from autodb.records.plausible import doubts
from autodb.records.resample import one_base, only_over_time
from autodb.records.summary import summary_of
from autodb.records.tables import CutTable, Recording
from autodb.sensing.drives import feed_axis
from autodb.sensing.ranges.points import COMPONENT_OF_AXIS
from autodb.standard import CutProtocol


def explain_data(
    recording: Given,
    simulation: Given,
    *,
    includes: Sequence[str] | None = None,
    columns: ColumnsGiven = None,
    units: Units | None = None,
) -> ExplainResult:
    """Say what a simulation of a recording leaves out, where, and how large it is.

    ``recording``, ``simulation``: data frames or paths with the same `t`, or `cut`. ``includes``:
    the terms that the simulation already has. ``columns``: which column is which channel, such as
    ``{"x.current": "I_X"}``; of data frames, it counts for both. ``units``: by column or channel,
    where a name such as ``x.current [mA]`` does not say it.

    Raises UnusableInput with the column and row.

    >>> import numpy as np, pandas as pd
    >>> import autodb
    >>> t = np.arange(0.0, 20.0, 0.01)
    >>> x = pd.DataFrame({"t": t, "x.position": 50.0 * np.sin(t)})
    >>> simulation = x.assign(**{"x.current": 0.02 * np.cos(t)})
    >>> friction = 0.5 * np.sign(np.cos(t)) + np.random.default_rng(1).normal(0.0, 0.05, len(t))
    >>> recording = simulation.assign(**{"x.current": simulation["x.current"] + friction})
    >>> found = autodb.explain(recording, simulation)
    >>> found.mismatch, list(found.to_pandas()["term"])
    (True, ['coulomb'])
    """
    first, second = pair_taken(recording, simulation, columns=columns, units=units)
    measured = one_base(first.source())
    simulated = one_base(second.source(), like=measured)
    names = None if includes is None else list(includes)
    return explained(measured, simulated, names)


def explained(
    measured: Recording | CutTable, simulated: Recording | CutTable, includes: list[str] | None
) -> ExplainResult:
    """Explain a recording that was read by a simulation that was read."""
    said = tuple(doubts(summary_of(measured), measured.side))
    return ExplainResult(explain(measured, simulated, includes=includes), doubts=said)


def calibrate_files(
    files: Sequence[Path],
    *,
    columns: Path | None,
    protocol: CutProtocol | None,
    tell: Callable[[str], None],
) -> Calibrated:
    """Calibrate on cut tables, and raw recordings of one cut each; nothing is kept.

    Raises UnusableInput.
    """
    axes = tuple(COMPONENT_OF_AXIS)
    cuts = cuts_of_files(files, columns=columns, tell=tell)
    done, left_out = calibrate_table(cuts, axes=axes, protocol=protocol)
    if protocol is None:
        done = [with_errors_of_dynamometer(one, cuts) for one in done]
    sources = [(file.name, checksum(file)) for file in files]
    return Calibrated(cuts, axes, done, left_out, sources)


def identify_data(
    recording: Given,
    *,
    axis: str | None = None,
    terms: Sequence[str] | None = None,
    columns: ColumnsGiven = None,
    units: Units | None = None,
) -> IdentifyResult:
    """Identify inertia, friction, load and other terms of a feed axis from its moves.

    ``recording``: a data frame or path with positions and the effort of the drive over time.
    ``axis``: where several were recorded; ``terms``: those to fit, in place of the symmetric four.
    ``columns`` and ``units`` as of ``explain``.

    Raises UnusableInput with the column and row.

    >>> import numpy as np, pandas as pd
    >>> import autodb
    >>> t = np.arange(0.0, 40.0, 0.004)
    >>> x, v = 60.0 * np.sin(0.5 * t) + 20.0 * np.sin(2.1 * t), 30.0 * np.cos(0.5 * t)
    >>> v += 42.0 * np.cos(2.1 * t)
    >>> effort = 0.004 * v + 0.8 * np.sign(v) + np.random.default_rng(1).normal(0.0, 0.02, len(t))
    >>> moves = pd.DataFrame({"t": t, "x.position": x, "x.current [mA]": 1000.0 * effort})
    >>> found = autodb.identify(moves, terms=["viscous", "coulomb"])
    >>> print(found.to_pandas()[["term", "value", "unit"]].round(3).to_string(index=False))
       term  value   unit
    viscous  0.004 A·s/mm
    coulomb  0.800      A
    """
    moves = check_moves(
        only_over_time(one_base(taken(recording, columns=columns, units=units).source())), axis
    )
    refuse_faults(moves, axis)
    return IdentifyResult(feed_axis.identify(moves, axis=axis, terms=terms), moves)
