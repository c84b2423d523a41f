"""Changes of tools' edges: what recording one did, and those of a machine."""

from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any

from autodb.agent.operate.changed_edges import EdgeChanged, EdgeOfTool, EdgesOfMachine
from autodb.library.results import Result, plain

if TYPE_CHECKING:
    import pandas as pd


@dataclass(frozen=True, repr=False)
class EdgeChangeResult(Result):
    """What recording a change of an edge did, or undoing it."""

    answer: EdgeChanged

    def to_pandas(self) -> "pd.DataFrame":
        """Return one row: the change, and how many cuts it concerns."""
        import pandas as pd

        return pd.DataFrame([self.to_dict()]).drop(columns="taken_back")

    def to_dict(self) -> dict[str, Any]:
        """Return it as plain data, as ``--json`` of ``edge changed`` prints it."""
        return dict(plain(self.answer))


@dataclass(frozen=True, repr=False)
class EdgesResult(Result):
    """The tools that a machine has cuts of, and recorded changes of their edges."""

    answer: EdgesOfMachine

    def to_pandas(self) -> "pd.DataFrame":
        """Return a row for each change: when, by whom, and what the edge has cut since."""
        import pandas as pd

        columns = list(EdgeOfTool.__dataclass_fields__)
        return pd.DataFrame([asdict(one) for one in self.answer.edges], columns=columns)

    def to_dict(self) -> dict[str, Any]:
        """Return it as plain data, as ``--json`` of ``edge list`` prints it."""
        return dict(plain(self.answer))
