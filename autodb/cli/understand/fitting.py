"""`calibrate --network`, `calibrate --table`: sensors of forces over time."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from autodb.cli._common import opened_store, say, show, table, working
from autodb.wording import significant

if TYPE_CHECKING:
    from autodb.sensing.table.model import TableModel


@dataclass(frozen=True)
class AskedRecordings:
    """Recordings of a machine, how their columns are called, and where the database is."""

    files: list[Path]
    machine: str | None
    columns: Path | None
    db: str | None


@dataclass(frozen=True)
class AskedBare:
    """Recordings of a table without its work, and what that weighs, kg."""

    files: list[Path]
    work_kg: float | None


def train_command(asked: AskedRecordings) -> None:
    """Train a network of a machine, and say its error on held-out data."""
    from autodb.agent.sense.networks import train_network

    with (
        working(f"training on {len(asked.files)} recordings") as progress,
        opened_store(asked.db) as store,
    ):
        done = train_network(
            store, str(asked.machine), asked.files, columns=asked.columns,
            folder=Path(".autodb-training"), progress=progress,
        )  # fmt: skip
    rows = table(
        f"Network {done.version} of {asked.machine}: errors on held-out data",
        "force", ">network N", ">drive model N", ">within 95 %", ">up to Hz",
    )  # fmt: skip
    for one in done.scores:
        rows.add_row(
            one.component, significant(one.rmse_N), significant(one.drive_rmse_N),
            f"{100.0 * one.held:.1f} %", f"{one.cutoff_hz:.3g}",
        )  # fmt: skip
    show(rows)
    if done.on_air:
        say("no force was recorded: trained on moves in air, whose force is taken as 0")
    if done.already_there:
        say("already there: the same recordings")


def level_command(asked: AskedRecordings, bare: AskedBare) -> None:
    """Identify a table dynamometer of a machine, and say what the moves determine of it."""
    from autodb.agent.sense.dynamometers import level_dynamometer
    from autodb.fitting.gaussian import NORMAL_95

    with working("identifying the table dynamometer") as progress, opened_store(asked.db) as store:
        done = level_dynamometer(
            store, str(asked.machine), asked.files, columns=asked.columns, bare=bare.files,
            work_kg=bare.work_kg, progress=progress,
        )  # fmt: skip
    model = done.model
    rows = table(
        f"Table dynamometer {done.version} of {asked.machine}",
        "", ">zero N", ">lever arm mm", ">± 95 %", ">reads of x %", ">of y %", ">of z %",
        ">residual in air N",
    )  # fmt: skip
    for k, name in enumerate("xyz"):
        half_mm = 1e3 * NORMAL_95 * model.lever_sd_m[k]
        determined = not any(f"arm's {name} " in sentence for sentence in model.not_excited)
        arm = (
            (f"{1e3 * model.lever_m[k]:.1f}", f"{half_mm:.1f}")
            if determined
            else ("not determined", "")
        )
        shares = [f"{100.0 * share:.2f}" for share in model.matrix[k]]
        rows.add_row(name, f"{model.zero_N[k]:.1f}", *arm, *shares, significant(done.left_N[k], 2))
    show(rows)
    _say_mass(model)
    _say_resonance(model)
    for sentence in model.not_excited:
        say(sentence)
    if done.already_there:
        say("already there: the same recordings")


def _say_mass(model: "TableModel") -> None:
    from autodb.fitting.gaussian import NORMAL_95

    half_kg = NORMAL_95 * model.mass_sd_kg
    table = model.kinematics
    axes = [
        axis if sense > 0 else f"{axis} (its angle counts the other way)"
        for axis, sense in zip(table.order, table.senses, strict=True)
    ]
    say(
        f"mass on the sensor: {model.mass_kg:.2f} ± {half_kg:.2f} kg (95 %); rotary axes from bed "
        f"to table: {', '.join(axes)}"
    )
    if model.work_kg is not None:
        half = 100.0 * NORMAL_95 * model.gain_sd
        say(f"gain of the sensor: by work of {model.work_kg:g} kg, ± {half:.2f} % (95 %)")


def _say_resonance(model: "TableModel") -> None:
    from autodb.fitting.gaussian import NORMAL_95
    from autodb.sensing.table.resonance import FEWEST, LEAST_HZ

    for name, mode in zip("xyz", model.modes, strict=True):
        if mode is not None:
            say(
                f"resonance in {name}: {significant(mode.hz, 4)} ± "
                f"{significant(NORMAL_95 * mode.hz_sd, 2)} Hz (95 %), damping {mode.damping:.3f}"
            )
    lacking = ", ".join(n for n, mode in zip("xyz", model.modes, strict=True) if mode is None)
    if lacking:
        say(
            f"the resonance in {lacking} is not determined, forces are not corrected for it; tap "
            f"the work {FEWEST} times or more along each, recorded at {LEAST_HZ:g} Hz or more"
        )
