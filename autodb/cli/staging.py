"""`identify --staged`: the stages of a ball-screw axis, and the joint fit beside them."""

from typing import TYPE_CHECKING, Annotated

import typer

from autodb.cli._common import opened, say, show, table

if TYPE_CHECKING:
    from autodb.agent.staging import Tried
    from autodb.records import Recording
    from autodb.sensing.axis_model import Identified
    from autodb.sensing.staged.agreement import Agreement
    from autodb.sensing.staged.routine import Staged
    from autodb.sensing.staged.sticking import Verdict

Staging = Annotated[
    bool,
    typer.Option(
        "--staged", help="Also in stages, as published for ball screws, beside the joint fit."
    ),
]
Pitch = Annotated[
    float | None,
    typer.Option(
        "--pitch",
        metavar="MM",
        min=0.1,
        help="Pitch of the screw, for --staged [default: that of the machine's file].",
    ),
]


def check_staging(*, staged: bool, pitch: float | None) -> None:
    """Refuse options that do not go together, before anything is fitted."""
    from autodb.errors import UnusableInput

    if pitch is not None and not staged:
        raise UnusableInput("--pitch goes with --staged: the segments are a third of it")


def try_stages(
    moves: "Recording",
    *,
    axis: str | None,
    machine: str | None,
    pitch: float | None,
    db: str | None,
) -> "Tried":
    """Run the stages before anything is fitted or stored: refused here where they cannot.

    A pitch that is given counts before the machine's.
    """
    from dataclasses import replace

    from autodb.agent.staging import Screw, screw_of, tried
    from autodb.sensing.prepared import effort_axis

    screw = Screw(moves, pitch)
    if machine is not None:
        with opened(db) as store:
            screw = screw_of(store, machine, moves, effort_axis(moves, axis))
        screw = screw if pitch is None else replace(screw, pitch_mm=pitch)
    return tried(screw, axis)


def show_staged(model: "Identified", seen: "Tried") -> None:
    """Print the stages, and how they agree with the joint fit."""
    from autodb.agent.staging import beside

    found, both = beside(model, seen)
    _show_passes(found)
    _show_stages(found, model.unit)
    _show_agreement(both)


def show_sweep(model: "Identified", moves: "Recording") -> None:
    """Say where a recording is fitted as a sweep over speeds."""
    from autodb.sensing.passes import swept

    if swept(moves, model.axis):
        say("a sweep over speeds, most of it at creep: slow passes count by the way gone")


def _show_passes(found: "Staged") -> None:
    means = found.averages
    say(f"stages: {len(found.passes)} passes at {len(found.levels)} speeds both ways, cut into "
        f"{len(means.x_mm)} segments of {found.length.mm:.3g} mm ({found.length.why})")  # fmt: skip
    say(f"repeats of a segment differ by {100.0 * means.differ:.1f} % of friction (sd)")
    middle = found.along.middle_mm
    say(f"friction over speed is of {len(found.compared)} speeds, which pass {middle.min():.0f} to "
        f"{middle.max():.0f} mm")  # fmt: skip
    stuck = [one for one in found.verdicts.values() if one.sticks]
    if stuck:
        halts = max(one.halts for one in stuck)
        say(f"stick and slip, tell no weight: {_feeds(stuck)}; effort is "
            f"{_times(stuck, 'over_way')} as uneven along the way as at faster speeds, "
            f"{_times(stuck, 'over_time')} from row to row; at most {halts} halts in a "
            "pass")  # fmt: skip
    blind = [one for one in found.verdicts.values() if not one.tested]
    if blind:
        say(f"not tested for stick-slip, taken to run smoothly: {_feeds(blind)}")


def _feeds(some: "list[Verdict]") -> str:
    return ", ".join(f"{one.speed_mm_s * 60.0:.4g}" for one in some) + " mm/min"


def _times(some: "list[Verdict]", name: str) -> str:
    values = sorted(getattr(one, name) for one in some)
    return f"{values[0]:.1f} to {values[-1]:.1f} times"


def _show_stages(found: "Staged", unit: str) -> None:
    rows = table("Stage by stage", "stage", "parameter", ">value", ">sd", "unit")
    used = f"mean of both ways over {len(found.weight.levels)} speeds"
    rows.add_row("weight", used, f"{found.weight.value:.6g}", f"{found.weight.sd:.2g}", unit)
    units = {"viscous": f"{unit}·s/mm", "stribeck speed": "mm/s"}
    for sense, law in found.laws.items():
        way = "friction over speed, +" if sense > 0 else "friction over speed, −"
        for name, value, sd in law.named:
            rows.add_row(way, name, f"{value:.6g}", f"{sd:.2g}", units.get(name, unit))
        rows.add_row(way, "off its law (sd)", f"{100.0 * law.lack:.2g}", "", "%")
    names = [f"slope a mm|{unit}/mm", f"cosine|{unit}", f"sine|{unit}"]
    for i, value in enumerate(found.along.values):
        name, its = names[i].split("|")
        sd = found.along.covariance[i, i] ** 0.5
        rows.add_row("along the travel", name, f"{value:.6g}", f"{sd:.2g}", its)
    if found.warming is not None:
        warm = found.warming
        sds = warm.covariance.diagonal() ** 0.5
        rows.add_row("warming", "drop at 10 000 mm/min", f"{warm.drop:.4g}", f"{sds[0]:.2g}", "1")
        rows.add_row("warming", "time constant", f"{warm.time_constant_s:.4g}", f"{sds[1]:.2g}",
                     "s")  # fmt: skip
    if found.inertia is not None:
        rows.add_row("inertia", f"over {found.inertia.parts} accelerated parts",
                     f"{found.inertia.value:.6g}", f"{found.inertia.sd:.2g}",
                     f"{unit}·s²/mm")  # fmt: skip
    show(rows)


def _show_agreement(both: "Agreement") -> None:
    from autodb.sensing.staged.agreement import FAR_SDS, MAY_DIFFER

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
        say(f"apart: {one.name}: staged {one.staged:.4g}, joint {one.joint:.4g} {one.unit}")
    for sentence in both.left_out:
        say(f"not compared: {sentence}")
