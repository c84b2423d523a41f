"""`predictions`: which cuts were made of what was predicted, and how good the predictions were."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from autodb.cli._common import (
    Database,
    Json,
    MachineName,
    SelfContained,
    check_page,
    opened_machine,
    say,
    say_json,
    show,
    table,
)
from autodb.cli._reader import headed, in_english, shown_again
from autodb.wording import localized, phrase

if TYPE_CHECKING:
    from rich.table import Table

    from autodb.agent.matching.scoring import PredictionScores
    from autodb.forward.scored import Score

predictions = typer.Typer(
    help="Predictions and the cuts that were then made: match them, score them.",
    no_args_is_help=True,
)

LARGEST = 2**63 - 1
"""Number that a row can have."""


@predictions.command("score")
def score_command(
    machine: MachineName = None,
    plot: Annotated[
        Path | None,
        typer.Option("--plot", metavar="FILE", help="Write a picture of each cut: FILE.html."),
    ] = None,
    self_contained: SelfContained = False,
    json: Json = False,
    db: Database = None,
) -> None:
    """Say how far off a machine's past predictions were, and how sure they were of it."""
    from autodb.agent.matching.scoring import scores_of_machine

    check_page(plot, option="--plot", self_contained=self_contained)
    with in_english(), opened_machine(db, machine) as (store, name):
        found = scores_of_machine(store, name)
    if plot is not None:
        from autodb.reports.scored import render_scores
        from autodb.reports.written import write_page

        write_page(plot, render_scores(found), self_contained=self_contained)
    if json:
        from pydantic import TypeAdapter

        from autodb.agent.matching.scoring import PredictionScores

        say(TypeAdapter(PredictionScores).dump_json(found, indent=1).decode())
        return
    _show(found)
    if plot is not None:
        say(phrase("picture: {file}", file=plot))


def _show(found: "PredictionScores") -> None:
    """Print the scores, a table for each basis, and what they make of the next intervals."""
    if not found.cuts:
        say(
            phrase(
                "machine '{machine}': no cut was made of a prediction; 'autodb predict' a job, "
                "import its cuts and run 'autodb refresh'",
                machine=found.machine,
            )
        )
        return
    for one in found.by_basis:
        basis = phrase(one.basis)
        show(_score_table(phrase("Predictions from: {basis}", basis=basis), one.scores))
        if one.width.factor > 1.0:
            factor = localized(f"{one.width.factor:.2f}")
            say(
                phrase(
                    "{basis}: × {factor} on the next intervals, all pairs together",
                    basis=basis,
                    factor=factor,
                )
            )
    made, jobs = len(found.cuts), len({cut.prediction for cut in found.cuts})
    what = phrase(
        "cuts that were predicted and made: {made}, of predictions: {count}", made=made, count=jobs
    )
    if found.scored != made:
        what = phrase("{said}; scored: {count}", said=what, count=found.scored)
    say(what)


def _score_table(title: str, scores: "Sequence[Score]") -> "Table":
    """Return how far off predictions were, a row for each quantity."""
    rows = table(
        title,
        phrase("quantity"),
        *(headed(phrase("cuts")), headed(phrase("recordings"))),
        *(headed(phrase("error"), "%"), headed(phrase("bias"), "%")),
        *(headed(phrase("inside 95 % (95 %)")), headed(phrase("RMS of z"))),
    )
    for score in scores:
        rows.add_row(
            score.quantity,
            str(score.cuts),
            str(score.recordings),
            localized(f"{100 * score.error:.1f}"),
            localized(f"{100 * score.bias:+.1f}"),
            phrase(
                "{value} ({low} to {high})",
                value=f"{100 * score.inside:.0f} %",
                low=f"{100 * score.inside_low:.0f}",
                high=f"{100 * score.inside_high:.0f}",
            ),
            localized(f"{score.rms_z:.2f}"),
        )
    return rows


@predictions.command("match")
def match_command(
    machine: MachineName = None,
    recording: Annotated[
        int | None,
        typer.Option(
            "--recording", metavar="NUMBER", min=1, max=LARGEST, help="Whose cuts are meant."
        ),
    ] = None,
    prediction: Annotated[
        int | None,
        typer.Option(
            "--prediction", metavar="NUMBER", min=1, max=LARGEST, help="Of which they were made."
        ),
    ] = None,
    cut: Annotated[
        list[str] | None,
        typer.Option(
            "--cut", metavar="NUMBER=NAME", help="Which cut of the job one of them is; repeatable."
        ),
    ] = None,
    json: Json = False,
    db: Database = None,
) -> None:
    """Match cuts with what was predicted of them: all that are open, or as stated."""
    from autodb.agent.answer.tracing import MATCHED_BY
    from autodb.agent.matching.stated_matches import match_open, match_stated
    from autodb.errors import UnusableInput

    if (recording is None) != (prediction is None):
        raise UnusableInput(phrase("--recording and --prediction go together"))
    if cut and recording is None:
        raise UnusableInput(phrase("--cut goes with --recording and --prediction"))
    with in_english(), opened_machine(db, machine) as (store, name):  # what is found is kept
        if recording is None or prediction is None:
            found = match_open(store, name)
        else:
            found = match_stated(store, name, recording, prediction, dict(map(_named, cut or ())))
    if json:
        say_json(found)
        return
    rows = table(
        phrase("Matched"),
        *(headed(phrase("recording")), headed(phrase("cut")), headed(phrase("prediction"))),
        *(phrase("job"), phrase("its cut"), phrase("by")),
    )
    for one in found.cuts:
        rows.add_row(
            str(one.recording), f"{one.cut:g}", str(one.prediction), one.job, one.name,
            phrase(MATCHED_BY[one.matched_by]),
        )  # fmt: skip
    if found.cuts:
        show(rows)
    for line in found.asked:
        say(shown_again(line))
    if not found.cuts and not found.asked:
        say(phrase("machine '{machine}': no cut is open that a prediction fits", machine=name))


def _named(text: str) -> tuple[float, str]:
    """Return the number of a cut and its name in the job; raises UnusableInput."""
    from autodb.errors import UnusableInput

    number, _, name = text.partition("=")
    try:
        return float(number), name
    except ValueError:
        raise UnusableInput(
            phrase("--cut {text}: use NUMBER=NAME, such as 3='finish'", text=text)
        ) from None
