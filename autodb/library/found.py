"""Results that need no database: what a simulation leaves out, and the terms of an axis."""

from dataclasses import asdict, dataclass, field
from typing import TYPE_CHECKING, Any

from autodb.agent.answer.explaining import KeptCause, Key
from autodb.explain.answer import Explained
from autodb.library.results import Result, ResultPage
from autodb.records.tables import Recording
from autodb.sensing.drives.fit.axis_model import Identified, readable

if TYPE_CHECKING:
    import pandas as pd

OF_CAUSE = ("channel", "kind", "term", "confidence", "statement", "size", "low", "high", "unit")
OF_TERM = ("term", "parameter", "value", "sd", "unit")


@dataclass(frozen=True, repr=False)
class ExplainResult(Result):
    """What a simulation leaves out of a recording.

    ``answer.explanation`` is the answer; ``kept``: of a machine's own models, which mismatch of the
    database each cause is; ``doubts``: what looks like a wrong unit or a clipped sensor.
    """

    answer: Explained
    kept: dict[Key, KeptCause] = field(default_factory=dict)
    doubts: tuple[str, ...] = ()

    @property
    def mismatch(self) -> bool:
        """Whether any channel has one."""
        return any(one.mismatch for one in self.answer.explanation.channels.values())

    def to_pandas(self) -> "pd.DataFrame":
        """Return a row for each cause, with its size and the 95 % interval of that."""
        import pandas as pd

        rows = [
            (channel, one.kind, one.term, one.confidence, one.statement, *_size(one))
            for channel, found in self.answer.explanation.channels.items()
            for one in found.missing
        ]
        return pd.DataFrame(rows, columns=list(OF_CAUSE))

    def corrected(self) -> "pd.DataFrame":
        """Return each explained channel at every row: its simulation and what was found."""
        import pandas as pd

        return pd.DataFrame(self.answer.rows)

    def to_dict(self) -> dict[str, Any]:
        """Return the answer as explanation.json has it."""
        return self.answer.explanation.model_dump(mode="json")

    def plot(self) -> ResultPage:
        """Return the report: what, where, before and after."""
        from autodb.reports.explanation import render_explanation

        return ResultPage(render_explanation(self.answer))


def _size(cause: Any) -> tuple[float, float, float, str]:
    size = cause.parameters["size"]
    return size.value, size.low, size.high, size.unit


@dataclass(frozen=True, repr=False)
class IdentifyResult(Result):
    """The terms of a feed axis, and the ``moves`` that they were identified from.

    ``version``: of the machine's model that they became; None: nothing was stored.
    """

    answer: Identified
    moves: Recording = field(repr=False)
    version: int | None = None

    def to_pandas(self) -> "pd.DataFrame":
        """Return a row for each parameter that got a number, with its standard deviation."""
        import pandas as pd

        rows = [(t.key, t.parameter, t.value, t.sd, t.unit) for t in readable(self.answer.fitted)]
        return pd.DataFrame(rows, columns=list(OF_TERM))

    def to_dict(self) -> dict[str, Any]:
        """Return the terms as plain data, how far off they are, and what got no number."""
        found = self.answer
        return {
            "axis": found.axis,
            "channel": found.channel,
            "unit": found.unit,
            "terms": [asdict(term) for term in found.terms],
            "covariance": found.covariance.tolist(),
            "relative_error": float(found.relative_error),
            "held_out_error": float(found.held_out_error),
            "not_excited": list(found.not_excited),
            "doubts": list(found.doubts),
            "protocol": str(found.protocol),
            "version": self.version,
        }

    def plot(self) -> ResultPage:
        """Return the page of the axis: maps of its effort, its terms, and what is not known."""
        from autodb.reports.axis import render_axis

        return ResultPage(render_axis(self.answer, self.moves))
