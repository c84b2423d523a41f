"""What shops' weeks found: how often intervals held, how far off values were, what was named when.

Forces of a shop share its calibration and its wear: the standard error of a share is that of the
shops' own shares.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from autodb.proofs.machines.lathe.process import SCATTER_TANGENTIAL, SCATTER_THRUST
from autodb.proofs.machines.lathe.weeks import BATCHES, CONDITIONS
from autodb.proofs.runs.found import Check, CheckedScore, TextTable, percent
from autodb.proofs.runs.run_file import Finished, Origin
from autodb.proofs.runs.score import Z
from autodb.proofs.runs.weeks.weeks_events import NAMES, Named
from autodb.proofs.runs.weeks.weeks_peers import PEERS
from autodb.proofs.runs.weeks.weeks_run import SCORED, Foreseen

POOLED, EACH = (0.93, 0.97), (0.88, 0.99)
"""Shares of forces that 95 % intervals must hold, of all and in each condition."""
FEWEST = 23
"""Of the 30 forces of a component in one file, how many must be held at least."""
SCATTERS = {"y": SCATTER_TANGENTIAL, "z": SCATTER_THRUST}
RATIO = 1.3
"""Times the scatter of cuts that errors may be, after the first LEARNT files."""
LEARNT = 5
HARD = "hard batch"
CALLED = {"y": "cutting force", "z": "feed force"}


@dataclass(frozen=True)
class Held:
    """Of some forces: how many of how many shops, the share held, its standard error over shops.

    ``oracle``: the share that an oracle's intervals hold.
    """

    name: str
    forces: int
    shops: int
    share: float
    se: float
    oracle: float

    @property
    def words(self) -> str:
        """The share with its 95 % interval by shop."""
        return f"{percent(self.share)} ± {percent(Z * self.se)}"


@dataclass(frozen=True)
class OfComponent:
    """Root mean square of the shares by which predictions of a component were off, file by file.

    ``late``: after the first LEARNT files; ``peers``: of the other ways then, in their order;
    ``oracle``: of who knows all true forces of the files before but a cut's own scatter, as the
    calibration reads them: what was read so far is all that anybody can compare with. ``soft`` and
    ``oracle_soft``: the same of the cuts then that are of no hard bar.
    """

    component: str
    by_batch: tuple[float, ...]
    late: float
    peers: tuple[float, ...]
    oracle: float
    soft: float
    oracle_soft: float


@dataclass(frozen=True)
class OfEvent:
    """Events of one kind: how many, how many named, median number of their cuts until then."""

    name: str
    events: int
    named: int
    cuts: float | None


@dataclass(frozen=True)
class WeeksSummary(CheckedScore):
    """The score. ``fewest``: forces held of the worst file of a component, ``below``: how many
    files held fewer than FEWEST, of ``files``, each of autodb and of the oracle; ``invented``:
    name, times, shops.
    """

    origin: Origin
    seeds: tuple[int, int]
    pooled: Held
    conditions: tuple[Held, ...]
    batches: tuple[Held, ...]
    fewest: tuple[int, int]
    below: tuple[int, int]
    files: int
    errors: tuple[OfComponent, ...]
    events: tuple[OfEvent, ...]
    invented: tuple[tuple[str, int, int], ...]

    def checks(self) -> list[Check]:
        """Return what must be."""
        found = [_within(self.pooled, POOLED)]
        found += [_within(one, EACH) for one in self.conditions]
        fewest = self._fewest_words(0)
        found.append(
            ("fewest held of 30 in a file", fewest, f"≥ {FEWEST}", self.fewest[0] >= FEWEST)
        )
        for one in self.errors:
            most = RATIO * SCATTERS[one.component]
            found.append(
                (f"error of the {CALLED[one.component]}", percent(one.late), f"≤ {percent(most)}",
                 one.late <= most)
            )  # fmt: skip
        return found

    def _fewest_words(self, whose: int) -> str:
        return f"{self.fewest[whose]} ({self.below[whose]} of {self.files} files below {FEWEST})"

    def _of_oracle(self) -> TextTable:
        """Return what limits an oracle meets: none beyond these is in anybody's reach."""
        found = [
            (f"held, {one.name}", percent(one.oracle)) for one in (self.pooled, *self.conditions)
        ]
        found.append(("fewest held of 30 in a file", self._fewest_words(1)))
        found += [
            (f"error of the {CALLED[one.component]}", percent(one.oracle)) for one in self.errors
        ]
        must = [(name, words, limit) for name, words, limit, _ in self.checks()]
        rows = tuple(
            (name, words, oracle, limit)
            for (name, words, limit), (_, oracle) in zip(must, found, strict=True)
        )
        return TextTable("Beside an oracle", ("", ">found", ">oracle", ">must be"), rows)

    def tables(self) -> tuple[TextTable, ...]:
        """Return what must be, errors beside other ways, files one by one, and the events."""
        errors = tuple(
            (CALLED[one.component], percent(SCATTERS[one.component]), percent(one.late),
             *map(percent, one.peers), percent(one.oracle), percent(one.soft),
             percent(one.oracle_soft))
            for one in self.errors
        )  # fmt: skip
        files = tuple(
            (str(k), percent(self.batches[k - 1].share),
             *(percent(one.by_batch[k - 1]) for one in self.errors))
            for k in range(1, BATCHES + 1)
        )  # fmt: skip
        events = tuple(
            (one.name, str(one.events), str(one.named),
             "" if one.cuts is None else f"{one.cuts:.0f}")
            for one in self.events
        )  # fmt: skip
        invented = self.invented or (("none", 0, 0),)
        return (
            self.limits("Files predicted before they came in"),
            self._of_oracle(),
            TextTable(
                f"Error (rms) after {LEARNT} files",
                ("", ">scatter", ">autodb", *(f">{name}" for name in PEERS), ">oracle",
                 ">autodb, no hard bar", ">oracle, no hard bar"), errors,
            ),
            TextTable(
                "File by file",
                ("file", ">held", *(f">error, {CALLED[one.component]}" for one in self.errors)),
                files,
            ),
            TextTable(
                "What happened, and what was named",
                ("event", ">events", ">named", ">its cuts until then"), events,
            ),
            TextTable(
                "Named, and did not happen", ("name", ">times", ">shops"),
                tuple((name, str(times), str(shops)) for name, times, shops in invented),
            ),
        )  # fmt: skip


