"""A candidate: one effect that a simulation may have left out, and the shapes that it may have.

A candidate's shapes form a ladder from the plain law to a smooth curve of its kind, so that an
effect is named by what it acts on and not by the formula that it happens to follow.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
UNKNOWN = "unknown"


@dataclass(frozen=True)
class CandidateForm:
    """One shape of a candidate, linear in its coefficients.

    ``law`` gives its columns (n, p) or (n,) at every row from ``shape``, its values by keyword;
    ``within`` the limits between which a value may be tuned once the candidate is found; ``names``
    what its coefficients are called where it is a plain law; ``tries`` how many shapes were looked
    through for this one; ``allowed`` says whether fitted coefficients (p,) are of the candidate's
    kind: friction falls as it warms. ``through`` gives what is recorded of other effects' columns
    (n, p) where this one changes all that is recorded: it clips, shifts, signs. ``alone`` gives
    what it changes (n,) where its law also holds the simulation's terms in other sizes. ``shown``
    says of the values of its shape, tuned, whether what was recorded shows them: not a limit that
    rows stand above.
    """

    law: Callable[..., Array]
    shape: Mapping[str, float] = field(default_factory=dict)
    within: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    names: tuple[str, ...] = ()
    tries: float = 1
    allowed: Callable[[Array], bool] | None = None
    through: Callable[..., Array] | None = None
    alone: Callable[[], Array] | None = None
    shown: Callable[..., bool] | None = None

    @property
    def is_shown(self) -> bool:
        """Whether what was recorded shows the values of its shape."""
        return self.shown is None or self.shown(**self.shape)

    def build(self) -> Array:
        """Return its columns (n, p) at every row."""
        built = np.asarray(self.law(**self.shape), dtype=np.float64)
        return built.reshape(len(built), -1)

    def seen(self, columns: Array) -> Array:
        """Return what is recorded of other columns (n, p)."""
        if self.through is None:
            return columns
        return np.asarray(self.through(columns, **self.shape), dtype=np.float64)


@dataclass(frozen=True)
class PartOfLaw:
    """What an effect is a part of: a law that it makes with effects of other ``terms``, or keys
    of such as have no name.

    ``allowed`` says of what the effect adds (n,), and by term of what those add (n,), whether it is
    of its kind among them.
    """

    terms: frozenset[str]
    allowed: Callable[[Array, Mapping[str, Array]], bool]


@dataclass(frozen=True)
class Candidate:
    """An effect with its ladder of shapes.

    ``key`` is unique; ``term`` a name of the vocabulary or `unknown`; ``detail`` gives columns that
    take up what every form may get wrong, freed while further effects are sought; ``bar`` is
    further evidence asked of it; ``excludes`` the terms that it is not named together with;
    ``interval`` the stretch that it is confined to, where it is, ``stretches`` those in which it
    comes and goes; ``scanned``: found by a scan of what was left, and dropped with it; ``loose``
    gives columns that hold no level of the effect and are free in the final fit, so that what its
    shape gets wrong in passing does not pull its level. ``anew`` builds one that a scan found over
    other signals; None: it does not repeat. ``mistaken`` gives columns that it may be mistaken for:
    where they explain more beside it than it does, it must be worth it beside them. ``sure``: its
    shape follows from what is recorded and simulated alone. ``static``: it adds to the others as
    position, speed, acceleration or the clock say, and changes none of them, or is a factor's
    change of known ones; such laws come before all others. ``needs``: terms of which plain rows
    must hold one beside it: there is no dip of a friction that is not there. ``part_of``: what it
    has to show together with others. ``first``: it changes all that is recorded in a way that no
    static law looks like. ``coarse``: its forms stand far apart, and are tuned before more is
    looked for. ``usual``: how many times as many
    machines have it as have another; it decides where nothing recorded does. ``phased``: its two
    columns are one size and one phase, such as a weight's that turns, and count as one. ``holds``:
    what was found and its columns scale, by term, or key where it has no name: it would explain
    these, too, so that it stands with them or not at all.
    """

    key: str
    term: str
    forms: tuple[CandidateForm, ...]
    variables: tuple[str, ...] = ()
    detail: Callable[[], Array] | None = None
    bar: float = 0.0
    excludes: frozenset[str] = frozenset()
    interval: tuple[float, float] | None = None
    stretches: tuple[tuple[float, float], ...] = ()
    scanned: bool = False
    loose: Callable[[], Array] | None = None
    anew: Callable[[Any], "Candidate"] | None = None
    mistaken: Callable[[], Array] | None = None
    sure: bool = False
    static: bool = False
    needs: frozenset[str] = frozenset()
    part_of: PartOfLaw | None = None
    first: bool = False
    coarse: bool = False
    usual: float = 1.0
    phased: bool = False
    holds: frozenset[str] = frozenset()

    @property
    def known_as(self) -> str:
        """Its term, or what tells it from others without a name."""
        return self.term if self.named else self.key

    @property
    def exact(self) -> bool:
        """Whether its law has no shape to get wrong, like a constant's, that depends on nothing."""
        return self.sure or (not self.variables and self.detail is None)

    @property
    def acts(self) -> bool:
        """Whether it changes what others add: neither adds as known signals say, nor was found by a
        scan.
        """
        return not (self.static or self.scanned)

    @property
    def named(self) -> bool:
        """Whether it has a name in the vocabulary."""
        return self.term != UNKNOWN


