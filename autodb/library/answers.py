"""Results of a machine: what came in, calibrations, a refresh, forces of cuts."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from io import StringIO
from typing import TYPE_CHECKING, Any

from autodb.agent.answer.looking_up import Listed
from autodb.agent.answer.predicting import JobAnswer, Predicted
from autodb.agent.ingest.importing import Imported
from autodb.agent.learn.passes import RefreshReport
from autodb.agent.sense.calibrating import Calibrated
from autodb.files.machine import AxisLimits
from autodb.library.results import Result, ResultPage, plain
from autodb.standard import CutProtocol

if TYPE_CHECKING:
    import pandas as pd

Limits = Mapping[str, AxisLimits]

OF_A_CUT = ("name", "operation", "spindle.speed", "cutting.speed")
"""What a terminal shows of each cut, beside what was predicted; ``to_pandas`` has all."""


@dataclass(frozen=True, repr=False)
class ImportResult(Result):
    """A recording that came in; ``answer``: its number, rows, cuts and notes."""

    answer: Imported

    def to_pandas(self) -> "pd.DataFrame":
        """Return one row: number, kind, rows, cuts, and whether it was there already."""
        import pandas as pd

        names = ("recording_id", "kind", "rows", "cuts", "already_there")
        return pd.DataFrame([{name: getattr(self.answer, name) for name in names}])

    def to_dict(self) -> dict[str, Any]:
        """Return all that the import did."""
        return asdict(self.answer)


@dataclass(frozen=True, repr=False)
class CalibrateResult(Result):
    """Calibrations of a machine's axes; ``protocol``: the standard cuts that they were made on."""

    answer: Calibrated
    title: str
    protocol: CutProtocol | None = None

    def to_pandas(self) -> "pd.DataFrame":
        """Return a row for each calibration: axis, force, equation, error on cuts left out."""
        import pandas as pd

        return pd.DataFrame(self.to_dict()["calibrations"])

    def to_dict(self) -> dict[str, Any]:
        """Return the calibrations, and sentences why other axes have none."""
        rows = [
            {
                "axis": one.called,
                "force": f"force.{one.component}",
                "equation": one.form.equation(one.coefficients, one.unit, one.current_unit),
                "rmse": float(one.scores.rmse),
                "unit": one.unit,
                "r_squared": float(one.scores.r_squared),
                "cuts": int(one.scores.n),
                "usable": bool(one.offered),
                "verdict": one.verdict,
            }
            for one in self.answer.calibrations
        ]
        return {"calibrations": rows, "left_out": list(self.answer.left_out)}

    def plot(self) -> ResultPage:
        """Return the calibration card."""
        from autodb.reports.card.card_data import card_of_calibrations
        from autodb.reports.card.render import render_card
        from autodb.reports.card.run_course import moved_over

        moved = moved_over(self.answer, self.protocol)
        card = card_of_calibrations(
            self.answer, title=self.title, protocol=self.protocol, moved=moved
        )
        return ResultPage(render_card(card))


@dataclass(frozen=True, repr=False)
class RefreshResult(Result):
    """What a pass of the refresh did: ``answer``, and ``lines`` that say it."""

    answer: RefreshReport

    @property
    def lines(self) -> tuple[str, ...]:
        """What was done, in words."""
        return tuple(self.answer.lines())

    def to_pandas(self) -> "pd.DataFrame":
        """Return a row for each new version of a pair's parameters."""
        import pandas as pd

        return pd.DataFrame(self.answer.versions, columns=["pair", "version", "cuts"])

    def to_dict(self) -> dict[str, Any]:
        """Return all that was done."""
        return asdict(self.answer)


@dataclass(frozen=True, repr=False)
class ForcesResult(Result):
    """The forces of cuts: ``answer`` has the cuts, notes, and limits that they may exceed."""

    answer: JobAnswer
    limits: Limits

    def csv(self) -> str:
        """Return the cuts as CSV, with the columns that docs/formats.md lists."""
        from autodb.forward.predictedfile import prediction_as_csv

        return prediction_as_csv(self.answer.cuts, self.limits)

    def to_pandas(self) -> "pd.DataFrame":
        """Return a row for each cut, with the columns of ``predict --csv``."""
        import pandas as pd

        return pd.read_csv(StringIO(self.csv()))

    def _printed(self) -> "pd.DataFrame":
        """Return a column for each cut: its name, what it does, and quantities with intervals."""
        from autodb.forward.limits import QUANTITIES

        predicted = [f"{one.channel}{end}" for one in QUANTITIES for end in ("", ".low", ".high")]
        cuts = self.to_pandas().set_index("cut")
        shown = [name for name in (*OF_A_CUT, *predicted) if name in cuts]
        return cuts[shown].dropna(axis=1, how="all").T

    def to_dict(self) -> dict[str, Any]:
        """Return the answer as plain data, as ``predict --json`` prints it."""
        return dict(plain(self.answer))


@dataclass(frozen=True, repr=False)
class PredictResult(ForcesResult):
    """The forces of a job, kept in the database under ``answer.prediction_id``."""

    answer: Predicted

    def plot(self) -> ResultPage:
        """Return the picture of ``predict --plot``."""
        from autodb.reports.planned.predicted import render_prediction

        return ResultPage(render_prediction(self.answer, self.limits))


@dataclass(frozen=True, repr=False)
class LookupResult(ForcesResult):
    """The forces of cuts that were looked up: nothing is stored."""

    def plot(self) -> ResultPage:
        """Return a picture of the cuts, with the limits of the machine's axes."""
        from autodb.reports.planned.predicted import render_look_up

        return ResultPage(render_look_up(self.answer, self.limits))


@dataclass(frozen=True, repr=False)
class PairsResult(Result):
    """The work-tool pairs that a machine has learnt."""

    answer: tuple[Listed, ...]

    def to_pandas(self) -> "pd.DataFrame":
        """Return a row for each pair."""
        import pandas as pd

        columns = ["material", "tool", "cuts", "version", "learnt_at"]
        return pd.DataFrame([asdict(one) for one in self.answer], columns=columns)

    def to_dict(self) -> dict[str, Any]:
        """Return the pairs as plain data."""
        return {"pairs": [asdict(one) for one in self.answer]}
