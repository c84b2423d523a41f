"""How sure is a finding? One definition for what is missing and for what is mistuned.

The probability of an account among those that recording and simulation leave open: another effect
in its place, nothing in its place, and something outside the vocabulary, which the best family
without a name stands for. Each counts by its evidence, 2 ln of a likelihood with its penalties,

    P = 1 / (1 + Σ exp(−fall / 2T)),   fall = evidence of this account − that of the other

T is a temper: laws are never exact, so that likelihoods of real data claim too much. For the same
reason a family, which follows whatever a law gets wrong, has to do better than the law by a share
of what the law explains (a discrepancy as of Kennedy and O'Hagan 2001, J. R. Stat. Soc. B 63:425).
An effect that is missing is compared in the set that it was found in; an own term of the simulation
that is mistuned is compared with accounts that leave it as the simulation has it.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

import numpy as np

from autodb.explain.engine.candidates import UNKNOWN, Choice

TEMPER = 3.0
"""Evidence counts this many times less than likelihoods do. Chosen of 2 to 6 on virtual axes (seeds
1001 to 1062 of `autodb prove explain-outside`): with it the mean confidence is the share that is
right."""
SUREST = 0.99
"""More is never claimed. Chosen: what nobody thought of is never less probable."""
NEAR = 20.0
"""A rival whose evidence is not this much less is an alternative: odds of e¹⁰ of likelihoods, which
laws of another form than the truth may use up. Chosen."""


@dataclass(frozen=True)
class Standing:
    """Of one account: how probable it is, and the names that would do nearly as well.

    ``near``: these names, the nearest first;
    ``by_name``: evidence by which it is ahead of the best account of each other name; ``nothing``:
    of nothing in its place; ``instead``: what would stand there, of names that were tried so.
    ``rivalled``: by white rows, what may be in its place leaves it no surer than UNSURE.
    ``as_good``: names whose laws have more columns, and predict plain rows left out as well.
    """

    confidence: float
    near: tuple[str, ...]
    by_name: Mapping[str, float]
    nothing: float
    instead: Mapping[str, Choice] = field(default_factory=dict)
    rivalled: bool = False
    as_good: frozenset[str] = frozenset()

    @property
    def is_likeliest(self) -> bool:
        """Whether no other account has as much evidence."""
        return all(fall > 0.0 for fall in (self.nothing, *self.by_name.values()))

    def of(self, names: Iterable[str]) -> float:
        """Return the probability of its name or one of others."""
        weights = {name: account_weight(fall) for name, fall in self.by_name.items()}
        whole = 1.0 + account_weight(self.nothing) + sum(weights.values())
        return (1.0 + sum(weights.get(name, 0.0) for name in names)) / whole


def account_weight(fall: float) -> float:
    """Return the probability of an account over that of the one whose evidence is ``fall`` more.

    An account that was not taken counts for no more than the one that was.
    """
    return float(np.exp(-0.5 * max(fall, 0.0) / TEMPER))


def standing(by_name: Mapping[str, float], *, nothing: float) -> Standing:
    """Return how an account stands beside rivals; ``nothing``: its evidence over none at all."""
    odds = account_weight(nothing) + sum(account_weight(fall) for fall in by_name.values())
    near = sorted((fall, name) for name, fall in by_name.items() if fall < NEAR and name != UNKNOWN)
    return Standing(
        min(SUREST, 1.0 / (1.0 + odds)), tuple(name for _, name in near), by_name, nothing
    )
