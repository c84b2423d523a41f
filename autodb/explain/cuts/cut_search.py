"""Look for the effects that the forces of a table of cuts hold."""

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from autodb.explain.cuts.candidates.laws import LawColumns
from autodb.explain.cuts.candidates.library import Library, of_forces
from autodb.explain.cuts.evidence import TableProducts, TableSearch, products
from autodb.explain.cuts.fit import all_columns, fit_cuts, held_out_square
from autodb.explain.cuts.impossible import drifting_in_all, impossible
from autodb.explain.cuts.plain_rows import laws_of_table
from autodb.explain.cuts.scatter import with_noise
from autodb.explain.cuts.simulated_speed import softened, softening_read_off
from autodb.explain.cuts.simulated_wear import wear_read_off
from autodb.explain.cuts.stack import (
    SETTINGS,
    Stack,
    edge_read_off,
    recorded_and_simulated,
    table_conditions,
)
from autodb.explain.engine.candidates import Candidate, Choice
from autodb.explain.engine.plain.growing import GAIN
from autodb.explain.engine.plain.rows import NEEDED
from autodb.explain.engine.search import FoundSet, as_compared, settled_set
from autodb.records.tables import CutTable

Array = NDArray[np.float64]

BAR = -3.0
"""Evidence asked of every effect beyond what the search asks: fewer shapes overlap than are
searched through. Chosen, so that of tables with nothing missing fewer than one in a hundred is
given a name.
"""
SHORT = 60.0
"""Degrees of freedom per unit of evidence that is asked further of a short table. Chosen."""
ROUNDS = 2
"""How often runs and periods are searched for in what the best set leaves."""
RICH = 8
"""Columns from which on a shape must predict cuts left out of its fit better than a plainer one."""
STRONG = 0.2
"""Share of the greatest effect's evidence above which an effect is no part of the scatter."""
MUCH = 0.4
"""Share by which the error on cuts left out must be smaller with what soaks up any misfit in the
place of a law, where one component alone shows it, or in all at once. Chosen."""
PASSES = 2
"""Scatter is estimated by a rich model first, then with what was found."""


@dataclass(frozen=True)
class FoundInCuts:
    """The best set of effects, with the search that found it and the table as it was seen.

    ``founded``: keys of those that plain rows need.
    """

    stack: Stack
    own: dict[str, LawColumns]
    search: TableSearch
    found: FoundSet
    founded: frozenset[str] = frozenset()

    @property
    def laws(self) -> tuple[Choice, ...]:
        """Those of the set that go with the conditions of a cut."""
        choices = self.found.choices
        return tuple(c for c in choices if c.candidate.named and c.candidate.static)


def stack_of(table: CutTable, simulation: dict[str, Array], includes: list[str] | None) -> Stack:
    """Return the components stacked, scatter not yet estimated."""
    known = table_conditions(table)
    recording, simulated = recorded_and_simulated(table, simulation)
    named = includes is not None and "tool_wear" in includes
    wear = wear_read_off(simulated, known) if named else None
    plain = simulated - (wear.force(known) if wear else 0.0)
    softens = includes is not None and "speed_softening" in includes
    exponents = softening_read_off(plain, known) if softens else None
    softening = None if exponents is None else softened(exponents, known)
    edge, length = edge_read_off(plain, known, softening)
    if includes is not None and "edge_force" not in includes:
        edge = np.zeros_like(edge)
    return Stack(
        tuple(simulation), known, recording, simulated, edge, length,
        np.ones_like(simulated), np.eye(len(simulated)), wear=wear, exponents=exponents,
    )  # fmt: skip


def look_in_cuts(stack: Stack, includes: list[str] | None) -> FoundInCuts:
    """Return the effects that a table's forces hold."""
    return look_for(stack, of_forces(includes))


def look_for(stack: Stack, library: Library) -> FoundInCuts:
    """Return the effects that the table holds: of two accounts, one that begins with the laws that
    cuts left out need and one by evidence alone, that which predicts such cuts better.
    """
    founded = _looked_for(stack, library, founded=True)
    if not founded.founded:
        return founded
    return _better_account(founded, _looked_for(stack, library, founded=False))


def _better_account(founded: FoundInCuts, rival: FoundInCuts) -> FoundInCuts:
    """Return the account whose names cuts left out speak for, each name and each column counted.

    Each account has its own idea of the scatter, which speaks for it: by both they are compared.
    A curve takes no law's place, so that the names of both stand without their curves here, and
    another name must be among them. What soaks up any misfit has to do much better where there is
    one component, so that nothing tells it apart, and so have drifts of all sensors that may hide a
    law of a setting.
    """
    names, others = _named(founded.found), _named(rival.found)
    rise = [
        held_out_square(one.stack, one.own, others) / held_out_square(one.stack, one.own, names)
        for one in (founded, rival)
    ]
    fall = 1.0 - float(np.prod(rise)) ** 0.25
    other = [c.candidate for c in others if c.candidate.key not in founded.found.keys]
    asked = NEEDED * (_columns(others) - _columns(names)) + GAIN * (len(others) - len(names))
    alone = len(founded.stack.names) == 1 and not all(one.static for one in other)
    if alone or (_hidden(names, rival.found) and drifting_in_all(rival.stack, others)):
        asked = max(asked, MUCH)
    if not other and len(others) < len(rival.found.choices):
        return founded
    return rival if others and fall > asked else founded


