"""`trace`: where a stored number came from."""

from typing import TYPE_CHECKING, Annotated

import typer

from autodb.cli._common import (
    Database,
    Json,
    opened_store,
    say_json,
    show,
)
from autodb.cli._reader import in_english

if TYPE_CHECKING:
    from rich.tree import Tree

    from autodb.agent.answer.traced_forces import Node

Kind = Annotated[
    str,
    typer.Argument(
        help="prediction, parameters, force, calibration, model, scale, mismatch or recording."
    ),
]


def trace_command(
    kind: Kind,
    number: Annotated[int, typer.Argument(help="Its number.", min=1, max=2**63 - 1)],
    json: Json = False,
    db: Database = None,
) -> None:
    """Show where a stored number came from, down to recordings."""
    from autodb.agent.answer.tracing import trace

    with in_english(json), opened_store(db) as store:
        node = trace(store, kind, number)
    if json:
        say_json(node)
        return
    show(as_tree(node))


def as_tree(node: "Node") -> "Tree":
    """Return a trace as a tree to print."""
    from rich.text import Text
    from rich.tree import Tree

    tree = Tree(Text(node.text, overflow="fold"))
    for source in node.sources:
        tree.children.append(as_tree(source))
    return tree
