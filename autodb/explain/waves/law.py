"""The law that a simulated waveform follows, read off: what of it is the chip's, what the edge's.

    F_d = K_d (h/h_0)^p_d + E_d (1 - e^(-h/h_e))    tangential, radial, axial; h_e = 0: E_d

Where that does not give the simulation, its law is a sum of powers of the chip, and what no
thickness changes is the edge's.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Ways = Sequence[int]

UNIT_MM = 0.05
"""Thickness h_0 at which powers are 1."""
THINNEST = 0.02
"""Share of it below which slopes rise no more."""


@dataclass(frozen=True)
class ReadLaw:
    """Forces a mm: ``shear`` (3, k) of powers ``power`` (3, k), ``edge`` (3,) of a round edge."""

    shear: Array
    power: Array
    edge: Array
    round_mm: float

    def of_shear(self, chip_mm: Array, ways: Ways = (0, 1, 2)) -> tuple[Array, Array, Array]:
        """Return what the chip makes of its thickness (m,), in some ways alone."""
        u = np.maximum(chip_mm, 0.0) / UNIT_MM
        return self._each(lambda way: _summed(self.shear[way], self.power[way], u), chip_mm, ways)

    def of_edge(self, chip_mm: Array, ways: Ways = (0, 1, 2)) -> tuple[Array, Array, Array]:
        """Return what the edge makes."""
        rubs = rubbing(chip_mm, self.round_mm)
        return self._each(lambda way: self.edge[way] * rubs, chip_mm, ways)

    def whole(self, chip_mm: Array, ways: Ways = (0, 1, 2)) -> tuple[Array, Array, Array]:
        """Return the law."""
        shear, edge = self.of_shear(chip_mm, ways), self.of_edge(chip_mm, ways)
        return shear[0] + edge[0], shear[1] + edge[1], shear[2] + edge[2]

    def slope(self, chip_mm: Array) -> tuple[Array, Array, Array]:
        """Return its derivative by the thickness, N/mm²."""
        u = np.maximum(chip_mm / UNIT_MM, THINNEST)
        fading = np.zeros_like(chip_mm)
        if self.round_mm:
            fading = np.exp(-chip_mm / self.round_mm) / self.round_mm

        def one(way: int) -> Array:
            powers = self.power[way]
            grown = _summed(self.shear[way] * powers / UNIT_MM, powers - 1.0, u)
            return np.asarray(grown + self.edge[way] * fading)

        return self._each(one, chip_mm, (0, 1, 2))

    @staticmethod
    def _each(
        one: Callable[[int], Array], chip_mm: Array, ways: Ways
    ) -> tuple[Array, Array, Array]:
        t, r, a = (one(k) if k in ways else np.zeros_like(chip_mm) for k in range(3))
        return t, r, a


def _summed(sizes: Array, powers: Array, u: Array) -> Array:
    made = np.zeros_like(u)
    for size, power in zip(sizes, powers, strict=True):
        made += size * u**power
    return made


def rubbing(chip_mm: Array, round_mm: float) -> Array:
    """Return the share of an edge's force that acts under chips; of no chip none."""
    if round_mm:
        return -np.expm1(-np.maximum(chip_mm, 0.0) / round_mm)
    return (chip_mm > 0.0).astype(np.float64)


NOTHING = ReadLaw(np.zeros((3, 1)), np.ones((3, 1)), np.zeros(3), 0.0)
POWERS = (0.35, 0.7, 1.0)
"""Powers of the chip that a law is summed up of where one does not give it."""
TRIED_POWERS = tuple(np.round(np.arange(0.5, 1.101, 0.01), 2).tolist())
TRIED_ROUND_MM = (0.0, 0.002, 0.003, 0.004, 0.005, 0.006, 0.007, 0.008, 0.01, 0.012, 0.015, 0.02)
DRAWN = 1e-9
"""Share of a column's square that its coefficient is drawn to none with."""
PLAIN = 3.0
"""A plain law is taken where it leaves at most so many times what a sum of powers leaves, …"""
SMALL = 1e-4
"""… or this share of the simulation's squares."""


