"""Pairs of published tables: learnt from few of a table's cuts, asked for the others' forces.

The cuts of each turned table are dealt by the seed; the first of them teach, as measured forces do
in a shop that states nothing of its tool, and the last ASKED are asked for. Beside autodb, by least
squares in each component alone, what papers fit to such tables and Kienzle's line:

    log F = c + x log f + y log a_p + z log v        log(F/a_p) = c + x log f + z log v

with Student's interval of the next value. A force counts as right as it was printed.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from autodb.forward.prediction import intervals, passive_known
from autodb.pairs.averaging import learn_averaging
from autodb.pairs.engaged import BY_NAME, DEPTH, DIRECTION, FEED, SPEED
from autodb.pairs.forecast import forecast
from autodb.pairs.observed import Observed, PairCuts, X, Y, Z
from autodb.pairs.posterior import GAIN, PairPosterior, Shared
from autodb.pairs.prior import any_metal
from autodb.proofs.cases.tables.published_tables import DRILLING, PublishedTable, published_tables
from autodb.proofs.runs.pairs.laws_peers import line_through

Array = NDArray[np.float64]

COUNTS = (6, 9, 12, 18)
"""Cuts that teach."""
ASKED = 9
"""Cuts asked for: the same after any number that taught."""
AUTODB, POWER_LAW, KIENZLE = "autodb", "power law", "Kienzle with speed"
TABLE_WAYS = (AUTODB, POWER_LAW, KIENZLE)
QUANTITIES = {"force.x": X, "force.y": Y, "force.z": Z}
TURNED_ABOUT = {"fnides": {"force.x": Z, "force.y": X, "force.z": Y}}
"""Whose letters are others: what a component of a table is along the cut."""
GAIN_SHARE, NOISE_SHARE = 0.01, 0.005
"""What is taken for a dynamometer of which nothing is stated, shares of a force and the largest."""


@dataclass(frozen=True)
class TabledForce:
    """A force that a table prints, N, and what each way of TABLE_WAYS expected after ``cuts``.

    ``size``: the mean of the table's forces in the component; ``low``, ``high``: the interval's
    ends, None where they are not told.
    """

    table: str
    component: str
    cuts: int
    force: float
    size: float
    value: tuple[float, ...]
    low: tuple[float | None, ...]
    high: tuple[float | None, ...]


def run_tables(seed: int) -> list[TabledForce]:
    """Deal the cuts of every turned table by a seed, and foresee the last after so many."""
    tables = [one for one in published_tables().values() if one.name not in DRILLING]
    rng = np.random.default_rng(seed)
    return [
        force
        for table in tables
        for order in [rng.permutation(len(table))]
        for count in COUNTS
        for force in foreseen(table, order[:count], order[-ASKED:])
    ]


def foreseen(
    table: PublishedTable, taught: NDArray[np.intp], asked: NDArray[np.intp]
) -> list[TabledForce]:
    """Return the forces of cuts of a table that are asked for, after those that taught."""
    roles = TURNED_ABOUT.get(table.name, QUANTITIES)
    ours = _ours(table, taught, asked)
    found = []
    for channel, force in table.forces.items():
        plain = [_plain(table, force, taught, asked, depth=depth) for depth in (True, False)]
        told = np.stack([ours[:, roles[channel]], *plain], axis=1)
        found += [
            TabledForce(
                table=table.name,
                component=channel,
                cuts=len(taught),
                force=float(force[cut]),
                size=float(np.mean(force)),
                value=tuple(each[:, 0].tolist()),
                low=tuple(_finite(each[:, 1])),
                high=tuple(_finite(each[:, 2])),
            )
            for cut, each in zip(asked.tolist(), told, strict=True)
        ]
    return found


def _ours(table: PublishedTable, taught: NDArray[np.intp], asked: NDArray[np.intp]) -> Array:
    """Return value, low and high (m, 3, 3) of force x, y, z that autodb expects."""
    posterior = posterior_of_table(table.rows(taught))
    expected = forecast(posterior, _cuts(table.rows(asked)))
    told = intervals(expected, operation="turn", known=passive_known(posterior, "turn"))
    return np.array([[(f.value, f.low, f.high) for f in each[:3]] for each in told])


def posterior_of_table(table: PublishedTable) -> PairPosterior:
    """Return the posterior of a pair after a table's cuts, from what any metal may have."""
    return learn_averaging(any_metal(), _readings(table)).past()


def _readings(table: PublishedTable) -> Observed:
    count, width = len(table), len(table.forces)
    roles = TURNED_ABOUT.get(table.name, QUANTITIES)
    largest = np.max(table.components, axis=1)
    gain = np.array([[GAIN_SHARE**2]])
    return Observed(
        cuts=(_cuts(table),),
        cut=np.repeat(np.arange(count), width),
        quantity=np.tile([roles[one] for one in table.forces], count),
        value=table.components.T.ravel(),
        sd=np.tile(NOISE_SHARE * largest, count),
        common=np.tile(np.eye(width), (count, 1)),
        shared=tuple(Shared(f"{GAIN} of {one}", gain) for one in table.forces),
    )


def _cuts(table: PublishedTable) -> PairCuts:
    each = zip(table.feed.tolist(), table.depth.tolist(), table.speed.tolist(), strict=True)
    rows = [{FEED: f, DEPTH: a, SPEED: v, DIRECTION: 0.0} for f, a, v in each]
    return BY_NAME["turn"].cuts({}, rows, called="tool")


def _plain(
    table: PublishedTable,
    force: Array,
    taught: NDArray[np.intp],
    asked: NDArray[np.intp],
    *,
    depth: bool,
) -> Array:
    """Return value, low and high (m, 3) of a power law; ``depth``: with an exponent of its own."""
    columns = [np.ones(len(table)), np.log(table.feed), np.log(table.speed)]
    known = np.zeros(len(table))
    if depth:
        columns.append(np.log(table.depth))
    else:
        known = np.log(table.depth)
    design = np.column_stack(columns)
    middle, half = line_through(design[taught], (np.log(force) - known)[taught], design[asked])
    middle = middle + known[asked]
    return np.asarray(np.exp(np.stack([middle, middle - half, middle + half], axis=1)))


def _finite(values: Array) -> list[float | None]:
    return [one if np.isfinite(one) else None for one in values.tolist()]
