"""What a job states of its program, as readers of programs ask for it.

What it states of a call that the program does not make is refused: nothing would come of it.
"""

import numpy as np

from autodb.cutting.stock import Stock
from autodb.cutting.working import tool_number
from autodb.errors import UnusableInput
from autodb.files.job import OTHERS, JobProgram, ProgramTool
from autodb.nc.reading.cycles.stated import Blade, StatedOfProgram, StatedStock, StatedTurning
from autodb.wording import phrase


def left_out_of(asked: JobProgram) -> frozenset[str]:
    """Return the subprograms that a job leaves out, in capitals."""
    return frozenset(name.upper() for name in asked.left_out)


class JobStates:
    """What a job states of a lathe's program, and which of its calls the program makes."""

    def __init__(self, asked: JobProgram, stock: Stock) -> None:
        self.asked = asked
        self.stock = stock
        self.called: set[str] = set()

    def stated(self) -> StatedOfProgram:
        """Return what is stated."""
        stock = self.stock
        reach = StatedStock(
            outer_mm=float(np.max([*stock.low_mm, *stock.high_mm, stock.behind_mm])),
            face_mm=float(stock.edges_mm[-1]),
            bore_mm=0.5 * (self.asked.bore_diameter_mm or 0.0),
        )
        feeds = self.asked.feeds
        return StatedOfProgram(
            lambda name: self._tool(name).kind, self._blade, self._turning, reach,
            None if feeds is None else feeds == "minute", self.asked.speed_rpm,
            left_out_of(self.asked), centres_are_places=self.asked.centres == "places",
        )  # fmt: skip

    def refuse_unused(self) -> None:
        """Raise UnusableInput for a call that is stated and that the program does not make."""
        for line in self.asked.cycle952:
            if line not in self.called:
                raise UnusableInput(
                    phrase(
                        "{file}: line {line} calls no CYCLE952, and program.cycle952.{line} states "
                        "what it does; name the line that calls it",
                        file=self.asked.file,
                        line=line,
                    )
                )

    def _tool(self, name: str | None) -> ProgramTool:
        """Return a tool as the program calls it, by its number, or as all others are."""
        tools = self.asked.tools
        found = tools.get(name or OTHERS, tools.get(tool_number(name) or OTHERS))
        return found or tools.get(OTHERS) or ProgramTool()

    def _blade(self, name: str | None) -> Blade | None:
        tool = self._tool(name)
        if tool.width_mm is None:
            return None
        return Blade(tool.width_mm, tool.width_mm if tool.corner == "away" else 0.0)

    def _turning(self, line: int) -> StatedTurning | None:
        said = self.asked.cycle952.get(f"{line}")
        if said is None:
            return None
        self.called.add(f"{line}")
        return StatedTurning(
            across=said.cut == "across",
            roughs=said.passes != "finishing",
            finishes=said.passes != "roughing",
            by_axes=None if said.allowance is None else said.allowance == "axes",
        )
