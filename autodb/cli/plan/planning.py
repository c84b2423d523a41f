"""`plan`: which cut to make next."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from autodb.cli._common import (
    Database,
    Json,
    MachineName,
    opened_machine,
    say,
    show,
    table,
    working,
)

if TYPE_CHECKING:
    from autodb.agent.answer.planning import ProposedCuts
    from autodb.files.job_cut import JobCut

JobFile = Annotated[
    Path,
    typer.Argument(
        readable=False, help="Job file (TOML) whose forces should be known more precisely."
    ),
]


def plan_command(
    job: JobFile,
    machine: MachineName = None,
    feed: Annotated[
        str | None,
        typer.Option("--feed", metavar="LOW:HIGH", help="Feeds to try, mm/rev or mm/tooth."),
    ] = None,
    depth: Annotated[
        str | None, typer.Option("--depth", metavar="LOW:HIGH", help="Depths to try, mm.")
    ] = None,
    speed: Annotated[
        str | None,
        typer.Option("--speed", metavar="LOW:HIGH", help="Cutting speeds to try, m/min."),
    ] = None,
    json: Json = False,
    db: Database = None,
) -> None:
    """Propose the cut, within the machine's limits, after which a job's forces are known best."""
    from autodb.agent.answer.planning import plan_cuts
    from autodb.files.job import read_job

    asked = read_job(job)
    given = {"feed": feed, "depth": depth, "speed": speed}
    ranges = {name: _range(name, text) for name, text in given.items() if text is not None}
    with opened_machine(db, machine) as (store, name), working(f"planning for {name}"):
        found = plan_cuts(store, name, asked, ranges=ranges)
    if json:
        from pydantic import TypeAdapter

        from autodb.agent.answer.planning import ProposedCuts

        say(TypeAdapter(ProposedCuts).dump_json(found, indent=1).decode())
        return
    _show(found)


def _range(name: str, text: str) -> tuple[float, float]:
    """Return the ends of a range; raises UnusableInput where it is none."""
    from autodb.errors import UnusableInput

    low, _, high = text.partition(":")
    try:
        ends = float(low), float(high)
    except ValueError:
        ends = (0.0, 0.0)
    if not 0.0 < ends[0] < ends[1] < 1e6:
        raise UnusableInput(f"--{name} {text}: is not a range; write LOW:HIGH with 0 < LOW < HIGH")
    return ends


def _show(found: "ProposedCuts") -> None:
    rows = table("Cuts to make next", "operation", ">depth mm", ">feed mm", ">speed", ">then ± %")
    for one in found.proposed:
        rows.add_row(one.cut.operation, *_words(one.cut), f"{100.0 * one.left:.1f}")
    show(rows)
    say(
        "then: half the 95 % interval of the job's forces after that cut, on average; now ± "
        f"{100.0 * found.now:.1f} %"
    )
    if found.too_much:
        say(
            f"{found.too_much} cuts that give as much information or more may exceed a limit; "
            "they are excluded"
        )
    rows = table("The job after the first of them", "cut", "force", ">now ± %", ">after ± %")
    for target in found.targets:
        now, after = f"{100.0 * target.now:.1f}", f"{100.0 * target.after:.1f}"
        rows.add_row(target.cut, f"force.{target.component}", now, after)
    show(rows)
    if found.hardly:
        say(
            "one more cut hardly helps; the calibration, the law and the scatter of cuts remain "
            "uncertain; make standard cuts and calibrate again to narrow the intervals"
        )
    for statement in found.open:
        say(statement)
    if found.not_determined:
        missing = ", ".join(found.not_determined)
        say(f"not determined by these cuts, nor by what was tried: {missing}")


def _words(cut: "JobCut") -> tuple[str, str, str]:
    feed = cut.feed_mm_rev if cut.feed_mm_rev is not None else cut.feed_mm_tooth
    depth = "" if cut.depth_mm is None else f"{cut.depth_mm:.3g}"
    speed = f"{cut.speed_rpm:.0f} rpm" if cut.speed_rpm else f"{cut.speed_m_min:.0f} m/min"
    return depth, f"{feed:.3g}", speed
