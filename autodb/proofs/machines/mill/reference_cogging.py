"""Cogging of a reference mill's linear motors: periodic over a pole, but no few clean harmonics.

P0 section 2.2: a look-up table was more accurate than a finite Fourier series; section 3.1: what is
left at times has the period of a pole, at times the compensation is too high. So here a pole has
teeth of magnetic force of a few millimetres, and size and place of the teeth change along the
travel. Position mm; force N.
"""

import math
from dataclasses import dataclass

import numpy as np

from autodb.proofs.machines.lathe.process import Array

TEETH = 6  # of a pole; chosen
WIDTHS_MM = (0.4, 1.0)  # of a tooth; chosen
WAVES_MM = (90.0, 400.0)  # over which poles differ; chosen
SHIFT_MM = (0.1, 0.4)  # of the poles' places; chosen


@dataclass(frozen=True)
class MotorCogging:
    """Teeth (place mm, width mm, height) of a pole, its rms force N, and how poles differ.

    ``changes``: share of the size, ``shifts_mm`` of the place, over waves (mm, rad) each.
    """

    pitch_mm: float
    rms_N: float
    teeth: tuple[tuple[float, float, float], ...]
    changes: tuple[tuple[float, float, float], ...]
    shifts_mm: tuple[tuple[float, float, float], ...]

    def force_N(self, x_mm: Array) -> Array:
        """The force at places (n,)."""
        grid = np.arange(2048) * self.pitch_mm / 2048
        shape = self._pole(grid)
        scale = self.rms_N / float(np.std(shape))
        at = x_mm + _sum(self.shifts_mm, x_mm)
        pole = scale * (self._pole(at) - float(np.mean(shape)))
        return np.asarray(pole * (1.0 + _sum(self.changes, x_mm)))

    def _pole(self, x_mm: Array) -> Array:
        """Teeth of a periodic pole: 1/cosh of the way over the width."""
        total = np.zeros_like(x_mm)
        for place_mm, width_mm, height in self.teeth:
            off = (x_mm - place_mm + 0.5 * self.pitch_mm) % self.pitch_mm - 0.5 * self.pitch_mm
            total += height / np.cosh(off / width_mm)
        return total


def _sum(waves: tuple[tuple[float, float, float], ...], x_mm: Array) -> Array:
    return np.asarray(
        sum(
            (size * np.sin(2.0 * math.pi * x_mm / mm + rad) for size, mm, rad in waves),
            start=np.zeros_like(x_mm),
        )
    )


def draw_cogging(
    rng: np.random.Generator, *, pitch_mm: float, rms_N: float, change: float
) -> MotorCogging:
    """Cogging whose poles differ by about a share; every range is chosen."""
    teeth = tuple(
        (
            pitch_mm * (tooth + rng.uniform(0.2, 0.8)) / TEETH,
            rng.uniform(*WIDTHS_MM),
            (1.0 if tooth % 2 else -1.0) * rng.uniform(0.3, 1.0),
        )
        for tooth in range(TEETH)
    )
    return MotorCogging(
        pitch_mm=pitch_mm,
        rms_N=rms_N,
        teeth=teeth,
        changes=_waves(rng, (0.7 * change, 1.3 * change)),
        shifts_mm=_waves(rng, SHIFT_MM),
    )


def _waves(
    rng: np.random.Generator, sizes: tuple[float, float]
) -> tuple[tuple[float, float, float], ...]:
    return tuple(
        (rng.uniform(*sizes), rng.uniform(*WAVES_MM), rng.uniform(-math.pi, math.pi))
        for _ in range(2)
    )
