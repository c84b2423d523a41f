"""Cutting forces as they are: rounded edges, hot chips, three stages of wear, real engagements."""

from collections.abc import Callable

import numpy as np

from tests.helpers.truths import Array, Truth, total, truth

SCATTER = {"noise": 0.002, "scatter": 9.2 / 486.0}
"""Of each force: P1's process scatter, 9.2 N at 486 N (physics.md section 9); of the rms of all:
the floor of a dynamometer, chosen."""
K_N_MM2, EDGE_N_MM = 1800.0, 30.0


def cuts(n: int = 160, *, seed: int = 3) -> dict[str, Array]:
    """A table of turning cuts: feeds from the thinnest, depths from the shallowest, all speeds."""
    rng = np.random.default_rng(seed)
    feed = rng.choice([0.015, 0.03, 0.06, 0.1, 0.15, 0.2, 0.3, 0.4], n)
    depth = rng.choice([0.2, 0.4, 0.7, 1.0, 1.5, 2.0, 3.0], n)
    number = np.arange(n, dtype=np.float64)
    seconds = rng.uniform(5.0, 25.0, n)
    edge = np.floor(number / (n / 4))
    begun = np.concatenate([[0.0], np.cumsum(seconds)[:-1]])
    return {
        "force": K_N_MM2 * depth * feed,
        "feed": feed,
        "thickness": feed,
        "depth": depth,
        "speed": np.exp(rng.uniform(np.log(10.0), np.log(300.0), n)),
        "edge": edge,
        "cutting_time": begun - begun[np.searchsorted(edge, edge)],
        "cut": number,
        "t": 2.0 * begun,
    }


def base(table: dict[str, Array]) -> dict[str, Array]:
    """Chip and edge as simulated."""
    return {"shear": table["force"], "edge_force": EDGE_N_MM * table["depth"]}