def _within(one: Held, limits: tuple[float, float]) -> Check:
    low, high = limits
    must = f"{percent(low)} to {percent(high)}"
    return f"held, {one.name}", one.words, must, low <= one.share <= high


def weeks_summary_of(runs: Sequence[Finished[Foreseen | Named]], origin: Origin) -> WeeksSummary:
    """Return the score of finished runs in the order of their seeds."""
    shops = [[one for one in run.judged if isinstance(one, Foreseen)] for run in runs]
    named = [[one for one in run.judged if isinstance(one, Named)] for run in runs]
    reads = {name: _reads(name, shops) for name in SCORED}
    files = [
        (sum(one.held for one in own), sum(_oracle_holds(one, reads) for one in own))
        for shop in shops
        for batch in range(1, BATCHES + 1)
        for component in SCORED
        for own in [[one for one in shop if (one.batch, one.component) == (batch, component)]]
    ]
    ours, oracles = (np.array(one) for one in zip(*files, strict=True))
    return WeeksSummary(
        origin=origin,
        seeds=(runs[0].seed, runs[-1].seed),
        pooled=_held("all forces", shops, reads),
        conditions=tuple(
            _held(name, [[one for one in shop if one.condition == name] for shop in shops], reads)
            for name in CONDITIONS
        ),
        batches=tuple(
            _held(f"file {k}", [[one for one in shop if one.batch == k] for shop in shops], reads)
            for k in range(1, BATCHES + 1)
        ),
        fewest=(int(ours.min()), int(oracles.min())),
        below=(int(np.sum(ours < FEWEST)), int(np.sum(oracles < FEWEST))),
        files=len(files),
        errors=tuple(_errors(name, shops) for name in SCORED),
        events=tuple(_event(name, named) for name in NAMES),
        invented=_invented(named),
    )


def _reads(component: str, shops: Sequence[Sequence[Foreseen]]) -> float:
    """Return by what share forces of a component were read wrongly, over all shops."""
    own = [one.reads for shop in shops for one in shop if one.component == component]
    return _rms([one or 0.0 for one in own])


def _oracle_holds(one: Foreseen, reads: dict[str, float]) -> bool:
    """Say whether an oracle's interval holds a force: scatter, and what shops read wrongly by."""
    half = Z * float(np.hypot(SCATTERS[one.component], reads[one.component]))
    return abs(one.made / one.oracle - 1.0) <= half


def _held(name: str, shops: Sequence[Sequence[Foreseen]], reads: dict[str, float]) -> Held:
    shares = [float(np.mean([one.held for one in shop])) for shop in shops if shop]
    forces = [one for shop in shops for one in shop]
    se = float(np.std(shares, ddof=1) / np.sqrt(len(shares))) if len(shares) > 1 else float("nan")
    share = float(np.mean([one.held for one in forces]))
    oracle = float(np.mean([_oracle_holds(one, reads) for one in forces]))
    return Held(name, len(forces), len(shops), share, se, oracle)


def _errors(component: str, shops: Sequence[Sequence[Foreseen]]) -> OfComponent:
    own = [one for shop in shops for one in shop if one.component == component]
    late = [one for one in own if one.batch > LEARNT]
    others = [(one.peers, one.made) for one in late if one.peers is not None]
    soft = [one for one in late if one.condition != HARD]
    return OfComponent(
        component,
        tuple(_rms([one.error for one in own if one.batch == k]) for k in range(1, BATCHES + 1)),
        _rms([one.error for one in late]),
        tuple(_rms([peers[k] / made - 1.0 for peers, made in others]) for k in range(len(PEERS))),
        _rms([one.oracle / one.made - 1.0 for one in late]),
        _rms([one.error for one in soft]),
        _rms([one.oracle / one.made - 1.0 for one in soft]),
    )


def _rms(values: Sequence[float]) -> float:
    return float(np.sqrt(np.mean(np.square(values))))


def _event(name: str, named: Sequence[Sequence[Named]]) -> OfEvent:
    own = [one for shop in named for one in shop if one.event == name]
    cuts = [one.cuts for one in own if one.cuts is not None]
    return OfEvent(name, len(own), len(cuts), float(np.median(cuts)) if cuts else None)


def _invented(named: Sequence[Sequence[Named]]) -> tuple[tuple[str, int, int], ...]:
    every = [[one.term for one in shop if not one.event] for shop in named]
    terms = sorted({term for shop in every for term in shop})
    return tuple(
        (term, sum(shop.count(term) for shop in every), sum(term in shop for shop in every))
        for term in terms
    )
