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
from autodb.cli._reader import headed, in_english, shown_again
from autodb.wording import amount_words, localized, msgid, phrase, phrase_many, shop_amount

if TYPE_CHECKING:
    from autodb.agent.answer.planning import ProposedCuts
    from autodb.files.job_cut import JobCut

JobFile = Annotated[
    Path,
    typer.Argument(
        readable=False, help="Job file (TOML) whose forces should be known more precisely."
    ),
]


HARDLY = msgid(
    "one more cut hardly helps; the calibration, the law and the scatter of cuts remain uncertain; "
    "make standard cuts and calibrate again to narrow the intervals"
)


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
    with (
        in_english(json),
        opened_machine(db, machine) as (store, name),
        working(f"planning for {name}"),
    ):
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
    from autodb.files.units import typed_number

    low, _, high = text.partition(":")
    ends = (0.0, 0.0)
    if low and high:
        ends = typed_number(f"--{name}", low), typed_number(f"--{name}", high)
    if not 0.0 < ends[0] < ends[1] < 1e6:
        raise UnusableInput(
            phrase(
                "--{name} {text}: is not a range; write LOW:HIGH with 0 < LOW < HIGH",
                name=name,
                text=text,
            )
        )
    return ends


def _show(found: "ProposedCuts") -> None:
    then = headed(phrase("then"), "± %")
    rows = table(
        phrase("Cuts to make next"),
        phrase("operation"),
        *(
            headed(phrase("depth"), "mm"),
            headed(phrase("feed"), "mm"),
            headed(phrase("speed")),
            then,
        ),
    )
    for one in found.proposed:
        rows.add_row(phrase(one.cut.operation), *_words(one.cut), _percent(one.left))
    show(rows)
    say(
        phrase(
            "then: half the 95 % interval of the job's forces after that cut, on average; now ± "
            "{now} %",
            now=_percent(found.now),
        )
    )
    if found.too_much:
        say(
            phrase_many(
                "{count} cut that gives as much information or more may exceed a limit; it is "
                "excluded",
                "{count} cuts that give as much information or more may exceed a limit; they are "
                "excluded",
                found.too_much,
            )
        )
    _show_targets(found)
    if found.hardly:
        say(phrase(HARDLY))
    for statement in found.open:
        say(shown_again(statement))
    if found.not_determined:
        missing = ", ".join(found.not_determined)
        say(
            phrase(
                "not determined by these cuts, nor by what was tried: {numbers}", numbers=missing
            )
        )


def _show_targets(found: "ProposedCuts") -> None:
    """Print how well a job's forces are known now, and after the cut that is proposed first."""
    rows = table(
        phrase("The job after the first of them"),
        *(phrase("cut"), phrase("force")),
        *(headed(phrase("now"), "± %"), headed(phrase("after"), "± %")),
    )
    for target in found.targets:
        its = _percent(target.now), _percent(target.after)
        rows.add_row(target.cut, f"force.{target.component}", *its)
    show(rows)


def _percent(share: float) -> str:
    return localized(f"{100.0 * share:.1f}")


def _words(cut: "JobCut") -> tuple[str, str, str]:
    feed = cut.feed_mm_rev if cut.feed_mm_rev is not None else cut.feed_mm_tooth
    depth = "" if cut.depth_mm is None else _three(cut.depth_mm)
    rpm, m_min = cut.speed_rpm, cut.speed_m_min or 0.0
    speed = amount_words(rpm, "rpm", ".0f") if rpm else amount_words(m_min, "m/min", ".0f")
    return depth, _three(feed or 0.0), speed


def _three(mm: float) -> str:
    """Return a length with three digits, in the reader's unit."""
    return localized(f"{shop_amount(mm, 'mm')[0]:.3g}")