def shear() -> Truth:
    """Harder than simulated, batch by batch a little different."""
    table = cuts()
    batch = np.random.default_rng(5).normal(0.0, 0.01, 8)[(table["cut"] // 20).astype(int)]
    effect = (1.12 + batch) * table["force"]
    loads = {"edge_force": base(table)["edge_force"]}
    return truth("shear", table, loads, effect, within=0.03, **SCATTER,
                 main=("factor", 1.12, 0.02))  # fmt: skip


def edge_force() -> Truth:
    """A rounded edge: it ploughs less under a chip as thin as its radius."""
    table = cuts()
    effect = EDGE_N_MM * table["depth"] * -np.expm1(-table["thickness"] / 0.005)
    loads = {"shear": table["force"]}
    return truth("edge_force", table, loads, effect, within=0.1, **SCATTER,
                 main=("coefficient", EDGE_N_MM, 0.08))  # fmt: skip


def _worn(seconds: Array) -> Array:
    """Run-in, steady wear, and the beginning of the end: N/mm of depth, (n,)."""
    life = seconds / 600.0
    return np.asarray(12.0 * -np.expm1(-life / 0.08) + 50.0 * life + 12.0 * life**6)


def tool_wear() -> Truth:
    """Three stages of wear on each of four edges."""
    table = cuts()
    effect = table["depth"] * _worn(table["cutting_time"])
    return truth("tool_wear", table, base(table), effect, within=0.2, **SCATTER,
                 modulo=("shear", "edge_force"))  # fmt: skip


def edge_wear() -> Truth:
    """The third of four edges wears three times as fast as the others."""
    table = cuts()
    wear = table["depth"] * _worn(table["cutting_time"])
    own = {f"{e:g}": wear * (table["edge"] == e) * (3.0 if e == 2 else 1.0) for e in range(4)}
    times = {f"{e}.cutting_time": table["cutting_time"] * (table["edge"] == int(e)) for e in own}
    loads = base(table) | {f"tool_wear of one edge@{e}": w for e, w in own.items() if e != "2"}
    return truth("tool_wear of one edge", table | times, loads, own["2"], within=0.15, **SCATTER,
                 of="2", modulo=("shear", "edge_force"))  # fmt: skip


def size_effect() -> Truth:
    """A rounded edge shears thin chips at a blunt angle: a hyperbola of thickness, 1 at 0.2 mm."""
    table = cuts()
    harder = (1.0 + 0.05 / (0.03 + table["thickness"])) / (1.0 + 0.05 / 0.23)
    effect = (harder - 1.0) * table["force"]
    loads = {"shear": table["force"]}
    return truth("size_effect", table, loads, effect, within=0.35, **SCATTER, modulo=("shear",))


def speed_softening() -> Truth:
    """The shear zone warms with the root of speed and softens towards melting; 1 at 100 m/min."""
    table = cuts()
    warm = 25.0 * np.sqrt(table["speed"])
    effect = ((1500.0 - warm) / (1500.0 - 250.0) - 1.0) * table["force"]
    return truth("speed_softening", table, base(table), effect, within=0.3, **SCATTER,
                 modulo=("shear",))  # fmt: skip


def built_up_edge() -> Truth:
    """A raised cosine between 18 and 55 m/min: skewed in the logarithm of speed."""
    table = cuts()
    inside = np.clip((table["speed"] - 18.0) / 37.0, 0.0, 1.0)
    effect = -0.2 * np.sin(np.pi * inside) ** 2 * table["force"]
    return truth("built_up_edge", table, base(table), effect, within=0.2, **SCATTER,
                 main=("centre", 36.5, 0.1), modulo=("shear",))  # fmt: skip


def hard_spot() -> Truth:
    """Cuts 61 to 84 in a harder bar, each by another amount."""
    table = cuts()
    number = table["cut"]
    harder = np.random.default_rng(11).normal(0.25, 0.03, len(number))
    loads = base(table)
    effect = np.where((number >= 61) & (number <= 84), harder, 0.0) * total(loads)
    places = tuple(np.arange(10.0, 160.0, 15.0))
    return truth("hard_spot", table, loads, effect, within=0.2, **SCATTER,
                 main=("factor", 1.25, 0.03),
                 begin_at={"first": places, "last": places})  # fmt: skip


def depth_error() -> Truth:
    """Each cut again 0.08 mm deeper, with a force that is not quite proportional to depth."""
    table = cuts()
    loads = base(table)
    programmed = loads["shear"] + loads["edge_force"]
    effect = programmed * (((table["depth"] + 0.08) / table["depth"]) ** 0.98 - 1.0)
    return truth("depth_error", table, loads, effect, within=0.1, **SCATTER,
                 main=("error", 0.08, 0.08))  # fmt: skip


def deflection() -> Truth:
    """A bar that stiffens as it bends; depth and force settle in turns."""
    table = cuts()
    normal = 0.4 * table["force"] + 90.0 * table["depth"] + 40.0
    real = table["depth"]
    for _ in range(200):
        pressed = normal * real / table["depth"]
        real = table["depth"] - 6e-4 * pressed / (1.0 + pressed / 8000.0)
    loads = base(table)
    effect = total(loads) * (real / table["depth"] - 1.0)
    return truth("deflection", table | {"normal_force": normal}, loads, effect, within=0.15,
                 **SCATTER, main=("compliance", 6e-4, 0.2))  # fmt: skip


RADIUS_MM = 0.8


def elements(depth: float, *, count: int = 400) -> tuple[Array, Array]:
    """Entering angle [rad] and length [mm] of the elements of an engaged edge, (count + 1,).

    A nose of 0.8 mm cut into pieces of equal height, and a straight edge at 92 degrees above it.
    """
    top = min(depth, RADIUS_MM)
    height = (np.arange(count) + 0.5) / count * top
    angle = np.arccos(1.0 - height / RADIUS_MM)
    length = top / count / np.sin(angle)
    lead = np.deg2rad(92.0)
    return np.append(angle, lead), np.append(length, (depth - top) / np.sin(lead))


def over_edges(table: dict[str, Array], each: Callable[[Array], Array]) -> Array:
    """Sum a quantity per length, given the entering angles, over each cut's elements, (n,)."""
    parts = [elements(depth) for depth in table["depth"]]
    return np.array([np.sum(each(angle) * length) for angle, length in parts])


def nose_axial() -> Truth:
    """Thrust of 400 edge elements, those of the nose turned, along the axis."""
    table = cuts()
    loads = base(table)
    effect = K_N_MM2 * table["feed"] * over_edges(table, lambda a: np.sin(a) ** 2) - loads["shear"]
    return truth("nose_radius axial", table, loads, effect, within=0.15, **SCATTER,
                 main=("radius", RADIUS_MM, 0.1), modulo=("shear",))  # fmt: skip


def nose_radial() -> Truth:
    """The same elements' thrust and rubbing along the radius, on a drifting sensor."""
    table = cuts()
    chip = table["feed"] * over_edges(table, lambda a: np.sin(a) * np.cos(a))
    effect = K_N_MM2 * chip + EDGE_N_MM * over_edges(table, np.cos)
    inputs = table | {"z.force": table["force"]}
    return truth("nose_radius radial", inputs, {"sensor_drift": 0.005 * table["t"]}, effect,
                 within=0.1, **SCATTER, main=("radius", RADIUS_MM, 0.2), of="z")  # fmt: skip


def nose_length() -> Truth:
    """The elements' length rubs, not the depth."""
    table = cuts()
    loads = base(table)
    effect = EDGE_N_MM * over_edges(table, np.ones_like) - loads["edge_force"]
    return truth("nose_radius edge length", table, loads, effect, within=0.25, **SCATTER,
                 main=("radius", RADIUS_MM, 0.25), modulo=("edge_force",))  # fmt: skip


def nose_thinning() -> Truth:
    """Every element has the strength of its own thickness, h^-0.4."""
    table = cuts()
    plain = table["force"] * (table["thickness"] / 0.2) ** -0.4
    local = K_N_MM2 * table["feed"] * (table["feed"] / 0.2) ** -0.4
    effect = local * over_edges(table, lambda a: np.sin(a) ** 0.6) - plain
    loads = {"shear": plain, "size_effect": np.zeros_like(plain)}
    return truth("nose_radius thickness", table, loads, effect, within=0.25, **SCATTER,
                 modulo=("shear",))  # fmt: skip


TRUTHS = (
    shear, edge_force, tool_wear, edge_wear, size_effect, speed_softening, built_up_edge, hard_spot,
    depth_error, deflection, nose_axial, nose_radial, nose_length, nose_thinning,
)  # fmt: skip
