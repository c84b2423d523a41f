"""Short forms of an effect without a name: one simple function a variable, one coefficient.

A form is a product: the direction of motion where the effect turns with it, times at most one
function f of each variable, f a power, tanh(d/width), exp(−d/width), a straight line through an
origin or a sine. d is the distance from zero or from an end of what was recorded. A constant may
stand beside it (with the direction where the effect turns). All but one coefficient is fixed by the
form, two for a sine (its phase).
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import product

import numpy as np
from numpy.typing import NDArray

from autodb.explain.engine.normal import HELD
from autodb.fitting.linear import orthonormal_basis

Array = NDArray[np.float64]

POWERS: Mapping[float, str] = {1.0: "{}", 2.0: "{}²", 0.5: "√{}", 1.5: "{}^1.5", 3.0: "{}³"}
"""Exponents, and how they are written."""
WIDTHS = (0.08, 0.25, 0.8)
"""Widths that are looked through, shares of the largest distance."""
WIDER = 2.0
"""A width may be tuned by this factor."""
ORIGINS = (0.1, 0.3, 0.5, 0.7, 0.9)
"""Places of a line's origin that are looked through, shares of the range; tuned half way on."""
WAVES = (1.0, 1.5, 2.0, 3.0)
"""Waves over the range that are looked through where no period was found."""
SPANNED = 1e-6
"""A candidate of which other columns leave less than this share says nothing of its own."""
TOLD_DIGITS = 6
"""Decimals of the best one's gain by which candidates are told apart, however numbers round."""
NEAR_ZERO = 0.05
"""A range that ends this near to zero, a share of its span, ends at zero."""


@dataclass(frozen=True)
class Variable:
    """What an effect depends on: values (n,); ``ends``: a place or a time, which has ends."""

    name: str
    unit: str
    values: Array
    ends: bool

    def rounded(self, value: float) -> float:
        """Return a value with the digits of three significant ones of the largest."""
        largest = float(np.max(np.abs(self.values)))
        return round(value, 2 - int(np.floor(np.log10(largest)))) if largest > 0 else value

    def quantity(self, value: float) -> str:
        """Return a value with unit, as it stands in a sentence."""
        return f"{value:.4g} {self.unit}"


@dataclass(frozen=True)
class FormFactor:
    """A function of one variable: ``law`` gives (n, p) from values (n,) and ``shape``, its values
    by keyword, all in ``unit``; ``say`` writes it; ``within`` are limits of tuning; ``waves``: a
    cosine and a sine, of which ``say`` takes the coefficients too.
    """

    law: Callable[..., Array]
    say: Callable[..., str]
    unit: str
    shape: Mapping[str, float] = field(default_factory=dict)
    within: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    waves: bool = False


@dataclass(frozen=True)
class ProductForm:
    """A product of factors, one of each variable, with a level beside it or none."""

    factors: tuple[FormFactor, ...]
    level: bool = False

    @property
    def shape(self) -> dict[str, float]:
        """The values of all factors by name."""
        return {name: value for f in self.factors for name, value in f.shape.items()}

    @property
    def within(self) -> dict[str, tuple[float, float]]:
        """The limits of all values by name."""
        return {name: limits for f in self.factors for name, limits in f.within.items()}

    @property
    def units(self) -> dict[str, str]:
        """The units of all values by name."""
        return {name: f.unit for f in self.factors for name in f.shape}

    @property
    def names(self) -> tuple[str, ...]:
        """What its coefficients are called."""
        waves = any(f.waves for f in self.factors)
        return (*(("cosine", "sine") if waves else ("coefficient",)), *(["level"] * self.level))

    def columns(self, carrier: Array, values: Sequence[Array], **shape: float) -> Array:
        """Return its columns (n, p) from the carrier (n,), ±1 or 1, and each variable's values."""
        made = carrier[:, None]
        for f, u in zip(self.factors, values, strict=True):
            made = made * f.law(u, **{name: shape[name] for name in f.shape}).reshape(len(u), -1)
        return np.column_stack([made, carrier]) if self.level else made


def written(form: ProductForm, values: Mapping[str, float]) -> str:
    """Return a form's functions as a product, with its values and coefficients by name."""
    said = []
    for f in form.factors:
        wanted = [*f.shape, *(("cosine", "sine") if f.waves else ())]
        said.append(f.say(**{name: values[name] for name in wanted}))
    return " · ".join(said)


def forms(variables: Sequence[Variable], *, period: float | None = None) -> list[ProductForm]:
    """Return the products that are looked through; ``period``: that of an effect known to have one.

    No two factors of a product have values of the same name: that would be no short form.
    """
    if period is not None:
        ladders = [[_wave(v, period, give=0.2 * period / np.ptp(v.values))] for v in variables]
    else:
        ladders = [list(_factors(v, alone=len(variables) == 1)) for v in variables]
    found = [ProductForm(factors) for factors in product(*ladders)]
    return [form for form in found if len(form.shape) == sum(len(f.shape) for f in form.factors)]


