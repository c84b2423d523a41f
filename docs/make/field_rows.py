"""Rivals by job: who they are, how they were set up, and the cells of their figure and autodb's."""

from dataclasses import dataclass, replace

from docs.make.cells import Cell
from docs.make.kept import kept

AS_PRINTED = "as printed"


@dataclass(frozen=True)
class Rival:
    """A rival at a job: what of it is judged, its cell and autodb's.

    ``more``: more is better. ``version`` is a cell or words.
    """

    name: str
    version: str | Cell
    setup: str
    figure: str
    theirs: Cell
    ours: Cell
    more: bool = False


@dataclass(frozen=True)
class Contest:
    """Rivals at one job, on data that a sentence names."""

    job: str
    data: str
    rivals: tuple[Rival, ...]


def lathes() -> Contest:
    """Return calibrations of lathes: the published forms."""
    errors = "Median errors on test cuts"
    plans = (("x", "regression"), ("spindle", "ANFIS"), ("z", "regression"))
    return Contest(
        "Force from currents: lathes",
        "Virtual lathes on which the published forms have the published errors (P1).",
        tuple(
            Rival(
                "published regressions",
                AS_PRINTED,
                "forms and plan of cuts of P1",
                f"{axis}, median error",
                ours.beside("as published"),
                ours,
            )
            for axis, ours in ((p[0], Cell("calibration", errors, p, "autodb")) for p in plans)
        ),
    )


def real_lathe() -> Contest:
    """Return calibrations of a real lathe's feed force."""
    whole = kept("vicomtech-peers").tables[0].rows
    ours = Cell("vicomtech-peers", "", whole[0][:2], "RMSE")
    return Contest(
        "Force from currents: a real lathe",
        "Vicomtech's turning table: feed force from drives, each tool sensed by the others. "
        "autodb's `calibrate` has one current. In parentheses: less autodb's error, 95 % over "
        "tools; where 0 lies between, who wins is chance.",
        tuple(
            Rival(
                row[0],
                row[2],
                f"its own settings; {row[1]}",
                f"RMSE ({row[4]})",
                replace(ours, row=row[:2]),
                ours,
            )
            for row in whole[1:]
        ),
    )


def mills() -> Contest:
    """Return forces in the cuts of mills: published steps, network and table."""
    means, networks = "Mean over cuts and axes", "RMSE over"
    way = "Error from the truth"
    return Contest(
        "Force from currents: mills",
        "Virtual mills on which the published ways have the published errors (P0, P4).",
        (
            Rival(
                "four steps (P0)",
                AS_PRINTED,
                "sweep in air, then slots and pockets",
                "mean RMSE, N",
                Cell("mill-forces", means, ("as published",), "RMSE"),
                Cell("mill-forces", means, ("autodb",), "RMSE"),
            ),
            Rival(
                "LSTM (P0)",
                "PyTorch, rebuilt: its code is not public",
                "layers and rows of P0",
                "mean RMSE of 21 tests, N",
                Cell("mill-networks", networks, ("P0's LSTM",), "mean"),
                Cell("mill-networks", networks, ("grey box",), "mean"),
            ),
            Rival(
                "gravity model of a table (P4)",
                AS_PRINTED,
                "upright cuts, then a tilted table",
                "z, N off",
                Cell("table", way, ("P4's model",), "z"),
                Cell("table", way, ("autodb",), "z"),
            ),
        ),
    )


def observers() -> Contest:
    """Return disturbance observers on a real axis."""
    ours = Cell("emps-peers", "", ("reconstruct",), "RMSE")
    theirs = Cell("emps-peers", "", ("Kalman filter",), "RMSE")
    setup = "place, speed and a load that walks; likeliest scatter; low-passed both ways"
    return Contest(
        "Loads from a drive: disturbance observers",
        "EMPS, a real axis: known load pulses, a model of the file without them; up to 10 Hz.",
        (
            Rival(
                "Kalman filter",
                theirs.beside("version"),
                setup,
                "RMSE; ours: `reconstruct`",
                theirs,
                ours,
            ),
            Rival(
                "Kalman filter",
                theirs.beside("version"),
                setup,
                "RMSE; ours: the disturbance observer",
                theirs,
                replace(ours, row=("observe",)),
            ),
        ),
    )


