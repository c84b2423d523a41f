"""Tables of cuts with measured forces: of a truth in another form than the product's, held out."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from sqlalchemy import select

from autodb.agent.ingest.importing import import_file
from autodb.agent.operate.refreshing import refresh
from autodb.agent.rows.catalogue import numbers_of
from autodb.agent.rows.machines import add_machine, find_machine
from autodb.agent.rows.posteriors import as_posterior, latest
from autodb.files.machine import LATHE
from autodb.forward.prediction import COLUMNS, intervals, passive_known
from autodb.pairs.engaged import BY_NAME
from autodb.pairs.forecast import forecast
from autodb.records import source as records
from autodb.records.tables import CutTable
from autodb.store import create_store, models, open_store

Array = NDArray[np.float64]
MACHINE = "lathe"
INSERT = 'kind = "turning_insert"\nnose_radius_mm = 0.8\nkappa_deg = 93.0\n'
SCATTER = 0.025


def power_forces(feed_mm: Array, depth_mm: Array, speed_m_min: Array) -> Array:
    """Return force x, y, z (n, 3) of three power laws, as a table of setting-up cuts would fit.

    The passive force grows less than in proportion to the depth, as a nose makes it.
    """
    slower = (speed_m_min / 150.0) ** -0.08
    return (
        np.column_stack(
            [
                600.0 * feed_mm**0.55 * depth_mm**0.55,
                1900.0 * feed_mm**0.75 * depth_mm,
                750.0 * feed_mm**0.55 * depth_mm**1.05,
            ]
        )
        * slower[:, None]
    )


def drawn_cuts(seed: int, count: int) -> tuple[Array, Array, Array, Array]:
    """Return feed, depth, speed (count,) and forces (count, 3) of drawn cuts that scatter."""
    rng = np.random.default_rng(seed)
    feed, depth = rng.uniform(0.1, 0.4, count), rng.uniform(1.0, 3.0, count)
    speed = rng.uniform(100.0, 250.0, count)
    forces = power_forces(feed, depth, speed)
    return feed, depth, speed, forces * (1.0 + SCATTER * rng.standard_normal(forces.shape))


def write_table(
    path: Path, seed: int, count: int, *, side: str = "", scale: float = 1.0, only: str = "xyz"
) -> Path:
    """Write a table of drawn cuts, with components ``only``, and a side file with ``side``."""
    feed, depth, speed, forces = drawn_cuts(seed, count)
    names = [f"force.{c}" for c in only]
    lines = [",".join(["cut,t,operation,cutting.feed,cutting.depth,cutting.speed", *names])]
    for k in range(count):
        values = [f"{scale * forces[k, COLUMNS[c]]:.6g}" for c in only]
        conditions = f"{k + 1},{60 * k},turn,{feed[k]:.4f},{depth[k]:.4f},{speed[k]:.2f}"
        lines.append(",".join([conditions, *values]))
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    work = '[recording]\nwork = "steel 1"\n[tool]\nname = "insert 1"\n' + INSERT
    path.with_suffix(".toml").write_text(side + work, encoding="utf-8")
    return path


@dataclass(frozen=True)
class HeldOut:
    """Predictions of one component of cuts (m,) that were not learnt, with 95 % ends."""

    measured: Array
    predicted: Array
    low: Array
    high: Array

    @property
    def error(self) -> Array:
        """Relative error (m,)."""
        return np.abs(self.predicted / self.measured - 1.0)

    @property
    def half_width(self) -> Array:
        """Half width of the interval, of what is predicted (m,)."""
        return 0.5 * (self.high - self.low) / np.abs(self.predicted)

    @property
    def held(self) -> float:
        """Share of measured forces within the interval."""
        return float(np.mean((self.measured >= self.low) & (self.measured <= self.high)))


def held_out(table: Path, folder: Path, *, side: str, fold: int, folds: int) -> dict[str, HeldOut]:
    """Learn a table's cuts but every ``folds``-th, and predict those, by component."""
    head, *rows = table.read_text(encoding="utf-8").splitlines()
    parts = {
        "learnt": [row for k, row in enumerate(rows) if k % folds != fold],
        "left": [row for k, row in enumerate(rows) if k % folds == fold],
    }
    for name, some in parts.items():
        (folder / f"{name}.csv").write_text("\n".join([head, *some]) + "\n", encoding="utf-8")
        (folder / f"{name}.toml").write_text(side, encoding="utf-8")
    url = f"sqlite:///{folder}/{fold}.sqlite3"
    create_store(url)
    store = open_store(url)
    add_machine(store, MACHINE, LATHE)
    import_file(store, folder / "learnt.csv", machine=MACHINE)
    refresh(store, MACHINE)
    found = records.read(folder / "left.csv")
    assert isinstance(found, CutTable)
    rows_: list[tuple[str, float, float, float, float]] = []
    with store.reading() as session:
        pair = session.scalars(select(models.Pair)).one()
        row = latest(session, find_machine(session, MACHINE).id, pair.id)
        assert row is not None
        posterior, tool = as_posterior(row), pair.tool
        for k in range(len(found)):
            operation = found.texts["operation"][k]
            stated = {name: float(one[k]) for name, one in found.channels.items()}
            cut = BY_NAME[operation].cuts(numbers_of(tool), [stated], called=tool.name)
            known = passive_known(posterior, operation)
            means = intervals(forecast(posterior, cut), operation=operation, known=known)[0]
            for c, at in COLUMNS.items():
                if f"force.{c}" in found:
                    one = means[at]
                    rows_.append((c, stated[f"force.{c}"], one.value, one.low, one.high))
    store.close()
    return {
        c: HeldOut(*np.array([one[1:] for one in rows_ if one[0] == c]).T)
        for c in sorted({one[0] for one in rows_})
    }


def joined(several: list[dict[str, HeldOut]]) -> dict[str, HeldOut]:
    """Return the held-out cuts of several folds together."""
    return {
        c: HeldOut(*(np.concatenate([getattr(one[c], name) for one in several])
                     for name in ("measured", "predicted", "low", "high")))
        for c in several[0]
    }  # fmt: skip
