"""`sensors`: what a machine can feel, how well, since when."""

from typing import Annotated

import typer

from autodb.cli._common import Database, opened_store, say, show, table


def sensors_command(
    name: Annotated[str, typer.Argument(help="Name of the machine.")], db: Database = None
) -> None:
    """List what a machine feels forces with, how near each comes, and since when."""
    from autodb.agent.sense.sensors import sensors_of

    with opened_store(db) as store, store.reading() as session:
        found, unfelt = sensors_of(session, name)
    rows = table(
        f"What {name} feels", "force", "with", "of", ">version", ">error", "in", "since", "",
    )  # fmt: skip
    for one in found:
        error = "" if one.error is None else f"{one.error:.3g} {one.unit}"
        rows.add_row(
            one.force, one.kind, one.source, str(one.version), error, one.of, one.since[:10],
            f"not used: {one.why_not}" if one.why_not else "",
        )  # fmt: skip
    if found:
        show(rows)
    if unfelt:
        say(f"nothing feels {', '.join(unfelt)}: not sensed, never taken as 0")