@dataclass(frozen=True)
class Choice:
    """A candidate in one of its shapes."""

    candidate: Candidate
    form: int

    @property
    def key(self) -> tuple[str, int]:
        """What tells it from every other choice."""
        return self.candidate.key, self.form

    @property
    def shape(self) -> CandidateForm:
        """Its shape."""
        return self.candidate.forms[self.form]


def of_its_kind(choice: Choice, part: Array, added: Iterable[tuple[str, Array]]) -> bool:
    """Whether what a choice adds (n,) is of its kind beside what terms add, each (n,)."""
    law = choice.candidate.part_of
    if law is None:
        return True
    beside: dict[str, Array] = {}
    for term, one in added:
        if term in law.terms:
            beside[term] = beside.get(term, 0.0) + one
    return law.allowed(part, beside)


def grid_forms(
    law: Callable[..., Array],
    grid: Sequence[Mapping[str, float]],
    *,
    names: tuple[str, ...],
    ratio: float = 2.0,
    allowed: Callable[[Array], bool] | None = None,
    through: Callable[..., Array] | None = None,
) -> list[CandidateForm]:
    """Return one form a point of a grid; each value may be tuned by a factor of ``ratio``."""
    return [
        CandidateForm(
            law,
            shape=point,
            within={
                name: (min(v / ratio, v * ratio), max(v / ratio, v * ratio))
                for name, v in point.items()
            },
            names=names,
            tries=len(grid),
            allowed=allowed,
            through=through,
        )
        for point in grid
    ]


def has_positive_first(coefficients: Array) -> bool:
    """Whether the first coefficient has the sign that the effect must have."""
    return bool(coefficients[0] > 0)


def negative(coefficients: Array) -> bool:
    """Whether the first coefficient takes effort away."""
    return bool(coefficients[0] < 0)


def near_one(coefficients: Array) -> bool:
    """Whether the coefficient is that of an effect whose size its shape already fixes."""
    return bool(0.6 < coefficients[0] < 1.6)


def spline(values: Array, count: int, like: Array | None = None) -> Array:
    """Return ``count`` cubic B-splines over the values' range with knots at quantiles, (n, count).

    Quantile knots put the columns where the data are; a stationary signal gives one constant.
    ``like``: values that the knots are taken from; beyond them the curve keeps its last value.
    """
    from scipy.interpolate import BSpline

    like = values if like is None else like
    low, high = float(like.min()), float(like.max())
    if high - low <= 0:
        return np.ones((len(values), 1))
    inner = np.unique(np.quantile(like, np.linspace(0, 1, count - 2)[1:-1]))
    inner = inner[(inner > low + 1e-6 * (high - low)) & (inner < high - 1e-6 * (high - low))]
    knots = np.concatenate([[low] * 4, inner, [high] * 4])
    return np.asarray(
        BSpline.design_matrix(np.clip(values, low, high), knots, 3).toarray(), dtype=np.float64
    )


def swings(values: Array, count: int, like: Array | None = None) -> Array:
    """Return splines without their means, (n, count − 1): a curve beside a constant."""
    columns = spline(values, count, like)[:, :-1]
    mean = columns if like is None else spline(like, count)[:, :-1]
    return np.asarray(columns - mean.mean(axis=0))


def product(first: Array, second: Array) -> Array:
    """Return all products of the columns of two bases, (n, p·q)."""
    return np.asarray((first[:, :, None] * second[:, None, :]).reshape(len(first), -1))
