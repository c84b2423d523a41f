"""Programs carried out a second time, by hand: time at a feed and volume taken off.

A judge of the readers, which shares no line with them: words by one regular expression, the modes
that most programs have, arcs, drilling cycles, a lathe's radius and a mill's height on grids of
their own. What it does not know (cycles of contours, loops, subprograms) it leaves to the judge of
their own tests, and says so.

    python -m tests.by_hand.programs_apart lathe|mill mm|inch STOCK FILE …

STOCK: a bar's diameter and face (60,0), or a block and the mill (0,100,0,100,-20,0,10).
"""

import re
import sys
from dataclasses import dataclass, field
from math import atan2, ceil, cos, hypot, pi, sin
from pathlib import Path

import numpy as np

WORD = re.compile(r"([A-Z])\s*([+-]?\d*\.?\d+|[+-]?\d+\.)")
BEYOND = re.compile(
    r"[#\[<]|\bM9[78]|\bG65|\bO\d+\s*(SUB|CALL|IF|WHILE)|CYCLE|\bR\d+\s*=|=\s*[A-Z(]|\bG0?7[0-6]\b"
    r"|\bG4[12]\b|\bG5[12]\b|\bG68|,[RC]|\bG10\b|\bG92\s*X|@|\bG33|\bG32|\bG38"
)


@dataclass
class Seen:
    """What is in force, and what has been added up."""

    unit: float
    lathe: bool
    place: list[float | None] = field(default_factory=lambda: [None, None, None])
    motion: int = 0
    plane: int = 17
    absolute: bool = True
    per_rev: bool = False
    diameter: bool = True
    feed: float = 0.0
    speed: float = 0.0
    surface: bool = False
    limit: float = float("inf")
    cycle: dict[str, float] = field(default_factory=dict)
    back: bool = True
    fed_s: float = 0.0
    path: list[tuple[list[float], bool]] = field(default_factory=list)


def beyond(text: str) -> bool:
    """Return whether a program has words that this judge does not know."""
    plain = re.sub(r"\([^()]*\)|;.*", " ", text.upper())
    return BEYOND.search(plain) is not None


def carried(text: str, *, lathe: bool, unit: float, diameter: bool = True) -> Seen:
    """Return a program carried out by hand."""
    seen = Seen(unit=unit, lathe=lathe, per_rev=lathe, diameter=diameter)
    if lathe:
        seen.place[1], seen.plane = 0.0, 18
    for raw in text.upper().splitlines():
        plain = re.sub(r"\([^()]*\)", " ", raw).split(";")[0]
        if plain.strip().startswith("%"):
            continue
        words = [(a, float(b)) for a, b in WORD.findall(plain.lstrip("/"))]
        if words and not one_line(seen, words):
            break
    return seen


def one_line(seen: Seen, words: list[tuple[str, float]]) -> bool:
    """Carry out a line; return whether the program goes on."""
    codes = [number for letter, number in words if letter == "G"]
    said = {letter: number for letter, number in words if letter not in "GMNO"}
    letters = [letter for letter, _ in words]
    for code in codes:
        mode(seen, code)
    if "F" in said:
        seen.feed = said["F"] * seen.unit
    if "S" in said:
        if (50.0 in codes or 92.0 in codes) and not said.keys() & set("XZUW"):
            seen.limit = said["S"]
        else:
            seen.speed = said["S"] * (0.3048 if seen.surface and seen.unit > 1 else 1.0)
    if 96.0 in codes and "D" in said:
        seen.limit = said["D"]
    if set(codes) & {4.0, 10.0, 50.0, 92.0}:
        return True
    if set(codes) & {28.0, 30.0, 53.0}:
        for k, pair in enumerate(("XU", "YV", "ZW")):
            if said.keys() & set(pair) or not said.keys() & set("XYZUVW"):
                seen.place[k] = 0.0 if (k == 1 and seen.lathe) else None
        return True
    if seen.lathe and "T" in said:
        seen.place = [None, 0.0, None]
    turns = seen.motion in (2, 3) and said.keys() & set("IJK")
    if said.keys() & set("XYZUVW") or turns:
        move(seen, said)
    return not any(pair in ((30.0), (2.0)) for a, pair in words if a == "M" and letters)


def mode(seen: Seen, code: float) -> None:
    """Take one G word."""
    if code in (0.0, 1.0, 2.0, 3.0):
        seen.motion, seen.cycle = int(code), {}
    elif code in (73.0, 81.0, 82.0, 83.0, 85.0, 86.0, 89.0):
        seen.cycle = {"G": code, "before": seen.place[2] or 0.0}
    elif code == 80.0:
        seen.cycle = {}
    elif code in (17.0, 18.0, 19.0):
        seen.plane = int(code)
    elif code in (20.0, 21.0):
        seen.unit = 25.4 if code == 20.0 else 1.0
    elif code in (90.0, 91.0):
        seen.absolute = code == 90.0
    elif code in (94.0, 95.0):
        seen.per_rev = code == 95.0
    elif code in (98.0, 99.0) and seen.lathe:
        seen.per_rev = code == 99.0
    elif code in (98.0, 99.0):
        seen.back = code == 98.0
    elif code in (7.0, 8.0) and seen.lathe:
        seen.diameter = code == 7.0
    elif code in (96.0, 97.0):
        seen.surface = code == 96.0