def _factors(v: Variable, *, alone: bool) -> Iterator[FormFactor]:
    """Yield the functions of a variable; a line through an origin is, alone, one with a level."""
    if np.ptp(v.values) <= 0:
        return
    for words, distance in _distances(v):
        largest = v.rounded(float(np.max(distance(v.values))))
        if largest <= 0:
            continue
        for power, as_written in POWERS.items():
            yield _power(v, words, distance, power=power, as_written=as_written, largest=largest)
        for share in WIDTHS:
            yield _tanh(v, words, distance, share * largest)
            yield _decay(v, words, distance, share * largest)
    if v.ends:
        yield from (_wave(v, float(np.ptp(v.values)) / n, give=0.2 / n) for n in WAVES)
    elif v.values.min() < 0:
        yield _line(v, 0.0, give=0.0)
    if v.ends and not alone:
        span = float(np.ptp(v.values))
        yield from (_line(v, v.values.min() + s * span, give=0.1 * span) for s in ORIGINS)


def _distances(v: Variable) -> list[tuple[str, Callable[[Array], Array]]]:
    """Return distances from zero and from the ends, each with its words."""
    low, high = v.rounded(float(v.values.min())), v.rounded(float(v.values.max()))
    if not v.ends:
        return [(v.name if low >= 0 else f"|{v.name}|", np.abs)]
    near = NEAR_ZERO * (high - low)
    found: list[tuple[str, Callable[[Array], Array]]] = []
    if low > -near or high < near:
        found.append((v.name if low > -near else f"|{v.name}|", np.abs))
    if abs(low) > near:
        sign = "−" if low > 0 else "+"
        words = f"({v.name} {sign} {v.quantity(abs(low))})"
        found.append((words, lambda u: np.maximum(u - low, 0.0)))
    if abs(high) > near:
        found.append((f"({v.quantity(high)} − {v.name})", lambda u: np.maximum(high - u, 0.0)))
    return found


def _power(
    v: Variable,
    words: str,
    distance: Callable[[Array], Array],
    *,
    power: float,
    as_written: str,
    largest: float,
) -> FormFactor:
    said = as_written.format(f"({words}/{v.quantity(largest)})")
    return FormFactor(lambda u: (distance(u) / largest) ** power, lambda: said, v.unit)


def _tanh(v: Variable, words: str, distance: Callable[[Array], Array], width: float) -> FormFactor:
    return FormFactor(
        lambda u, width: np.tanh(distance(u) / width),
        lambda width: f"tanh({words}/{v.quantity(width)})",
        v.unit,
        {"width": width},
        {"width": (width / WIDER, width * WIDER)},
    )


def _decay(v: Variable, words: str, distance: Callable[[Array], Array], width: float) -> FormFactor:
    return FormFactor(
        lambda u, width: np.exp(-distance(u) / width),
        lambda width: f"exp(−{words}/{v.quantity(width)})",
        v.unit,
        {"width": width},
        {"width": (width / WIDER, width * WIDER)},
    )


def _line(v: Variable, origin: float, *, give: float) -> FormFactor:
    """A line through an origin, which is tuned by ``give``; 0: it is where it is."""
    scale = v.rounded(float(np.max(np.abs(v.values))))

    def say(origin: float = origin) -> str:
        sign = "−" if origin > 0 else "+"
        off = f"({v.name} {sign} {v.quantity(abs(origin))})" if give else v.name
        return f"({off}/{v.quantity(scale)})"

    def law(u: Array, origin: float = origin) -> Array:
        return np.asarray((u - origin) / scale)

    if not give:
        return FormFactor(law, say, v.unit)
    return FormFactor(
        law, say, v.unit, {"origin": origin}, {"origin": (origin - give, origin + give)}
    )


def _wave(v: Variable, period: float, *, give: float) -> FormFactor:
    """A cosine and a sine from the lower end on; the period is tuned by a share ``give``."""
    start = float(v.values.min())

    def law(u: Array, period: float) -> Array:
        angle = 2 * np.pi * (u - start) / period
        return np.column_stack([np.cos(angle), np.sin(angle)])

    def say(period: float, cosine: float, sine: float) -> str:
        zero = start - period * float(np.arctan2(cosine, sine)) / (2 * np.pi)
        zero = start + (zero - start) % period
        return f"sin(2π·({v.name} − {v.quantity(zero)})/{v.quantity(period)})"

    limits = (period * (1 - give), period * (1 + give))
    return FormFactor(law, say, v.unit, {"period": period}, {"period": limits}, waves=True)


def nearest_candidates(
    curve: Array, base: Array, candidates: Sequence[Array], count: int
) -> list[int]:
    """Return the places of the candidates (n, p) that come nearest to a curve (n,), best first; of
    those that beside ``base`` are the same, the first.

    What ``base`` (n, k) gives is taken out of both; of a candidate that it gives wholly nothing is
    left to come near.
    """
    basis = orthonormal_basis(base, least=HELD**0.5)
    matrix = np.column_stack(candidates)
    free = matrix - basis @ (basis.T @ matrix)
    right = free.T @ (curve - basis @ (basis.T @ curve))
    ends = np.cumsum([columns.shape[1] for columns in candidates])
    gains = []
    for columns, end in zip(candidates, ends, strict=True):
        at = slice(end - columns.shape[1], end)
        inner = free[:, at].T @ free[:, at]
        held = np.trace(inner) > SPANNED * float(np.sum(columns**2))
        gains.append(float(right[at] @ np.linalg.lstsq(inner, right[at])[0]) if held else 0.0)
    told = np.round(np.array(gains) / max(*gains, 1e-300), TOLD_DIGITS)
    return [int(i) for i in np.argsort(-told, kind="stable")[:count]]
