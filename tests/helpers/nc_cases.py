"""Protocols and machines that NC programs are tested with: those that ship, and drawn ones."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from autodb.files.machine import MachineFile
from autodb.nc import protocol_program
from autodb.standard import CutProtocol, read_protocol
from tests.helpers import nc

CLEAR_MM = 2.0
LATHE: dict[str, Any] = {
    "diameter": True,
    "spindle": {"max_speed_rpm": 4000},
    "axes": {
        "x": {"limits": {"travel_low_mm": -10, "travel_high_mm": 160}},
        "z": {"limits": {"travel_low_mm": -5, "travel_high_mm": 520}},
    },
    "setup": {
        "tool": 3,
        "spindle": "M4",
        "clearance_mm": CLEAR_MM,
        "max_speed_rpm": 3000,
        "zero": {"x_mm": 1.5, "z_mm": 120},
        "retract": {"x_mm": 150, "z_mm": 300},
        "jaws": {"z_mm": 60, "diameter_mm": 200},
    },
}
MILL: dict[str, Any] = {
    "spindle": {"max_speed_rpm": 8000},
    "axes": {
        "x": {"limits": {"travel_low_mm": 0, "travel_high_mm": 600}},
        "y": {"limits": {"travel_low_mm": 0, "travel_high_mm": 400}},
        "z": {"limits": {"travel_low_mm": 0, "travel_high_mm": 450}},
    },
    "setup": {
        "tool": 7,
        "spindle": "M3",
        "clearance_mm": CLEAR_MM,
        "zero": {"x_mm": 300, "y_mm": 200, "z_mm": 150},
        "retract": {"z_mm": 300},
        "jaws": {"z_mm": 130},
    },
}
SHIPPED = {"turning-aluminium": LATHE, "milling-c45": MILL, "drilling-c45": MILL}


@dataclass(frozen=True)
class Case:
    """A protocol, the machine it is made for, and a dialect."""

    protocol: CutProtocol
    machine: MachineFile
    dialect: str

    @property
    def text(self) -> str:
        """Return its program."""
        return protocol_program(self.protocol, self.machine, dialect=self.dialect, source="m.toml")

    def motions(self, *, skip: bool = True) -> list[nc.Motion]:
        """Return its motions, read back; ``skip`` leaves the dry run out."""
        zero = {k.removesuffix("_mm"): v for k, v in self.setup["zero"].items() if v is not None}
        control = nc.other(zero, lathe=self.protocol.bar is not None)
        if self.dialect == "fanuc" and self.protocol.bar:
            control = nc.fanuc_lathe(zero, diameter=bool(self.machine.diameter))
        return nc.motions(self.text, control, skip=skip)

    @property
    def setup(self) -> dict[str, Any]:
        """Return what is clamped."""
        assert self.machine.setup is not None
        return self.machine.setup.model_dump()


def case_of(name: str, dialect: str) -> Case:
    """Return a shipped protocol on a machine that it fits."""
    return Case(read_protocol(name), MachineFile.model_validate(SHIPPED[name]), dialect)


def changed(case: Case, *path: str, to: Any) -> Case:
    """Return a case whose machine states something else."""
    content = case.machine.model_dump(exclude_none=True)
    part = content
    for key in path[:-1]:
        part = part.setdefault(key, {})
    part[path[-1]] = to
    return Case(case.protocol, MachineFile.model_validate(content), case.dialect)


def bar_case(draw: np.random.Generator, dialect: str) -> Case:
    """Draw turning and facing cuts on a bar, X in diameters or radii."""
    diameter = round(draw.uniform(40, 120), 2)
    length = round(draw.uniform(20, 50), 2)
    cuts = [
        {
            "name": f"cut {i}",
            "operation": str(draw.choice(["turn", "turn", "face"])),
            "speed_rpm": round(draw.uniform(300, 2900)),
            "feed_mm_rev": round(draw.uniform(0.05, 0.4), 3),
            "depth_mm": round(draw.uniform(0.3, 3), 2),
            "repeats": int(draw.integers(1, 5)),
        }
        for i in range(draw.integers(1, 6))
    ]
    bar = {
        "diameter_mm": diameter,
        "least_diameter_mm": round(0.7 * diameter, 2),
        "hub_diameter_mm": round(0.3 * diameter, 2),
        "length_mm": length,
        "least_length_mm": round(0.8 * length, 2),
    }
    air_s = round(draw.uniform(2, 4), 2)
    protocol = {"name": "p", "material": "m", "tool": "t", "air_s": air_s, "bar": bar, "cut": cuts}
    case = Case(CutProtocol.model_validate(protocol), MachineFile.model_validate(LATHE), dialect)
    return changed(case, "diameter", to=bool(draw.integers(2)))


def block_case(draw: np.random.Generator, dialect: str) -> Case:
    """Draw slots in any direction and holes in a block."""
    cuts: list[dict[str, Any]] = []
    for i in range(draw.integers(1, 6)):
        cut: dict[str, Any] = {
            "name": f"cut {i}",
            "speed_rpm": round(draw.uniform(600, 7900)),
            "feed_mm_tooth": round(draw.uniform(0.01, 0.05), 3),
            "length_mm": round(draw.uniform(5, 15), 2),
            "repeats": int(draw.integers(1, 5)),
            "operation": "drill",
        }
        if draw.integers(2):
            cut |= {
                "operation": "slot",
                "depth_mm": round(draw.uniform(0.5, 4), 2),
                "feed_direction_deg": round(draw.uniform(-180, 180), 1),
                "length_mm": round(draw.uniform(15, 40), 2),
            }
        cuts.append(cut)
    size = draw.uniform(70, 150, 2).round(1).tolist()
    block = {"size_x_mm": size[0], "size_y_mm": size[1], "height_mm": 40, "wall_mm": 2}
    geometry = {"diameter_mm": round(draw.uniform(4, 16), 1), "teeth": int(draw.integers(1, 5))}
    common = {"name": "p", "material": "m", "tool": "t", "air_s": 2.5}
    protocol = {**common, "geometry": geometry, "block": block, "cut": cuts}
    return Case(CutProtocol.model_validate(protocol), MachineFile.model_validate(MILL), dialect)