def target(seen: Seen, said: dict[str, float]) -> list[float | None]:
    """Return where a line goes, mm; X of a lathe as a radius."""
    to = list(seen.place)
    for k, (a, b) in enumerate((("X", "U"), ("Y", "V"), ("Z", "W"))):
        scale = seen.unit * (0.5 if k == 0 and seen.lathe and seen.diameter else 1.0)
        here = seen.place[k]
        if a in said:
            to[k] = said[a] * scale + (0.0 if seen.absolute or here is None else here)
        elif b in said and here is not None:
            to[k] = here + said[b] * scale
    return to


def move(seen: Seen, said: dict[str, float]) -> None:
    """Carry out a line with places."""
    to = target(seen, said)
    if seen.cycle:
        hole(seen, said, to)
    elif None in seen.place or None in to:
        seen.place = to
    elif seen.motion in (0, 1):
        go(seen, [one or 0.0 for one in to], cuts=seen.motion == 1)
    else:
        around(seen, said, [one or 0.0 for one in to])


def go(seen: Seen, to: list[float], *, cuts: bool) -> None:
    """Go straight, in steps that are added up."""
    here = [one or 0.0 for one in seen.place]
    length = float(np.linalg.norm(np.subtract(to, here)))
    count = max(ceil(length / 0.1), 1)
    for k in range(1, count + 1):
        at = [a + (b - a) * k / count for a, b in zip(here, to, strict=True)]
        step(seen, at, length / count, cuts=cuts)


def step(seen: Seen, at: list[float], way: float, *, cuts: bool) -> None:
    """Add up one short step."""
    if cuts and way > 0:
        before = seen.place[0] or 0.0
        rpm = seen.speed
        if seen.surface and seen.lathe:
            middle = max(abs(before + at[0]) / 2, 1e-9)
            rpm = min(1000 * seen.speed / (2 * pi * middle), seen.limit)
        seen.fed_s += 60 * way / (seen.feed * rpm if seen.per_rev else seen.feed)
    seen.place = list(at)
    seen.path.append((list(at), cuts))


def around(seen: Seen, said: dict[str, float], to: list[float]) -> None:
    """Go along an arc or a helix, in chords."""
    u, v, w = {17: (0, 1, 2), 18: (2, 0, 1), 19: (1, 2, 0)}[seen.plane]
    here = [one or 0.0 for one in seen.place]
    left = seen.motion == 3
    if "R" in said:
        radius = said["R"] * seen.unit
        half = hypot(to[u] - here[u], to[v] - here[v]) / 2
        off = max(radius * radius - half * half, 0.0) ** 0.5 / (2 * half)
        off *= 1 if left == (radius > 0) else -1
        cu = (here[u] + to[u]) / 2 - off * (to[v] - here[v])
        cv = (here[v] + to[v]) / 2 + off * (to[u] - here[u])
    else:
        cu = here[u] + said.get("IJK"[u], 0.0) * seen.unit
        cv = here[v] + said.get("IJK"[v], 0.0) * seen.unit
    first = atan2(here[v] - cv, here[u] - cu)
    turned = (atan2(to[v] - cv, to[u] - cu) - first) % (2 * pi)
    if hypot(to[u] - here[u], to[v] - here[v]) < 1e-6:
        turned = 2 * pi if left else 0.0
    turned = turned if left else turned - 2 * pi
    start, end = hypot(here[u] - cu, here[v] - cv), hypot(to[u] - cu, to[v] - cv)
    length = hypot(turned * (start + end) / 2, to[w] - here[w])
    count = max(ceil(length / 0.1), 4)
    for k in range(1, count + 1):
        at = [0.0, 0.0, 0.0]
        share = k / count
        radius = start + share * (end - start)
        at[u] = cu + radius * cos(first + share * turned)
        at[v] = cv + radius * sin(first + share * turned)
        at[w] = here[w] + share * (to[w] - here[w])
        step(seen, at, length / count, cuts=True)


