"""`identify --staged`: the stages of a ball screw or linear drive, the joint fit beside them."""

from typing import TYPE_CHECKING, Annotated

import typer

from autodb.cli._common import opened_store, say, show, table
from autodb.wording import localized, phrase

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rich.table import Table

    from autodb.agent.sense.staging import TriedStages
    from autodb.records.tables import Recording
    from autodb.sensing.drives.fit.axis_model import Identified
    from autodb.sensing.drives.staged.compared import Agreement
    from autodb.sensing.drives.staged.linear import FourSteps
    from autodb.sensing.drives.staged.routine import Staged
    from autodb.sensing.drives.staged.stages import Stages
    from autodb.sensing.drives.staged.sticking import StickingVerdict

Staging = Annotated[
    bool,
    typer.Option(
        "--staged",
        help="Also in stages, as published for ball screws and for linear drives, beside the "
        "joint fit.",
    ),
]
Pitch = Annotated[
    float | None,
    typer.Option(
        "--pitch",
        metavar="MM",
        min=0.1,
        help="Pitch of the screw or of the poles, for --staged [default: the screw's in the "
        "machine's file; the pole that the joint fit finds].",
    ),
]

LISTED = 3
"""Of so many nodes of a pole's table one is listed."""


def check_staging(*, staged: bool, pitch: float | None) -> None:
    """Refuse options that do not go together, before anything is fitted."""
    from autodb.errors import UnusableInput

    if pitch is not None and not staged:
        raise UnusableInput(phrase("--pitch goes with --staged: the segments are a third of it"))


def try_stages(
    moves: "Recording",
    *,
    axis: str | None,
    machine: str | None,
    terms: "Sequence[str] | None",
    pitch: float | None,
    db: str | None,
) -> "TriedStages":
    """Run the stages before anything is fitted or stored: refused here where they cannot.

    A pitch that is given counts before the machine's.
    """
    from autodb.agent.sense.staging import StagedMoves, drive_of, staged_fits
    from autodb.sensing.drives.moves.prepared import effort_axis

    drive = StagedMoves(moves, pitch, screw=False, asked=frozenset(terms or ()))
    if machine is not None:
        name = effort_axis(moves, axis)
        with opened_store(db) as store:
            drive = drive_of(store, machine, moves, name, terms=terms, pitch_mm=pitch)
    return staged_fits(drive, axis)


def show_staged(model: "Identified", seen: "TriedStages") -> None:
    """Print the stages, and how they agree with the joint fit."""
    from autodb.agent.sense.staging import stages_beside
    from autodb.sensing.drives.staged.linear import FourSteps

    found, both = stages_beside(model, seen)
    if isinstance(found, FourSteps):
        _show_steps(found, model.unit)
    else:
        _show_stages(found, model.unit)
    _show_agreement(both)


def show_sweep(model: "Identified", moves: "Recording") -> None:
    """Say where a recording is fitted as a sweep over speeds."""
    from autodb.sensing.drives.moves.passes import is_sweep

    if is_sweep(moves, model.axis):
        say(phrase("a sweep over speeds, most of it at creep: slow passes count by the way gone"))


def _show_cut(found: "Stages") -> None:
    """Print how many passes there are, and which of them stick or could not be tested."""
    say(
        phrase(
            "stages: {n} passes at {n_2} speeds both ways, cut into segments of {mm} mm ({why})",
            n=len(found.passes),
            n_2=len(found.levels),
            mm=localized(f"{found.length.mm:.3g}"),
            why=found.length.why,
        )
    )
    stuck = [one for one in found.verdicts.values() if one.sticks]
    if stuck:
        halts = max(one.halts for one in stuck)
        say(
            phrase(
                "stick-slip, not used for the weight: {stuck}; effort is {stuck_2} as uneven "
                "along the way as at faster speeds, {stuck_3} from row to row; at most {halts} "
                "halts in a pass",
                stuck=_feeds(stuck),
                stuck_2=_times(stuck, "over_way"),
                stuck_3=_times(stuck, "over_time"),
                halts=halts,
            )
        )
    blind = [one for one in found.verdicts.values() if not one.tested]
    if blind:
        say(
            phrase("not tested for stick-slip, taken to run smoothly: {blind}", blind=_feeds(blind))
        )


def _feeds(some: "list[StickingVerdict]") -> str:
    return ", ".join(f"{one.speed_mm_s * 60.0:.4g}" for one in some) + " mm/min"


def _times(some: "list[StickingVerdict]", name: str) -> str:
    values = sorted(getattr(one, name) for one in some)
    return f"{values[0]:.1f} to {values[-1]:.1f} times"