def _hidden(names: Sequence[Choice], rival: FoundSet) -> bool:
    """Whether some names go with a setting of the cuts, and another account lacks them."""
    lacking = (one.candidate for one in names if one.candidate.key not in rival.keys)
    return any(set(SETTINGS) & set(one.variables) for one in lacking)


def _named(found: FoundSet) -> tuple[Choice, ...]:
    return tuple(choice for choice in found.choices if choice.candidate.named)


def _columns(choices: tuple[Choice, ...]) -> int:
    return sum(columns.mix.shape[2] for columns in all_columns({}, choices))


def _looked_for(stack: Stack, library: Library, *, founded: bool) -> FoundInCuts:
    """Return an account: scatter, laws that cuts left out need, a search beside them, and scatter
    again.
    """
    result = None
    for number in range(PASSES):
        strong = None if result is None else all_columns({}, _strong(result))
        own = [columns for name, columns in library.own(stack).items() if name in library.levels]
        stack, freedom = with_noise(stack, strong, own=own)
        laws = laws_of_table(stack, library) if founded else ()
        result = _search(stack, library, laws, freedom, known=number > 0)
        if not result.found.choices and not _strong(result):
            break
    assert result is not None
    result = _as_can_be(result)
    return replace(result, found=_vetoed(result, library.confirmed))


def _as_can_be(result: FoundInCuts) -> FoundInCuts:
    """Return the set without effects that a table cannot hold (``impossible``), searched anew."""
    stack, own, search = result.stack, result.own, result.search
    while barred := impossible(stack, own, result.found, result.founded):
        for choice in barred:
            search.bar(choice)
        predicted = partial(held_out_square, stack, own)
        found = _swapped(search, search.best(), result.founded, predicted)
        result = replace(result, found=found)
    return result


def _strong(result: FoundInCuts) -> tuple[Choice, ...]:
    """Return the effects that do much beside the greatest: what is left is judged without the rest.

    Of scatter that goes on from cut to cut a search in white rows makes small effects. Where none
    is found, it is the likeliest named one, if any has evidence: it may be hidden in the scatter of
    a component for which a rich model has no shape of its kind.
    """
    found = result.found
    if not found.choices:
        offers = [o for o in result.search.offers(()) if o.choice.candidate.named and o.worth > 0]
        return tuple(
            o.choice for o in sorted(offers, key=lambda offer: -as_compared(offer.worth))[:1]
        )
    most = max(found.evidence, default=0.0)
    pairs = zip(found.choices, found.evidence, strict=True)
    return tuple(choice for choice, evidence in pairs if evidence >= STRONG * most)


def _search(
    stack: Stack, library: Library, laws: tuple[Choice, ...], freedom: float, *, known: bool
) -> FoundInCuts:
    own, kept = library.own(stack), {c.candidate.key: c.candidate for c in laws}
    fixed = [c for c in library.candidates(stack) if c.key not in kept and not _is_of(c, laws)]
    made = partial(products, stack, list(own.values()), freedom=freedom, known=known)
    proposed: list[Candidate] = []
    found, search = FoundSet(laws), None
    for number in range(ROUNDS):
        more = _searched_for(stack, library, own, found, number)
        if number > 0 and not _helps(made, found, more, laws):
            break
        proposed += [c for c in more if c.key not in kept]
        bar = BAR + SHORT / freedom
        others = [replace(s, bar=s.bar + bar) for s in (*fixed, *proposed)]
        candidates = (*kept.values(), *others)
        search = TableSearch(made(candidates), candidates, laws)
        best = search.best() if number == 0 else _longer(search, found)
        now = _swapped(search, best, kept, partial(held_out_square, stack, own))
        same = now.keys == found.keys and number > 0
        found = now
        if same or not now.choices:
            break
    assert search is not None
    return FoundInCuts(stack, own, search, found, frozenset(kept))


def _swapped(
    search: TableSearch,
    best: FoundSet,
    held: Collection[str],
    predicted: Callable[[tuple[Choice, ...]], float],
) -> FoundSet:
    """Return a set after every swap that raises its score, or itself where it predicts cuts left
    out better than what of the other stands.

    ``predicted``: mean square of cuts left out of the fit.
    """
    swapped = search.cleared(settled_set(search, best, held=held, names_first=True))
    if set(swapped.keys) == set(best.keys):
        return swapped
    return min(swapped, best, key=lambda found: predicted(found.choices))


