"""The passive force of a turned cut, which no current shows, from what it left on the part.

In cylindrical turning the radial force pushes work and tool apart, and the part comes out larger:

    ½ (d − d₀) = F (C_work(z) + C_rest) + c

at places z along it: C_work the compliance of the work there, C_rest that of holder, slide and
headstock together, c what setting the tool and wear are off by. Where c is not known, F shows only
in how the error changes along the part; where C hardly changes, F is not sensed.

C_work is that of a round bar in bending (Euler and Bernoulli), I = π d⁴/64: held in a chuck
a³/(3 E I) at a distance a from the jaws; between centres a²(L − a)²/(3 E I L). Source: P1 section
13 names the way (part inspection, its reference 2) for components that no drive senses; formulas
are those of bent beams, integrated anew in the tests. They leave out shear: of a round steel bar in
a chuck 0.54 (d/a)² of the bending, 6 % at a = 3 d.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from autodb.errors import UnusableInput
from autodb.files.part import PartFile
from autodb.fitting.gaussian import NORMAL_95
from autodb.wording import phrase, significant, stored_msgid

Array = NDArray[np.float64]

FEWEST = 3
"""Places that determine a force and what the tool was set off by."""
ALIKE = stored_msgid("the compliance is the same at all places, and the setting is unknown")
TOO_WIDE = stored_msgid(
    "its 95 % interval is {width} wide, and it lies within {range}; measure places that differ "
    "more in compliance, or make the setting more certain"
)


@dataclass(frozen=True)
class RoundBar:
    """A round bar: diameter while it is cut, free length (between centres: all of it), and Young's
    modulus in MPa (steel about 210 000, aluminium 70 000).
    """

    diameter_mm: float
    length_mm: float
    modulus_MPa: float

    @property
    def bending_N_mm2(self) -> float:
        """E I."""
        return float(self.modulus_MPa * np.pi * self.diameter_mm**4 / 64.0)


def held_in_a_chuck(bar: RoundBar, from_jaws_mm: Array) -> Array:
    """Return the compliance (n,), mm/N, at distances from the jaws."""
    return np.asarray(from_jaws_mm**3 / (3.0 * bar.bending_N_mm2))


def between_centres(bar: RoundBar, from_end_mm: Array) -> Array:
    """Return the compliance (n,), mm/N, at distances from one centre."""
    rest = bar.length_mm - from_end_mm
    return np.asarray(from_end_mm**2 * rest**2 / (3.0 * bar.bending_N_mm2 * bar.length_mm))


@dataclass(frozen=True)
class MeasuredPart:
    """Errors of diameter (n,), mm, + where the part is too large, at places of known compliance.

    ``compliance_mm_N`` (n,): of work, tool and machine together; ``share``: its relative sd, of all
    places alike (E, d⁴); ``noise_mm``: sd of one measured diameter; ``setting_mm``: sd of what the
    radius is off by everywhere, infinite where it is unknown.
    """

    error_mm: Array
    compliance_mm_N: Array
    share: float
    noise_mm: float
    setting_mm: float = np.inf


def as_measured(part: PartFile) -> MeasuredPart:
    """Return what a part file says, with the compliance of its bar."""
    bar = RoundBar(part.bar.diameter_mm, part.bar.length_mm, part.bar.modulus_MPa)
    bends = held_in_a_chuck if part.bar.held == "chuck" else between_centres
    measured, place = part.measured, np.array(part.measured.place_mm)
    return MeasuredPart(
        error_mm=np.array(measured.diameter_error_mm),
        compliance_mm_N=bends(bar, place) + part.machine_compliance_mm_N,
        share=part.bar.share,
        noise_mm=measured.noise_mm,
        setting_mm=np.inf if measured.setting_mm is None else measured.setting_mm,
    )


@dataclass(frozen=True)
class Inspected:
    """The passive force and its sd, N, outward; ``off_mm``: what the radius was off by beside it.

    ``own_sd_N``: the part of the sd that other parts of the same work, tool and machine do not
    share. ``why_not``: why it is not sensed, then force and sds are NaN.
    """

    force_N: float
    sd_N: float
    own_sd_N: float
    off_mm: float
    why_not: str | None = None


def passive_force(measured: MeasuredPart, *, range_N: float) -> Inspected:
    """Return the force that a part's errors give, by generalised least squares.

    Not sensed where its 95 % interval is wider than ``range_N``, the range in which it may lie.

    Raises UnusableInput for fewer than FEWEST places, or values that are not finite.
    """
    count = len(measured.error_mm)
    if count < FEWEST or count != len(measured.compliance_mm_N):
        raise UnusableInput(
            phrase(
                "{n} measured diameters are too few; measure {fewest} places along the part",
                n=count,
                fewest=FEWEST,
            )
        )
    if not (np.isfinite(measured.error_mm).all() and np.isfinite(measured.compliance_mm_N).all()):
        raise UnusableInput(phrase("a measured diameter or compliance is no finite number"))
    columns = np.column_stack([measured.compliance_mm_N, np.ones(count)])
    noise = 0.5 * measured.noise_mm
    known = np.diag([0.0, 0.0 if np.isinf(measured.setting_mm) else measured.setting_mm**-2])
    inner = columns.T @ columns / noise**2 + known
    if np.linalg.cond(inner) > 1e15:
        return _not_sensed(ALIKE)
    covariance = np.linalg.inv(inner)
    force, off = covariance @ (columns.T @ (0.5 * measured.error_mm)) / noise**2
    own_sd = float(np.sqrt(covariance[0, 0]))
    sd = float(np.hypot(own_sd, measured.share * force))
    width_N = 2.0 * NORMAL_95 * sd
    if width_N > range_N:
        return _not_sensed(
            TOO_WIDE.format(width=f"{significant(width_N)} N", range=f"{significant(range_N)} N")
        )
    return Inspected(float(force), sd, own_sd, float(off))


def _not_sensed(why: str) -> Inspected:
    return Inspected(np.nan, np.nan, np.nan, np.nan, why)