def _show_stages(found: "Staged", unit: str) -> None:
    """Print P2's stages."""
    say(
        phrase(
            "P2's stages of a ball screw: weight, friction over speed and along the "
            "travel, warming, inertia"
        )
    )
    _show_cut(found)
    middle = found.along.middle_mm
    means = found.averages
    say(
        phrase(
            "repeats of the {n} segments differ by {differ} % of friction (sd)",
            n=len(means.x_mm),
            differ=localized(f"{100.0 * means.differ:.1f}"),
        )
    )
    say(
        phrase(
            "friction over speed is of {n} speeds, which pass {min} to {max} mm",
            n=len(found.compared),
            min=localized(f"{middle.min():.0f}"),
            max=localized(f"{middle.max():.0f}"),
        )
    )
    rows = _stage_table()
    used = f"mean of both ways over {len(found.weight.levels)} speeds"
    rows.add_row("weight", used, f"{found.weight.value:.6g}", f"{found.weight.sd:.2g}", unit)
    _add_laws(rows, found, unit)
    names = [f"slope a mm|{unit}/mm", f"cosine|{unit}", f"sine|{unit}"]
    for i, value in enumerate(found.along.values):
        name, its = names[i].split("|")
        sd = found.along.covariance[i, i] ** 0.5
        rows.add_row("along the travel", name, f"{value:.6g}", f"{sd:.2g}", its)
    _add_rest(rows, found, unit)
    show(rows)


def _show_steps(found: "FourSteps", unit: str) -> None:
    """Print P0's four steps."""
    load, (table_nodes, node_sd) = found.load, found.load.table
    say(
        phrase(
            "P0's four steps of a linear drive: load over the travel as a line, cogging as "
            "a table of a pole, friction over speed, inertia"
        )
    )
    _show_cut(found)
    say(
        phrase(
            "the line's level holds weight, a sensor's zero and what friction differs by "
            "direction; the model discrepancy of line and table at a place is {lack} "
            "{unit} (sd)",
            lack=localized(f"{load.lack:.2g}"),
            unit=unit,
        )
    )
    middle = found.middle_mm
    say(
        phrase(
            "friction over speed is of {n} speeds, between {min} and {max} mm; along the "
            "travel these steps have none",
            n=len(found.compared),
            min=localized(f"{middle.min():.0f}"),
            max=localized(f"{middle.max():.0f}"),
        )
    )
    if not found.repeated:
        say(
            phrase(
                "no speed was passed twice in one direction; errors of friction are the "
                "residuals of its law, and the scatter between runs is not known"
            )
        )
    rows = _stage_table()
    used = f"{load.pairs} passes there and back"
    rows.add_row("line", f"k, {used}", *_two(load.slope), f"{unit}/mm")
    rows.add_row("line", "rest s_r", *_two(load.rest), "mm")
    for i in range(0, len(table_nodes), LISTED):
        where = f"at {found.length.mm * i:.4g} mm of the pole"
        rows.add_row(
            f"cogging, 1 node in {LISTED}", where, *_two((table_nodes[i], node_sd[i])), unit
        )
    _add_laws(rows, found, unit)
    _add_rest(rows, found, unit)
    show(rows)


def _stage_table() -> "Table":
    return table("Stage by stage", "stage", "parameter", ">value", ">sd", "unit")


def _two(both: tuple[float, float]) -> tuple[str, str]:
    return f"{both[0]:.6g}", f"{both[1]:.2g}"


def _add_laws(rows: "Table", found: "Stages", unit: str) -> None:
    units = {"viscous": f"{unit}·s/mm", "stribeck speed": "mm/s"}
    for sense, law in found.laws.items():
        way = "friction over speed, +" if sense > 0 else "friction over speed, −"
        for name, value, sd in law.named:
            rows.add_row(way, name, *_two((value, sd)), units.get(name, unit))
        rows.add_row(way, "model discrepancy (sd)", f"{100.0 * law.lack:.2g}", "", "%")


def _add_rest(rows: "Table", found: "Stages", unit: str) -> None:
    if found.warming is not None:
        warm = found.warming
        sds = warm.covariance.diagonal() ** 0.5
        rows.add_row("warming", "drop at 10 000 mm/min", f"{warm.drop:.4g}", f"{sds[0]:.2g}", "1")
        rows.add_row("warming", "time constant", f"{warm.time_constant_s:.4g}", f"{sds[1]:.2g}",
                     "s")  # fmt: skip
    if found.inertia is not None:
        rows.add_row("inertia", f"over {found.inertia.parts} accelerated parts",
                     *_two((found.inertia.value, found.inertia.sd)),
                     f"{unit}·s²/mm")  # fmt: skip


def _show_agreement(both: "Agreement") -> None:
    from autodb.sensing.drives.staged.compared import FAR_SDS, MAY_DIFFER

    rows = table(
        "Staged and joint", "quantity", ">staged", ">sd", ">joint", ">sd", "unit", ">apart by sd"
    )
    for one in both.rows:
        numbers = (one.staged, one.staged_sd, one.joint, one.joint_sd)
        rows.add_row(
            one.name,
            *(f"{v:.{2 if i % 2 else 4}g}" for i, v in enumerate(numbers)),
            one.unit,
            f"{one.difference_sds:+.1f}{' !' if one.differs else ''}",
        )
    show(rows)
    apart, count = both.differing, len(both.rows)
    rule = f"more than {FAR_SDS:g} sd apart: {len(apart)} of {count}, 1 in {MAY_DIFFER} may be"
    said = "staged and joint agree" if both.agrees else "staged and joint do NOT agree"
    say(f"{said}: {rule}")
    for one in apart:
        say(
            phrase(
                "apart: {which}: staged {staged}, joint {joint} {unit}",
                which=one.name,
                staged=localized(f"{one.staged:.4g}"),
                joint=localized(f"{one.joint:.4g}"),
                unit=one.unit,
            )
        )
    for sentence in both.left_out:
        say(phrase("not compared: {sentence}", sentence=sentence))
