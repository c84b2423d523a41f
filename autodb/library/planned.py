"""Results for a planner: how long an edge lasts, to what depth cuts are stable."""

from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any

from autodb.agent.answer.bounds.lives import ToolLives
from autodb.agent.answer.bounds.stable import StableCut, stability_lines
from autodb.files.job import Job
from autodb.library.results import Result, ResultPage, plain

if TYPE_CHECKING:
    import pandas as pd


@dataclass(frozen=True, repr=False)
class ToolLifeResult(Result):
    """How long edges last in jobs; ``lines`` say it, ``why`` of an edge where nobody knows.

    ``answer.first``: of several edges the first to end, and the parts until then.
    """

    answer: ToolLives

    @property
    def lines(self) -> tuple[str, ...]:
        """What the command prints."""
        return self.answer.lines

    def to_pandas(self) -> "pd.DataFrame":
        """Return a row for each edge and limit, the first to end an edge first.

        An edge whose wear is not known has none.

        ``minutes``, ``parts`` and ``path_m`` with ``_low`` and ``_high``; missing: beyond the
        search, or not stated.
        """
        import pandas as pd

        rows = []
        for edge, one in ((its, one) for its in self.answer.edges for one in its.lives):
            row = {"edge": edge.edge or edge.tool, "cut": one.cut, "channel": one.channel}
            row |= {"limit": one.limit, "unit": one.unit}
            for name in ("minutes", "parts", "path_m"):
                ends = getattr(one, name)
                for end, called in (
                    ("value", name),
                    ("low", f"{name}_low"),
                    ("high", f"{name}_high"),
                ):
                    row[called] = None if ends is None else getattr(ends, end)
            rows.append(row | {"sure_minutes": one.sure_min, "sure_parts": one.sure_parts})
        return pd.DataFrame(rows)

    def to_dict(self) -> dict[str, Any]:
        """Return the answer as plain data, as ``life --json`` prints it."""
        return dict(plain(self.answer))


@dataclass(frozen=True, repr=False)
class StabilityResult(Result):
    """To what depth the cuts of ``job`` are stable, beside what the machine's limits allow."""

    answer: tuple[StableCut, ...]
    job: Job

    @property
    def lines(self) -> tuple[str, ...]:
        """What the command prints of the cuts."""
        return stability_lines(self.answer)

    def to_pandas(self) -> "pd.DataFrame":
        """Return a row for each cut: stable depth, chance that it chatters, depth by limits.

        ``depth_mm`` is missing where the cut is stable at any depth.
        """
        import pandas as pd

        rows = []
        for one in self.answer:
            its = one.stable
            row = {"cut": its.name, "speed_rpm": its.speed_rpm, "planned_mm": its.planned_mm}
            for name, ends in (("depth_mm", its.depth_mm), ("any_speed_mm", its.any_speed_mm)):
                known = {} if ends is None else asdict(ends)
                row[name] = known.get("value")
                row |= {f"{name}_{end}": known.get(end) for end in ("low", "high")}
            row |= {"chance": its.chance, "chatter_Hz": its.chatter_Hz}
            rows.append(row | {"loads_mm": None if one.loads is None else one.loads.value})
        return pd.DataFrame(rows)

    def to_dict(self) -> dict[str, Any]:
        """Return the cuts as plain data, as ``stability --json`` prints them."""
        return {"cuts": [plain(one) for one in self.answer]}

    def plot(self) -> ResultPage:
        """Return the lobes of ``stability --plot``."""
        from autodb.reports.planned.lobes import render_lobes

        return ResultPage(render_lobes(self.job, self.answer))
