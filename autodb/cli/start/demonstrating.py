"""`demo`: the whole job on a sample machine."""

from pathlib import Path
from typing import Annotated

import typer

from autodb.cli._common import say, working


def demo(
    out: Annotated[Path, typer.Option("--out", help="Folder for the demo's files.")] = Path(
        "demo-out"
    ),
) -> None:
    """Run the whole job on a sample machine and write its report."""
    from autodb.cli.start.demo import run_demo

    with working("demo") as progress:
        lines = run_demo(out, progress=progress)
    for line in lines:
        say(line)