def _is_of(candidate: Candidate, laws: tuple[Choice, ...]) -> bool:
    """Return whether a family depends on nothing that a law does not: what it gets wrong in shape
    is no effect.
    """
    said = {name for law in laws for name in law.candidate.variables}
    return not candidate.named and bool(said.issuperset(candidate.variables))


def _searched_for(
    stack: Stack, library: Library, own: dict[str, LawColumns], found: FoundSet, number: int
) -> list[Candidate]:
    """Return what is searched for in what a set leaves, and in what it leaves without scanned ones.

    Scans of the first round see slow effects too: a run or a step found beside them may be another.
    """
    more = library.proposals(stack, fit_cuts(stack, own, found.choices).left, number)
    standing = tuple(choice for choice in found.choices if choice.candidate.anew is None)
    if 0 < len(standing) < len(found.choices):
        more += library.proposals(stack, fit_cuts(stack, own, standing).left, ROUNDS + number)
    return more


def _helps(
    made: Callable[[Sequence[Candidate]], TableProducts],
    found: FoundSet,
    more: list[Candidate],
    laws: tuple[Choice, ...],
) -> bool:
    """Return whether a further candidate may join what was found, or stand in for one of it.

    All others are left out.
    """
    candidates = [*(choice.candidate for choice in found.choices), *more]
    search = TableSearch(made(candidates), tuple(candidates), laws)
    same = search.settled(found.choices)
    held = [c.candidate.key for c in laws]
    return (
        bool(search.grown(found, tuple(candidates)))
        or settled_set(search, same, held=held, names_first=True).score > same.score
    )


def _longer(search: TableSearch, found: FoundSet) -> FoundSet:
    """Return the best of a set and those with one more effect."""
    found = search.settled(found.choices)
    longer = [search.cleared(f) for f in search.grown(found, search.candidates)]
    return max([found, *longer], key=lambda f: as_compared(f.score))


def _plainer(result: FoundInCuts, found: FoundSet) -> FoundSet:
    """Return the set with a plainer shape of a rich one where cuts left out are predicted
    better."""
    search = result.search
    for choice in found.choices:
        if search.products.places[choice.key].size <= RICH:
            continue
        others = found.without(choice.candidate.key)
        given = search.products.given([c.key for c in others])
        widths = [
            search.products.places[choice.candidate.key, i].size
            for i in range(len(choice.candidate.forms))
        ]
        numbers = [i for i, width in enumerate(widths) if width <= RICH]
        if not numbers:
            continue
        gained = {
            i: given.gain(
                (choice.candidate.key, i), allowed=choice.candidate.forms[i].allowed
            ).evidence
            for i in numbers
        }
        plainer = (*others, Choice(choice.candidate, max(gained, key=lambda i: gained[i])))
        stack, own = result.stack, result.own
        if held_out_square(stack, own, plainer) < held_out_square(stack, own, found.choices):
            found = search.scored(plainer)
    return found


def _vetoed(result: FoundInCuts, asked: float) -> FoundSet:
    """Return the set without effects that cuts left out of the fit do not confirm, laws last.

    ``asked``: as in Library.
    """
    found = _plainer(result, result.found)
    while found.choices:
        beside = [key for key in found.keys if key not in result.founded]
        gone = _least_confirmed(result, found, beside, asked) or _needless(result, found)
        if gone is None:
            break
        found = _plainer(result, result.search.settled(found.without(gone)))
    return found


def _least_confirmed(
    result: FoundInCuts, found: FoundSet, keys: list[str], asked: float
) -> str | None:
    """Return the effect of which squares of cuts left out say least, where that is too little."""
    rows = result.stack.simulation.size
    share = {}
    for key in keys:
        whole, without = _held_out_squares(result, found, key)
        evidence = found.evidence[found.keys.index(key)]
        share[key] = rows * (without - whole) / max(evidence, 1.0)
    least = min(share, key=lambda key: share[key], default=None)
    return least if least is not None and share[least] < asked else None


def _needless(result: FoundInCuts, found: FoundSet) -> str | None:
    """Return a law that the others do without: by evidence and by cuts left out of the fit."""
    for key, evidence in zip(found.keys, found.evidence, strict=True):
        whole, without = _held_out_squares(result, found, key)
        fall = 1.0 - np.sqrt(whole / without) if without > 0.0 else 0.0
        if fall < 0.0 or (evidence <= 0.0 and fall < NEEDED):
            return key
    return None


def _held_out_squares(result: FoundInCuts, found: FoundSet, key: str) -> tuple[float, float]:
    """Return the mean square of white rows left out of the fit, with an effect and without."""
    stack, own = result.stack, result.own
    return (
        held_out_square(stack, own, found.choices),
        held_out_square(stack, own, found.without(key)),
    )
