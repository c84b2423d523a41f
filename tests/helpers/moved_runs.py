"""Runs of standard cuts on virtual lathes, in which something is made to move."""

import math
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from autodb.proofs.machines.lathe.lathe import Lathe, cut_row
from autodb.proofs.machines.lathe.process import ALUMINIUM, TrueCut
from autodb.records.tables import EDGE, CutTable, edge_codes
from autodb.standard import CutProtocol, StandardCut, read_protocol, run_order

Array = NDArray[np.float64]

DIAMETER_MM = 60.0
CUT_S, CUTS_AN_EDGE, STEP_S = 8.0, 7, 53.0


@dataclass(frozen=True)
class Move:
    """What has moved by the last cut: shares of gain and force, amperes of offset and friction.

    It comes in proportion to the number of cuts made, or at once ``from_the_end`` cuts before it.
    """

    gain: float = 0.0
    sensor: float = 0.0
    offset_A: float = 0.0
    friction_A: float = 0.0
    force: float = 0.0
    from_the_end: int = 0

    def course(self, count: int) -> Array:
        """Return how far it has come at each cut, 0 to 1, (n,)."""
        if self.from_the_end:
            return np.asarray(np.arange(count) >= count - self.from_the_end, dtype=np.float64)
        return np.linspace(0.0, 1.0, count)


STILL = Move()


def protocol() -> CutProtocol:
    """Return the kit's turning protocol in an order that a cut opens in which Z moves."""
    return read_protocol("turning-aluminium").model_copy(update={"seed": 2})


def run(seed: int, move: Move = STILL, *, noise: float = 1.0, measured: bool = True) -> CutTable:
    """Return the standard cuts of a run on a drawn lathe, with what moved in Z's current.

    ``noise``: of P1's sensing scatter. ``measured``: with a dynamometer's forces. The spindle's own
    drift is left out: only what ``move`` says moves.
    """
    drawn = Lathe.draw(seed)
    lathe = replace(drawn, z=replace(drawn.z, noise_A=noise * drawn.z.noise_A))
    order = run_order(protocol())
    cuts = [_made(cut, number) for number, cut in enumerate(order)]
    rows = [
        cut_row(lathe, ALUMINIUM, cut, seed=(seed, 77, number), share=1.0)
        for number, cut in enumerate(cuts)
    ]
    channels = {name: np.array([row[0][name] for row in rows]) for name in rows[0][0]}
    forces = {name: np.array([row[1][name] for row in rows]) for name in rows[0][1]}
    _move(channels, forces, move)
    return CutTable(
        path=Path("run.csv"),
        channels={**_conditions(cuts), **channels, **(forces if measured else {})},
        texts={
            "operation": [cut.operation for cut in cuts],
            EDGE: [cut.tool_edge for cut in cuts],
        },
    )


def _move(channels: dict[str, Array], forces: dict[str, Array], move: Move) -> None:
    course = move.course(len(channels["z.current.air"]))
    air = channels["z.current.air"]
    rise = channels["z.current.range"] - air
    rise = rise * (1.0 + move.force * course) * (1.0 + (move.gain + move.sensor) * course)
    air = air * (1.0 + move.sensor * course) + move.friction_A * course
    channels["z.current.air"] = air
    channels["z.current.range"] = air + rise + move.offset_A * course
    forces["force.z"] = forces["force.z"] * (1.0 + move.force * course)


def _conditions(cuts: list[TrueCut]) -> dict[str, Array]:
    number = np.arange(len(cuts), dtype=np.float64)
    return {
        "cut": number + 1.0,
        "t": STEP_S * number,
        "cutting.speed": np.array([cut.speed_m_min for cut in cuts]),
        "cutting.feed": np.array([cut.feed_mm for cut in cuts]),
        "cutting.depth": np.array([cut.depth_mm for cut in cuts]),
        "work.diameter": np.array([cut.diameter_mm for cut in cuts]),
        "spindle.speed": np.array([cut.spindle_rpm for cut in cuts]),
        EDGE: edge_codes(cut.tool_edge for cut in cuts),
        "tool.cutting_time": np.array([cut.cutting_time_s for cut in cuts]),
    }


def _made(cut: StandardCut, number: int) -> TrueCut:
    """Return a standard cut as it is made, with edges changed so often that wear stays small."""
    assert cut.depth_mm is not None
    return TrueCut(
        speed_m_min=math.pi * DIAMETER_MM * cut.speed_rpm / 1000.0,
        feed_mm=cut.feed_mm,
        depth_mm=cut.depth_mm,
        diameter_mm=DIAMETER_MM,
        operation=cut.operation,
        tool_edge=f"edge-{number // CUTS_AN_EDGE + 1}",
        cutting_time_s=number % CUTS_AN_EDGE * CUT_S,
        duration_s=CUT_S,
        material=ALUMINIUM.work,
    )


def with_references(table: CutTable) -> CutProtocol:
    """Return the protocol with references: means of the forces that a run measured, cut by cut."""
    whole = protocol()
    said = {"source": "test", "status": "known", "date": "2026-01-01"}
    cuts = []
    for cut in whole.cut:
        rows = np.isclose(table["cutting.feed"], cut.feed_mm)
        rows &= np.isclose(table["cutting.depth"], cut.depth_mm or 0.0)
        rows &= np.isclose(table["spindle.speed"], cut.speed_rpm)
        means = {c: float(np.mean(table[f"force.{c}"][rows])) for c in "xyz"}
        bounds = {c: {"value": v, "lower": v - 0.02 * abs(v), "upper": v + 0.02 * abs(v), **said}
                  for c, v in means.items()}  # fmt: skip
        cuts.append({**cut.model_dump(exclude_none=True), "reference": bounds})
    return CutProtocol.model_validate({**whole.model_dump(exclude={"cut"}), "cut": cuts})
