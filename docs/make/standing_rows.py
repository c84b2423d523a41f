"""What the page *Where it stands* asks of every job: its figures, each with what stands beside it.

Every figure is a cell; words say what it is. Where the limit of a row is asked of another cell,
that one is ``judged``.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

from docs.make.cells import VERDICTS, Cell
from docs.make.kept import kept

FROLS = "FROLS (SysIdentPy)"
GREEDY = "greedy search with the generator's own columns"
LEVEL = "95 % limit"


@dataclass(frozen=True)
class Figure:
    """A figure of a job.

    ``text`` has the value as {0} and what is judged as {1}; ``limit`` the limits of both alike.
    ``interval`` and ``cases`` stand behind the value; ``rival`` is a name and its cell.
    """

    job: str
    what: str
    value: Cell
    judged: Cell | None = None
    text: str = "{0}"
    limit: str = ""
    interval: Cell | None = None
    cases: Cell | None = None
    rival: tuple[str, Cell] | None = None
    oracle: Cell | None = None

    @property
    def said(self) -> str:
        """The figure as the page has it."""
        return self.text.format(self.value.text, self._asked.text)

    @property
    def must_be(self) -> str:
        """Its limit as the page has it."""
        if not self.limit:
            return self._asked.limit.replace("limit ≥", f"{LEVEL} ≥").replace(
                "limit ≤", f"{LEVEL} ≤"
            )
        own = self.value.limit if "{0}" in self.limit else ""
        asked = self._asked.limit if "{1}" in self.limit else ""
        return self.limit.format(own, asked)

    @property
    def verdict(self) -> str:
        """Whether it is met, as the page has it: what is judged, and the value itself."""
        missed = VERDICTS["FAILED"]
        found = {self.value.verdict, self._asked.verdict}
        return missed if missed in found else self._asked.verdict

    @property
    def missed(self) -> bool:
        """Say whether its limit is missed."""
        return self.verdict == VERDICTS["FAILED"]

    @property
    def cases_or_runs(self) -> str:
        """How many cases are behind it; of a whole proof its runs."""
        return self.cases.text if self.cases else str(kept(self.value.of).runs)

    @property
    def _asked(self) -> Cell:
        return self.judged or self.value


def calibrated() -> list[Figure]:
    """Return figures of forces from currents."""
    job, errors = "Calibration: forces from currents", "Median errors on test cuts"
    beside = "Error over the published calibration's"
    found = []
    for axis, name in (("x", "X"), ("spindle", "the spindle"), ("z", "Z")):
        row = (axis, "regression")
        value = Cell("calibration", errors, row, "autodb")
        ratio = value.beside("× oracle")
        found.append(
            Figure(
                job,
                f"Force on {name} of a lathe, median error",
                value,
                judged=Cell("calibration", beside, row, "autodb"),
                text=f"{{0}} ({ratio.text} × oracle's); {{1}} × the published way's",
                limit=f"{ratio.limit} × oracle's; × the published way's: {{1}}",
                rival=("published way", value.beside("as published")),
                oracle=value.beside("oracle"),
            )
        )
    slot, pocket = ("slot, slanting", "y"), ("pocket", "x")
    return [
        *found,
        *(
            Figure(
                job,
                f"Force of a mill's linear drives, {row[0]}, {row[1]}, RMSE",
                Cell("mill-forces", "autodb: RMSE", row, "autodb N"),
                judged=Cell("mill-forces", "autodb: RMSE", row, "× published"),
                text="{0} N ({1} × published)",
                limit="{1} × published",
                rival=(
                    "published way, N",
                    Cell("mill-forces", "All ways", (*row, "as published"), "RMSE"),
                ),
                oracle=Cell("mill-forces", "All ways", (*row, "truth of the sweep"), "RMSE"),
            )
            for row in (slot, pocket)
        ),
        Figure(
            job,
            "Force in a mill's cuts by the grey box, mean RMSE",
            Cell("mill-networks", "Limits", ("mean of the grey box",), "found"),
            rival=(
                "published network (LSTM), N",
                Cell("mill-networks", "RMSE over", ("P0's LSTM",), "mean"),
            ),
        ),
        Figure(
            job,
            "Force along z on a table that tilts, × the published model's error",
            Cell("table", "Limits", ("tilted cuts: z, × P4's",), "found"),
            rival=(
                "published model, N",
                Cell("table", "Error from the truth", ("P4's model",), "z"),
            ),
            oracle=Cell("table", "Error from the truth", ("the table's own forms",), "z"),
        ),
    ]


def _held_beside_oracle(job: str, name: str, of: str, row: str) -> Figure:
    held = Cell(of, "", (row,), "held the truth")
    return Figure(
        job, f"95 % intervals of {name} that hold", held, judged=held.beside("score"),
        text="{0}, score {1} × oracle's", limit="{0}, score {1}", interval=held.beside("exact"),
        oracle=held.beside("oracle held"),
    )  # fmt: skip


def driven() -> list[Figure]:
    """Return figures of axes that move in air."""
    job, field = "Drives: what an axis needs in air", "autodb, median"
    quantities = (
        ("all quantities", "all quantities"),
        ("the inertia", "inertia"),
        ("the friction at 50 mm/s", "friction at +50 mm/s"),
    )

    def way(axis: str, name: str, column: str) -> Cell:
        return Cell("axis-field", "All ways", (axis, name), column)

    currents = Cell("axis-peers", "", ("autodb",), "median")
    return [
        Figure(
            job,
            "Current of steady motion, median error over Coulomb friction",
            currents,
            rival=("best of five packages", currents.beside("must be")),
            oracle=Cell("axis-peers", "", ("oracle",), "median"),
        ),
        *(
            _held_beside_oracle(job, f"{name} of an axis", "axis-intervals", row)
            for name, row in quantities
        ),
        *(
            Figure(
                job,
                f"Friction field of {axis} after a sweep, off by",
                Cell("axis-field", field, (axis,), "field"),
                rival=("published way", way(axis, "as published", "measured")),
                oracle=way(axis, "oracle", "measured"),
            )
            for axis in "xz"
        ),
        *(
            Figure(
                job,
                f"Current of a contour on another day, {axis}, off by",
                Cell("axis-field", field, (axis,), "contour"),
                rival=("published way", way(axis, "as published", "contour")),
                oracle=way(axis, "oracle", "contour"),
            )
            for axis in "xyz"
        ),
        Figure(
            job,
            "Linear drives (y) whose pitch of cogging is found",
            Cell("mill-forces", "What autodb keeps", ("y",), "pole"),
            limit="all",
        ),
        Figure(
            job,
            "Recordings silently wrong, whatever their time stamps",
            Cell("stamps", "Limits", ("silently wrong",), "share"),
            interval=Cell("stamps", "Limits", ("silently wrong",), "exact"),
            cases=Cell("stamps", "Limits", ("silently wrong",), "cases"),
        ),
    ]


def _held_by_laws(job: str, what: str, row: tuple[str, str]) -> Figure:
    held = Cell("pair-laws", "Forces of the next", row, "held")
    kienzle = Cell("pair-laws", "Least squares beside it", row, "Kienzle held")
    return Figure(
        job, what, held, interval=held.beside("exact"), cases=held.beside("pairs"),
        rival=("Kienzle's law, where it answers", kienzle),
    )  # fmt: skip


def _of_tables(job: str) -> list[Figure]:
    held, error = (
        Cell("pair-tables", "Limits", (f"{what} after 12 cuts",), "found")
        for what in ("held", "error over the power law's")
    )
    rival = "power law", Cell("pair-tables", "All components", ("12", "power law"), "held")
    learnt = "Forces of published tables, learnt from 12 of their cuts: intervals that hold"
    over = "Error of these forces, over that of a power law of each component"
    return [Figure(job, learnt, held, rival=rival), Figure(job, over, error)]


def paired() -> list[Figure]:
    """Return figures of what work and tool need."""
    job, laws = "Pairs: what work and tool need", "Forces of the next"
    beside = "Least squares beside it"
    passive = "Intervals of passive forces, inside that range, that hold"
    among = "among others, of those alone"
    told = "A new machine", (f"cuts to 10 % {among}",)
    curve, width = "Median error of the next", "of the next cut's force, everything included"
    error = Cell("pair-laws", beside, ("everywhere", "all"), "error")
    return [
        *(
            _held_beside_oracle(job, name, "pairs", row)
            for name, row in (
                ("the next cut's forces", "all quantities"),
                ("the passive force in turning", "turn, force.x"),
            )
        ),
        *(
            Figure(
                job,
                f"{name} after five cuts of a pair, median error",
                Cell("pair-curve", curve, ("autodb", row), "5 cuts"),
                limit="no other way's, by more than a standard error",
                rival=("Kienzle's law", Cell("pair-curve", curve, ("Kienzle", row), "5 cuts")),
            )
            for name, row in (("Cutting force", "force.y"), ("Feed force", "force.z"))
        ),
        Figure(
            job,
            "Proposed cuts that reach what twelve random ones do",
            Cell("pair-curve", "Cuts to a half-width", (width,), "proposed (≤"),
        ),
        _held_by_laws(job, "Intervals outside the range of the cuts that hold", ("outside", "all")),
        replace(
            _held_by_laws(job, passive, ("inside", "force.x")),
            judged=Cell("pair-laws", laws, ("inside", "force.x"), "width × nominal"),
            text="{0}, {1} × as wide as those of who knows the tool",
            limit="{0}, × as wide: {1}",
        ),
        Figure(
            job,
            "Error of forces of pairs with three other laws",
            error,
            limit="below both kinds of least squares",
            cases=error.beside("pairs"),
            rival=("Kienzle's law with speed", error.beside("Kienzle with")),
        ),
        *_of_tables(job),
        Figure(job, f"Cuts that a new machine needs {among}", Cell("fleet", *told, "found")),
    ]


def explained() -> list[Figure]:
    """Return figures of what a simulation left out."""
    job = "Explain: what a simulation left out"

    def share(proof: str, row: str, what: str) -> Figure:
        value = Cell(proof, "Limits", (row,), "share")
        return Figure(job, what, value, interval=value.beside("exact"), cases=value.beside("cases"))

    def found(proof: str, row: str, what: str, rival: tuple[str, Cell] | None) -> Figure:
        return Figure(job, what, Cell(proof, "Limits", (row,), "found"), rival=rival)

    whole = "decidable, d ≥ 8: exactly the hidden terms"
    wrong = Cell("real", "Other methods", ("greedy, all columns",), "wrong")
    return [
        share("explain", whole, "Clear cases that can be decided, named exactly"),
        share(
            "explain",
            "undecidable, d ≥ 8: named or an alternative",
            "Clear cases that nothing decides, named or an alternative",
        ),
        share(
            "explain", "nothing hidden: anything named", "Something named where nothing is missing"
        ),
        share("explain", "d = 4: a wrong name", "Wrong names close to the noise"),
        share(
            "explain",
            "error left ≤ 10 % or 1.5 × the oracle's",
            "Corrected simulations within 10 % or 1.5 × the oracle's error",
        ),
        share("explain-milling", whole, "Milled waveforms that can be decided, named exactly"),
        share(
            "explain-outside",
            "own term that is right called mistuned, all",
            "What a simulation has right, called mistuned",
        ),
        found(
            "real",
            "real and injected: named",
            "Real axes: what is missing is named",
            (FROLS, Cell("real-peers", "", (FROLS,), "named")),
        ),
        found("real", "real and injected: wrong", "Real axes: a wrong name", (GREEDY, wrong)),
        found(
            "real",
            "nulls: own terms within 30 %",
            "Real axes with nothing missing: own terms kept",
            None,
        ),
        found(
            "force-tables",
            "injected: named",
            "Tables of forces, published: what is missing is named",
            (GREEDY, Cell("force-tables", "Other methods", ("greedy, own columns",), "named")),
        ),
    ]


def planned() -> list[Figure]:
    """Return figures of predictions of what is to be cut."""
    job, errors = "Planning: predictions of what is to be cut", "Error (rms)"
    files = "Files predicted"
    return [
        Figure(
            job,
            "Forces of a shop's weeks that intervals hold, predicted before the cuts come in",
            Cell("weeks", files, ("held, all forces",), "found"),
        ),
        *(
            Figure(
                job,
                f"The {name} of those weeks, error (rms) after five files",
                Cell("weeks", files, (f"error of the {name}",), "found"),
                rival=("boosted trees", Cell("weeks", errors, (name,), "boosted trees")),
                oracle=Cell("weeks", errors, (name,), "oracle"),
            )
            for name in ("cutting force", "feed force")
        ),
        Figure(
            job,
            "A day's next cuts, better predicted with the terms found",
            Cell("day", "Predictions of the next", ("with the terms found",), "better"),
        ),
        Figure(
            job,
            "Wear of a day's first edge, named within ten cuts",
            Cell("day", "Events of the day", ("wear of the first edge",), "named within"),
        ),
    ]


def stored() -> list[Figure]:
    """Return figures of what a database keeps."""
    job = "Keeping: what a database holds"
    rows = (
        (
            "Refreshes that ended in other rows after a kill",
            "faults",
            "ended in other rows than undisturbed",
        ),
        (
            "Commands that left something half-written after a kill",
            "faults-commands",
            "something half-written in sight after a kill",
        ),
        (
            "Bits that flipped in a value and were not found",
            "flips",
            "of them not found by `doctor` and `backup` both",
        ),
    )
    return [Figure(job, what, Cell(proof, "", (row,), "found")) for what, proof, row in rows]


JOBS: tuple[Callable[[], list[Figure]], ...] = (
    calibrated,
    driven,
    paired,
    explained,
    planned,
    stored,
)