def chip_functions(chip_mm: Array) -> Array:
    """Return every function of the chip (k, m) that a law may be read off with."""
    u = np.maximum(chip_mm, 0.0) / UNIT_MM
    edges = [rubbing(chip_mm, round_mm) for round_mm in TRIED_ROUND_MM]
    return np.array([*edges, *(u**power for power in (*POWERS[:1], *TRIED_POWERS))])


def in_ways(moments: Array) -> Array:
    """Return forces (k, 3, 3, n), of each way, x, y, z, of moments (k, 3, n)."""
    cos, sin, one = np.moveaxis(moments, 1, 0)
    none = np.zeros_like(one)
    ways = ((-cos, sin, none), (-sin, -cos, none), (none, none, one))
    return np.stack([np.stack(way, axis=1) for way in ways], axis=1)


def _least(leaving: Callable[[tuple[int, ...]], float], start: tuple[int, ...]) -> tuple[int, ...]:
    """Return the numbers of TRIED_POWERS, near some, at which least is left; steps get finer."""
    best, least = start, leaving(start)
    for step in (16, 8, 4, 2, 1):
        better = True
        while better:
            better = False
            for way in range(len(best)):
                for by in (-step, step):
                    number = best[way] + by
                    now = (*best[:way], number, *best[way + 1 :])
                    if 0 <= number < len(TRIED_POWERS) and leaving(now) < least:
                        best, least, better = now, leaving(now), True
    return best


def read_off(columns: Array, forces: Array, *, edged: bool) -> ReadLaw:
    """Return the law that gives forces (m,) of columns (k, 3, m) best, with an edge force or not.

    Columns are of ``chip_functions``'s functions in each way.
    """
    flat = columns.reshape(-1, columns.shape[-1])
    inner, right = flat @ flat.T, flat @ forces
    whole = float(forces @ forces)
    first = len(TRIED_ROUND_MM)
    at_power = {power: first + 1 + k for k, power in enumerate(TRIED_POWERS)}
    at_power[POWERS[0]] = first

    def solved(edge: int, powers: Sequence[Sequence[int]]) -> tuple[Array, float]:
        numbers = [3 * edge + way for way in range(3)] if edged else []
        numbers += [3 * power + way for way in range(3) for power in powers[way]]
        some = inner[np.ix_(numbers, numbers)]
        norm = np.sqrt(np.maximum(np.diag(some), 1e-300))
        scaled = some / np.outer(norm, norm) + DRAWN * np.eye(len(norm))
        sizes = np.linalg.solve(scaled, right[numbers] / norm) / norm
        left = whole - 2.0 * sizes @ right[numbers] + sizes @ some @ sizes
        return sizes, max(float(left), 0.0) / max(whole, 1e-300)

    edges = 3 if edged else 0
    none = np.zeros(3 - edges)
    rich = [[at_power[power] for power in POWERS]] * 3
    sizes, leaves = solved(0, rich)
    summed = ReadLaw(
        sizes[edges:].reshape(3, -1),
        np.tile(POWERS, (3, 1)),
        np.concatenate([sizes[:edges], none]),
        0.0,
    )
    tried = []
    powers: tuple[int, ...] = (TRIED_POWERS.index(1.0),) * 3
    for edge in range(first if edged else 1):

        def leaving(at: tuple[int, ...], edge: int = edge) -> float:
            return solved(edge, [[first + 1 + k] for k in at])[1]

        powers = _least(leaving, powers)
        tried.append((leaving(powers), edge, powers))
    left, edge, powers = min(tried)
    if left > max(PLAIN * leaves, SMALL):
        return summed
    plain = solved(edge, [[first + 1 + k] for k in powers])[0]
    power = np.array([[TRIED_POWERS[k]] for k in powers])
    edge_N_mm = np.concatenate([plain[:edges], none])
    return ReadLaw(plain[edges:, None], power, edge_N_mm, TRIED_ROUND_MM[edge])