def frictions() -> Contest:
    """Return ways to identify an axis."""
    ways = (
        ("figaroh", "FIGAROH", "joint with viscous and Coulomb friction, drive inertia, offset"),
        ("stribeck", "Stribeck's curve", "viscous, inertia, weight; least squares, four starts"),
        ("sindy", "STLSQ", "21 laws of friction, threshold and ridge held out"),
        ("frols", "FROLS", "products of up to three signals, number of terms held out"),
        ("boosting", "boosted trees", "place, speed, acceleration, direction; its own settings"),
    )
    ours = Cell("axis-peers", "", ("autodb",), "median")
    field = Cell("axis-field", "All ways", ("y", "autodb"), "measured")
    contour = replace(field, column="contour")
    published = ("y", "as published")
    return Contest(
        "Friction identification",
        "Virtual axes of `autodb prove axis-intervals`, seeds of their own: the current of steady "
        "motion at four places and speeds, error over Coulomb friction; and the sweeps of P2.",
        (
            *(
                Rival(
                    name,
                    Cell("axis-peers", "", (way,), "version"),
                    setup,
                    "median error",
                    Cell("axis-peers", "", (way,), "median"),
                    ours,
                )
                for way, name, setup in ways
            ),
            Rival(
                "seven parameters (P2)",
                AS_PRINTED,
                "the published sweep and fit",
                "y, off the measured field",
                replace(field, row=published),
                field,
            ),
            Rival(
                "seven parameters (P2)",
                AS_PRINTED,
                "the same, a contour on another day",
                "y, off the current",
                replace(contour, row=published),
                contour,
            ),
        ),
    )


CONCEALED = {
    "STLSQ, expert": "forms of every effect that can be hidden; threshold and ridge held out",
    "STLSQ, cubic": "cubic products of all signals; threshold and ridge held out",
    "boosted": "stopped early on blocks held out",
    "Gaussian": "400 rows, a length for each signal",
    "gplearn": "20 generations of 1000; parsimony held out",
    "gp-elite": "all operators, thorough; formula held out",
    "adcd": "one correction in one signal, its own templates",
    "FROLS, expert": "forms of every effect that can be hidden; number of terms held out",
    "FROLS, cubic": "cubic products of all signals; number of terms held out",
}
"""How a method on concealed cases was set up, by a part of its label."""


NAMING = (
    ("greedy search", "numpy", "greedy, all columns", ", orthogonal"),
    ("SysIdentPy: FROLS", "0.9.0", "FROLS (SysIdentPy)", "; number of terms held out"),
    ("pysindy: STLSQ", "2.1.0", "STLSQ (pysindy)", "; threshold and ridge held out"),
)
"""Methods on the cases of the proof of real axes: name, version, row of the table, set up."""


def physics() -> Contest:
    """Return ways to find missing physics."""
    ours = Cell("real", "Other methods", ("autodb explain",), "named")
    others = Cell("real-peers", "", (), "named")
    return Contest(
        "Missing physics",
        "Fixed cases of `explain` with something hidden that can show; and real axes with an "
        "effect added or left out.",
        (
            *(
                _concealed(of, row[0], names=row[2] != WORDLESS)
                for of in ("peers", "frols")
                for row in kept(of).tables[0].rows[1:]
            ),
            *(
                Rival(
                    name,
                    version,
                    f"the columns that the effects are made of{setup}",
                    figure,
                    replace(others, row=(way,), column=column),
                    replace(ours, column=column),
                    more,
                )
                for name, version, way, setup in NAMING
                for figure, column, more in (
                    ("real axes: named", "named", True),
                    ("real axes: wrong names", "wrong", False),
                )
            ),
        ),
    )


def _concealed(of: str, label: str, *, names: bool) -> Rival:
    """Return a method's row: its exact sets where it names anything, else the errors left."""
    figure, column = ("exact sets", "exact") if names else ("error left ≤ 0.5", "error left")
    theirs = Cell(of, "All cases", (label,), column)
    ours = replace(theirs, row=(kept(of).tables[0].rows[0][0],))
    setup = next(text for part, text in CONCEALED.items() if part in label)
    package, version, what = label.split(" ", 2)
    return Rival(f"{package}: {what}", version, setup, figure, theirs, ours, more=True)


