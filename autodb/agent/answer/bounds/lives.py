"""How long the edges last that make a part together: each its own life, and the first to end.

Edges of several jobs, each of one tool, or of the tools of a program; an edge ages in its own cuts
alone. With the chance P_e(n) that edge e keeps its limit in fewer than n parts, the first of them
ends before n parts are made with the chance

    P(n) = 1 - product over e of (1 - P_e(n))

which is that of edges that know nothing of each other. Edges of one pair share what is open of its
law: the first of those ends later than is said, never sooner (association of lives, Esary, Proschan
and Walkup 1967, Annals of Mathematical Statistics 38:1466).
"""

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import prod

from autodb.agent.answer.bounds.lasting import (
    SURE,
    LifeCourse,
    ToolLife,
    life_of,
    refuse_limits,
)
from autodb.agent.answer.prediction_basis import PredictionBasis
from autodb.errors import UnusableInput, near_words
from autodb.files.job import OTHERS, Job
from autodb.forward.line_parts import Followed
from autodb.forward.tool_life import LEVELS, LifeEnds
from autodb.wording import localized, phrase, phrase_many

OF = ":"
"""Between an edge and the channel of a limit that it alone has."""


@dataclass(frozen=True)
class AskedLife:
    """A job whose edges are asked of: what its prediction rests on, its program followed if any."""

    basis: PredictionBasis
    job: Job
    program: Followed | None = None


@dataclass(frozen=True)
class FirstToEnd:
    """Of several edges the one that ends first by the middle of its life: ``edge``.

    ``parts`` that keep all limits until any of them ends; ``sure_parts``: those with the
    probability that was asked for, None: beyond the search.
    """

    edge: str
    parts: LifeEnds
    sure_parts: int | None


@dataclass(frozen=True)
class ToolLives:
    """How long each edge lasts, in the order of the work; ``first`` of several to end.

    None where there is one edge, or the wear of none was learnt.
    """

    edges: tuple[ToolLife, ...]
    first: FirstToEnd | None
    sure: float
    notes: tuple[str, ...] = ()

    @property
    def lines(self) -> tuple[str, ...]:
        """What a planner is told, a line each."""
        if len(self.edges) == 1:
            return (*self.edges[0].lines, *self.notes)
        said = [
            phrase("{edge}: {line}", edge=one.edge, line=line)
            for one in self.edges
            for line in one.life_lines
        ]
        notes = [note for one in self.edges for note in one.notes]
        return (*said, *self._first_lines, *dict.fromkeys(notes), *self.notes)

    @property
    def _first_lines(self) -> tuple[str, ...]:
        its = self.first
        if its is None:
            return ()
        middle = its.parts.low if its.parts.value is None else its.parts.value
        word = "part" if middle == 1 else "parts"
        lines = [
            phrase(
                "the first edge to end is that of {edge}: {parts} until any edge ends",
                edge=its.edge,
                parts=its.parts.words(word, ".0f"),
            )
        ]
        if its.sure_parts is not None:
            lines.append(
                phrase_many(
                    "{count} part keeps the limits of all edges with {sure} % probability",
                    "{count} parts keep the limits of all edges with {sure} % probability",
                    its.sure_parts,
                    sure=localized(f"{100.0 * self.sure:.4g}"),
                )
            )
        if any(one.why is not None for one in self.edges):
            lines.append(phrase("edges whose wear was not learnt are not counted in that"))
        return tuple(lines)


def tool_lives(
    asked: Sequence[AskedLife],
    *,
    limits: Mapping[str, float] | None = None,
    sure: float = SURE,
) -> ToolLives:
    """Return how long the edges last that make a part together, and when the first of them ends.

    ``limits``: by channel, instead of the machines'; with an edge before it (``0303:force.z``) of
    that one alone. ``sure``: the probability with which they are kept by parts that are surely
    made. Raises UnusableInput for another channel or edge, where there is no limit, or where
    lengths are missing.
    """
    edges = _edges(asked)
    own = _limits_of(limits or {}, [called for called, *_ in edges])
    several = len(edges) > 1
    found: list[tuple[ToolLife, LifeCourse | None]] = []
    for called, one, which in edges:
        life, course = life_of(
            one.basis,
            one.job,
            limits=own[called],
            sure=sure,
            program=one.program,
            which=which,
            edge=called if several else "",
        )
        if several and course is None and life.why is None:
            raise UnusableInput(
                phrase("job '{job}': state length_mm of its cut, to count parts", job=one.job.name)
            )
        found.append((life, course))
    lives = tuple(life for life, _ in found)
    first = _first(found, sure) if several else None
    return ToolLives(lives, first, sure, tuple(_of_programs(asked)))


