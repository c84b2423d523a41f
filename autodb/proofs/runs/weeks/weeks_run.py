"""A shop's weeks with autodb: predicted, cut, imported and refreshed, file after file.

A foreman looks at what waits: a mismatch that was open when the last file came in, and names what
happened, he confirms before the next file is predicted; the others he leaves open. A counter of
cutting time that an inferred edge change says is wrong is set back in the next file. Truth of a
prediction is the force that the cut then had, with its own scatter, without errors of sensing.
"""

import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd
from numpy.typing import NDArray
from sqlalchemy import Select, select

from autodb.agent.answer.predicting import predict_job
from autodb.agent.ingest.importing import import_file
from autodb.agent.operate.deciding import confirm
from autodb.agent.operate.refreshing import refresh
from autodb.agent.rows.edges_in_use import inferred_changes
from autodb.agent.rows.machines import add_machine
from autodb.agent.sense.calibrating import calibrate_machine
from autodb.errors import UnusableInput
from autodb.files.job import Job
from autodb.files.job_cut import JobCut
from autodb.files.machine import AxisFile, MachineFile
from autodb.proofs.machines.lathe.weeks import (
    PAIRS,
    TOOLS,
    ShopFile,
    Weeks,
    draw_weeks,
    forces_foreseeable,
    forces_made,
)
from autodb.proofs.runs.weeks.weeks_events import Named, NamedSoFar
from autodb.proofs.runs.weeks.weeks_peers import PEERS
from autodb.store import Store, create_store, models, open_store

Array = NDArray[np.float64]

MACHINE = "lathe"
SCORED = {"y": 1, "z": 2}
"""Components that are sensed in turning along the axis, and their places."""
FEWEST = 6
"""Cuts of a pair from which on the others predict."""
SIDE = '[tool]\nkind = "turning_insert"\nnose_radius_mm = 0.8\nkappa_deg = 93\n'


@dataclass(frozen=True)
class Foreseen:
    """One force of one cut: what was predicted with which 95 % interval, what it was, N.

    ``batch`` from 1; ``peers``: what the others predicted, in the order of PEERS, and ``reads``:
    by what share the pair's forces were read wrongly so far, in the mean; None: too early.
    ``foreseeable``: the mean force by all that the true forces of the files before show.
    """

    batch: int
    pair: int
    component: str
    condition: str
    made: float
    value: float
    low: float
    high: float
    peers: tuple[float, ...] | None
    reads: float | None = None
    foreseeable: float | None = None

    @property
    def held(self) -> bool:
        """Whether the interval held it."""
        return self.low <= self.made <= self.high

    @property
    def error(self) -> float:
        """By what share the prediction was off."""
        return self.value / self.made - 1.0

    @property
    def oracle(self) -> float:
        """What is predicted of true forces so far, as they were read."""
        assert self.foreseeable is not None
        return self.foreseeable * (1.0 + (self.reads or 0.0))


def run_weeks(seed: int) -> list[Foreseen | Named]:
    """Draw the weeks of a seed, go through them and judge."""
    weeks = draw_weeks(seed)
    with tempfile.TemporaryDirectory() as folder:
        url = f"sqlite:///{folder}/weeks.sqlite3"
        create_store(url)
        store = open_store(url)
        try:
            return _Shop(store, Path(folder), weeks).walked()
        finally:
            store.close()