def hole(seen: Seen, said: dict[str, float], to: list[float | None]) -> None:
    """Drill a hole, in pecks where there are some."""
    cycle, before = seen.cycle, seen.cycle["before"]
    if "R" in said:
        cycle["R"] = said["R"] * seen.unit + (0.0 if seen.absolute else before)
    top = cycle.get("R", before)
    if "Z" in said:
        cycle["Z"] = said["Z"] * seen.unit + (0.0 if seen.absolute else top)
    if "Q" in said:
        cycle["Q"] = said["Q"] * seen.unit
    x, y = to[0] or 0.0, to[1] or 0.0
    go(seen, [x, y, max(seen.place[2] or 0.0, top)], cuts=False)
    go(seen, [x, y, top], cuts=False)
    at, peck = top, cycle.get("Q", 0.0) if cycle["G"] in (73.0, 83.0) else 0.0
    while at > cycle["Z"] + 1e-9:
        following = max(at - peck, cycle["Z"]) if peck > 0 else cycle["Z"]
        go(seen, [x, y, following], cuts=True)
        if following > cycle["Z"] + 1e-9:
            if cycle["G"] == 83.0:
                go(seen, [x, y, top], cuts=False)
            go(seen, [x, y, following + min(0.254, peck)], cuts=False)
        at = following
    go(seen, [x, y, top], cuts=cycle["G"] in (85.0, 89.0))
    go(seen, [x, y, max(before, top) if seen.back else top], cuts=False)


def turned_mm3(seen: Seen, diameter: float, face: float) -> float:
    """Return the volume that a lathe's path takes off a bar: each step lowers a radius over z."""
    low = min(at[2] for at, _ in seen.path) - 1.0
    cell = 0.02
    radius = np.full(int((face - low) / cell) + 1, diameter / 2)
    begun = float(np.sum(radius**2))
    last: list[float] | None = None
    for at, cuts in seen.path:
        if cuts and last is not None and face > min(at[2], last[2]):
            first, end = sorted((at[2], last[2]))
            span = slice(round((first - low) / cell), round((min(end, face) - low) / cell))
            ahead = slice(round((first - low) / cell), radius.size)
            facing = at[0] < last[0] and abs(end - first) < 1e-6
            if facing and np.all(radius[ahead] > at[0] - 0.1):  # all in front of it
                span = ahead
            radius[span] = np.minimum(radius[span], (abs(at[0]) + abs(last[0])) / 2)
        last = at
    return pi * cell * (begun - float(np.sum(radius**2)))


def milled_mm3(seen: Seen, block: list[float], mill: float) -> float:
    """Return the volume that a mill's path takes off a block: discs stamped into a grid."""
    x0, x1, y0, y1, z0, z1 = block
    cell = mill / 60.0
    xs, ys = np.arange(x0 + cell / 2, x1, cell), np.arange(y0 + cell / 2, y1, cell)
    top = np.full((xs.size, ys.size), z1)
    for at, cuts in seen.path:
        i = slice(*np.searchsorted(xs, [at[0] - mill / 2, at[0] + mill / 2]))
        j = slice(*np.searchsorted(ys, [at[1] - mill / 2, at[1] + mill / 2]))
        if cuts and xs[i].size and ys[j].size:
            near = np.hypot(xs[i, None] - at[0], ys[None, j] - at[1]) <= mill / 2
            top[i, j] = np.where(near, np.minimum(top[i, j], max(at[2], z0)), top[i, j])
    return float(np.sum(z1 - top)) * (x1 - x0) / xs.size * (y1 - y0) / ys.size


def main(kind: str, units: str, stock: str, files: list[str]) -> None:
    """Print for each program what the package and this judge find."""
    from autodb.errors import UnusableInput
    from autodb.files.job import JobProgram
    from autodb.forward import programs

    numbers = [float(one) for one in stock.split(",")]
    lathe, unit = kind == "lathe", 25.4 if units == "inch" else 1.0
    for name in files:
        asked: dict[str, object] = {"file": name, "units": units}
        if lathe:
            asked |= {"stock_diameter_mm": numbers[0], "stock_face_mm": numbers[1]}
        else:
            mill = {"kind": "end_mill", "diameter_mm": numbers[6], "teeth": 4}
            asked |= {"block_mm": numbers[:6], "tools": {"other": mill}}
        try:
            found = programs.follow(JobProgram.model_validate(asked), units=None, diameter=None)
            ours = f"{found.fed_s:.1f} s, {found.removed_mm3 / 1000:.2f} cm³"
        except UnusableInput as error:
            ours = f"refused: {str(error).removeprefix(name)[:160]}"
        text = Path(name).read_text(errors="replace")
        theirs = "beyond this judge"
        if not beyond(text):
            radii = name.endswith(".ngc")
            seen = carried(text, lathe=lathe, unit=unit, diameter=not radii)
            volume = (
                turned_mm3(seen, *numbers[:2])
                if lathe
                else milled_mm3(seen, numbers[:6], numbers[6])
            )
            theirs = f"{seen.fed_s:.1f} s, {volume / 1000:.2f} cm³"
        print(f"{Path(name).name} | {ours} | {theirs}", flush=True)


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2], sys.argv[3], sys.argv[4:])