def _edges(asked: Sequence[AskedLife]) -> list[tuple[str, AskedLife, Sequence[int]]]:
    """Return the edges: what each is called, its job, and which lines of a program it makes."""
    found: list[tuple[str, AskedLife, Sequence[int]]] = []
    for one in asked:
        made = () if one.program is None else one.program.edges
        if one.program is None or len(made) == 1:
            lines = () if one.program is None else range(len(one.program.lines))
            found.append((one.job.tool, one, lines))
            continue
        for tool in made:
            which = [k for k, line in enumerate(one.program.lines) if line.tool == tool]
            found.append((tool or OTHERS, one, which))
    names = Counter(called for called, *_ in found)
    apart = [
        (called if names[called] == 1 else f"{one.job.name}, {called}", one, which)
        for called, one, which in found
    ]
    twins = [called for called, count in Counter(one[0] for one in apart).items() if count > 1]
    if twins:
        raise UnusableInput(
            phrase("two jobs are called '{name}' with one tool; give them names", name=twins[0])
        )
    return apart


def _limits_of(limits: Mapping[str, float], edges: Sequence[str]) -> dict[str, dict[str, float]]:
    """Return the limits of each edge by channel: those of all, and its own in their place."""
    of_all = {key: value for key, value in limits.items() if OF not in key}
    found = {edge: dict(of_all) for edge in edges}
    for key, value in limits.items():
        if OF in key:
            edge, _, channel = key.rpartition(OF)
            if edge not in found:
                raise UnusableInput(
                    phrase("limit of '{edge}': no edge is called so{hint}", edge=edge,
                           hint=near_words(edge, edges))
                )  # fmt: skip
            found[edge][channel] = value
    for some in found.values():
        refuse_limits(some)
    return found


def _first(found: Sequence[tuple[ToolLife, LifeCourse | None]], sure: float) -> FirstToEnd | None:
    """Return which edge ends first, and how many parts are made until any of them ends."""
    known = [(life, course) for life, course in found if course is not None]
    if not known:
        return None
    courses = [course for _, course in known]
    first = min(known, key=lambda one: _middle(one[1], one[0]))[0]
    low, middle, high = (kept_parts(courses, level) for level in LEVELS)
    return FirstToEnd(first.edge, LifeEnds(middle, low, high), kept_parts(courses, 1.0 - sure))


def _middle(course: LifeCourse, life: ToolLife) -> tuple[float, float]:
    """Return by what edges are sorted: parts until the middle of a life, then the surest chance."""
    parts = life.lives[0].parts
    value = None if parts is None else parts.value
    return float("inf") if value is None else value, -course.chance(course.most_parts)


def kept_parts(courses: Sequence[LifeCourse], level: float) -> int | None:
    """Return how many parts keep all limits until the chance that one is passed reaches a level.

    None: it does not in the ages that are searched.
    """
    low, high = 0, min(one.most_parts for one in courses)
    if high == 0 or _any_passed(courses, high) < level:
        return None if high else 0
    while high - low > 1:
        middle = (low + high) // 2
        if _any_passed(courses, middle) < level:
            low = middle
        else:
            high = middle
    return low


def _any_passed(courses: Sequence[LifeCourse], parts: int) -> float:
    """Return the chance that fewer than so many parts keep the limits of all edges."""
    return 1.0 - prod(1.0 - one.chance(parts) for one in courses)


def _of_programs(asked: Sequence[AskedLife]) -> list[str]:
    return [
        phrase(
            "program {file} cuts with tools {tools}: all by what is known of {tool}",
            file=one.program.source,
            tools=", ".join(tool or OTHERS for tool in one.program.edges),
            tool=one.basis.known.tool.name,
        )
        for one in asked
        if one.program is not None and len(one.program.edges) > 1
    ]