class _Shop:
    """One shop: its database, its folder, and what was sensed so far."""

    def __init__(self, store: Store, folder: Path, weeks: Weeks) -> None:
        self._store, self._folder, self._weeks = store, folder, weeks
        self._found: list[Foreseen] = []
        self._made: dict[tuple[str, float], Array] = {}

    def walked(self) -> list[Foreseen | Named]:
        """Calibrate, then predict, import and refresh every batch."""
        axes = {name: AxisFile(carries="tool") for name in ("x", "z")}
        axes["spindle"] = AxisFile(carries="work")
        add_machine(self._store, MACHINE, MachineFile(diameter=True, axes=axes))
        self._take_in("calibration", self._weeks.calibration)
        calibrate_machine(self._store, MACHINE)
        refresh(self._store, MACHINE)
        named = NamedSoFar(self._weeks)
        for number, drawn in enumerate(self._weeks.batches, start=1):
            batch = self._as_written(drawn)
            for pair in range(len(PAIRS)):
                self._predict(number, batch, pair)
            name = f"batch-{number:02}"
            self._take_in(name, batch.table)
            made = zip(batch.table["cut"].tolist(), forces_made(batch), strict=True)
            self._made |= {(name, float(cut)): forces for cut, forces in made}
            refresh(self._store, MACHINE)
            with self._store.reading() as session:
                due = named.look(session, number)
            for mismatch in due:
                self._confirm(mismatch)
        return [*self._found, *named.outcome()]

    def _as_written(self, batch: ShopFile) -> ShopFile:
        """Return a batch with the counters set back that inferred edge changes say are wrong."""
        with self._store.reading() as session:
            known = [
                one
                for pair in session.scalars(select(models.Pair.id)).all()
                for one in inferred_changes(session, pair)
            ]
        table = {name: values.copy() for name, values in batch.table.items()}
        edge = table["tool.edge"].astype(object)
        for one in sorted(known, key=lambda change: change.used_s):
            same = (batch.table["tool.edge"] == one.edge) & (
                batch.table["tool.cutting_time"] >= one.used_s
            )
            table["tool.cutting_time"][same] = batch.table["tool.cutting_time"][same] - one.used_s
            edge[same] = f"{one.edge} new"
        table["tool.edge"] = edge.astype(str)
        return ShopFile(table, batch.cuts)

    def _confirm(self, number: int) -> None:
        try:
            confirm(self._store, number, by="foreman")
        except UnusableInput:
            return  # another decision of the same moment took its place

    def _take_in(self, name: str, table: dict[str, NDArray[np.generic]]) -> None:
        path = self._folder / f"{name}.csv"
        pd.DataFrame(table).to_csv(path, index=False)
        path.with_suffix(".toml").write_text(SIDE, encoding="utf-8")
        import_file(self._store, path, machine=MACHINE, columns=path.with_suffix(".toml"))

    def _predict(self, number: int, batch: ShopFile, pair: int) -> None:
        """Predict a pair's cuts of a batch, and keep what was foreseen beside what then was."""
        places = [k for k, cut in enumerate(batch.cuts) if cut.pair == pair]
        made, foreseeable = forces_made(batch), forces_foreseeable(batch)
        job = Job(
            name=f"{PAIRS[pair]}, {number}",
            material=PAIRS[pair],
            tool=TOOLS[pair],
            cut=tuple(_asked(batch, k) for k in places),
        )
        predicted = predict_job(self._store, MACHINE, job).cuts
        others = {name: self._others(batch, places, pair, name) for name in SCORED}
        reads = {name: self._reads(pair, name) for name in SCORED}
        for at, (k, cut) in enumerate(zip(places, predicted, strict=True)):
            for name, column in SCORED.items():
                force = getattr(cut, f"force_{name}_N")
                peers = others[name]
                self._found.append(
                    Foreseen(
                        number, pair, name, batch.cuts[k].condition, float(made[k, column]),
                        force.value, force.low, force.high,
                        None if peers is None else tuple(float(one) for one in peers[:, at]),
                        reads[name], float(foreseeable[k, column]),
                    )
                )  # fmt: skip

    def _reads(self, pair: int, component: str) -> float | None:
        """Return by what share a pair's forces so far were read wrongly, in the mean."""
        off = []
        with self._store.reading() as session:
            for cut, value in session.execute(_sensed(pair, component)):
                made = self._made.get((Path(cut.recording.path).stem, cut.number))
                if made is not None and value is not None:
                    off.append(value / made[SCORED[component]] - 1.0)
        return float(np.mean(off)) if len(off) >= FEWEST else None

    def _others(
        self, batch: ShopFile, places: list[int], pair: int, component: str
    ) -> Array | None:
        """Return what the other ways expect of a pair's cuts (ways, n); None: too early."""
        asked = np.array([_numbers({n: v[k] for n, v in batch.table.items()}) for k in places])
        with self._store.reading() as session:
            found = session.execute(_sensed(pair, component)).all()
            rows = [(_numbers(cut.conditions), value) for cut, value in found]
        if len(rows) < FEWEST:
            return None
        cuts = np.array([numbers for numbers, _ in rows])
        force = np.array([value for _, value in rows], dtype=np.float64)
        return np.array([way(cuts, force, asked) for way in PEERS.values()])


def _sensed(pair: int, component: str) -> Select[models.Cut, float | None]:
    """Return the query of a pair's turned cuts and a force that was sensed of each."""
    return (
        select(models.Cut, models.SensedForce.value_N)
        .join(models.SensedForce, models.SensedForce.cut_id == models.Cut.id)
        .join(models.Pair, models.Pair.id == models.Cut.pair_id)
        .join(models.Material, models.Material.id == models.Pair.material_id)
        .where(
            models.Material.name == PAIRS[pair],
            models.SensedForce.component == component,
            models.SensedForce.calibration_id.is_not(None),
            models.SensedForce.value_N > 0.0,
            models.Cut.operation == "turn",
        )
        .order_by(models.Cut.id)
    )


def _asked(batch: ShopFile, k: int) -> JobCut:
    row = {name: values[k] for name, values in batch.table.items()}
    return JobCut(
        name=f"cut {row['cut']}",
        operation="turn",
        diameter_mm=float(row["work.diameter"]),
        depth_mm=float(row["cutting.depth"]),
        feed_mm_rev=float(row["cutting.feed"]),
        speed_m_min=float(row["cutting.speed"]),
        cutting_time_s=float(row["tool.cutting_time"]),
    )


def _numbers(row: dict[str, float]) -> list[float]:
    """Return what the other ways know of a cut."""
    sizes = [row[name] for name in ("cutting.feed", "cutting.depth", "cutting.speed")]
    return [*np.log(np.array(sizes, dtype=np.float64)).tolist(), float(row["tool.cutting_time"])]