def laws() -> Contest:
    """Return ways to learn what a pair of work and tool needs."""
    curve, beside = "Median error of the next", "Least squares beside it"
    found = []
    for name, component in (("cutting", "force.y"), ("feed", "force.z")):
        ours = Cell("pair-curve", curve, ("autodb", component), "5 cuts")
        figure = f"{name} force after five cuts"
        found += [
            Rival(
                "Kienzle's law",
                "numpy",
                "log-linear least squares",
                figure,
                replace(ours, row=("Kienzle", component)),
                ours,
            ),
            Rival(
                "nearest cut",
                "numpy",
                "in proportion to a_p f",
                figure,
                replace(ours, row=("nearest cut, by a_p f", component)),
                ours,
            ),
            Rival(
                "boosted trees",
                "scikit-learn",
                "over logarithms, its own settings",
                figure,
                Cell("pair-peers", "", ("boosted trees (scikit-learn)", component), "5 cuts"),
                Cell("pair-peers", "", ("autodb", component), "5 cuts"),
            ),
        ]
    rows = (
        ("all forces of three laws: error", ("everywhere", "all"), "error", "Kienzle with speed"),
        (
            "feed force below 0.1 mm, outside",
            ("outside", "f < 0.1 mm, force.z"),
            "error",
            "Kienzle with speed",
        ),
        ("cutting force, inside: score", ("inside", "force.y"), "score", "Kienzle with speed"),
    )
    for figure, row, column, rival in rows:
        ours = Cell("pair-laws", beside, row, column)
        theirs = replace(ours, column=rival, after=column)
        name, setup = "Kienzle's law with speed", "log-linear least squares"
        found.append(Rival(name, "numpy", setup, figure, theirs, ours))
    return Contest(
        "Kienzle fits",
        "Virtual pairs of other laws than autodb's, cuts read with the gain of a calibration. "
        "Inside and outside: of the range of 24 cuts. Published tables are real.",
        (*found, *map(_power_law, ("6", "12"))),
    )


def _power_law(cuts: str) -> Rival:
    """Return what a paper's fit does with published tables after so many cuts."""
    ours = Cell("pair-tables", "All components", (cuts, "autodb"), "error (rms)")
    setup = "log-linear least squares, feed, depth, speed"
    figure = f"published tables after {cuts} cuts: error"
    theirs = replace(ours, row=(cuts, "power law"))
    return Rival("power law of each component", "numpy", setup, figure, theirs, ours)


def weeks() -> Contest:
    """Return ways to predict a shop's weeks."""
    errors, setups = (
        "Error (rms)",
        {
            "Kienzle's line": "least squares over feed, depth, speed",
            "nearest neighbours": "five, of the pair's cuts so far",
            "boosted trees": "100 of four leaves, those and the edge's time",
        },
    )
    return Contest(
        "Planning: forces before the cuts come in",
        "Virtual shops' weeks in files of cuts, with wear, built-up edges, hard bars and axes that "
        "drift: error (rms) after five files.",
        tuple(
            Rival(
                rival,
                "numpy",
                setup,
                force,
                Cell("weeks", errors, (force,), rival),
                Cell("weeks", errors, (force,), "autodb"),
            )
            for force in ("cutting force", "feed force")
            for rival, setup in setups.items()
        ),
    )


def sugeno() -> Contest:
    """Return Sugeno systems (ANFIS)."""
    ours = Cell("anfis-peers", "", ("variable projection",), "check")
    pinned = {"anfis-toolbox": "0.2.2", "torchanfis": "0.1.0", "anfispy": "1.2.1"}
    setups = (
        "bells, least squares and Adam, 500 epochs",
        "Gaussians, hybrid, 2000 epochs",
        "bells, Adam, 3000 epochs",
    )
    return Contest(
        "Sugeno systems (ANFIS)",
        "Jang's Mackey-Glass series, 500 rows learnt, 500 others: RMSE. 16 rules for all.",
        tuple(
            Rival(name, version, setup, "RMSE, rows not learnt", replace(ours, row=(name,)), ours)
            for (name, version), setup in zip(pinned.items(), setups, strict=True)
        ),
    )


WORDLESS = "names nothing"
CONTESTS = (lathes, real_lathe, mills, observers, frictions, physics, laws, weeks, sugeno)
