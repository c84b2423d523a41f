"""`demo`: the whole job on a sample machine."""

from pathlib import Path
from typing import Annotated

import typer

from autodb.cli._common import say, working
from autodb.cli._reader import shown_again
from autodb.wording import phrase


def demo(
    out: Annotated[Path, typer.Option("--out", help="Folder for the demo's files.")] = Path(
        "demo-out"
    ),
) -> None:
    """Run the whole job on a sample machine and write its report."""
    from autodb.cli.start.demo import run_demo

    with working("demo") as progress:
        lines = run_demo(out, progress=progress)
    said = [(f"{phrase(label)}:", shown_again(text)) for label, text in lines]
    width = max(len(label) for label, _ in said)
    for label, text in said:
        say(f"{label:<{width}} {text}")
