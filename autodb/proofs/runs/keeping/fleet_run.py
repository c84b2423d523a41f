"""A new machine among others: how soon it predicts forces, alone and from what the others know; and
whether a machine that disagrees is named, with its cause.

Truth and error are the mean force of the next cuts, without scatter and without the machine's
gains. In each fleet no machine is off first, then one: its calibration by 30 to 60 %, or one of its
materials harder or softer by as much; which machine, which way and how far are drawn.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from autodb.pairs.disagreeing import Disagrees, compared, disagrees
from autodb.pairs.hierarchy import InformationOfCuts, KnownMaterial, information_of_cuts
from autodb.pairs.posterior import USUAL_SCATTER, PairPosterior
from autodb.pairs.updating import posterior_of_readings
from autodb.proofs.machines.lathe import fleets
from autodb.proofs.machines.lathe.power_pairs import PowerPair
from autodb.proofs.runs.pairs import pair_ours
from autodb.proofs.runs.pairs.curve_case import some
from autodb.proofs.runs.pairs.pair_cuts import TURN, Cut, ReadCuts, draw_read_cuts, true_forces
from autodb.proofs.runs.score import Z

Array = NDArray[np.float64]
Key = tuple[str, str]

MACHINES, CUTS = 10, 12
MATERIALS = 3
"""Pairs that each machine shares with the others: as many as distinguish calibration from
cutting."""
LEARNT = (0, 1, 2, 3, 4, 5, 6, 8, 10, 12, 16, 20)
"""Cuts of the new machine before its next are predicted."""
ASKED = 20
COMPONENTS = 3
OWN_GAINS = ("gain",)
"""What keys of a calibration's errors begin with, as ``pair_ours`` names them."""
OFF = (1.3, 1.6)
WAYS = ("alone", "others with its tool", "others with other tools")
CAUSES = ("none", "calibration", "cutting")


@dataclass(frozen=True)
class Joined:
    """A new machine and what it starts from (of WAYS): after each number of LEARNT the relative
    error of its next cuts, root of the mean square of |ΔF| over |F|, and the share of forces that
    95 % intervals hold.
    """

    way: str
    errors: tuple[float, ...]
    held: tuple[float, ...]


@dataclass(frozen=True)
class NamedOne:
    """A fleet with a machine that is off (of CAUSES): what that one was named as, if it was, and
    how many others were.
    """

    truth: str
    named: str | None
    others: int


def run_fleet(seed: int) -> list[Joined | NamedOne]:
    """Draw a seed's fleet; judge a new machine in it, and who is named."""
    rng = np.random.default_rng([seed, 12])
    fleet = fleets.draw_fleet(rng, materials=MATERIALS, tools=3)
    return [*_joined(rng, fleet), *(_named(rng, fleet, cause) for cause in CAUSES)]


def _joined(rng: np.random.Generator, fleet: fleets.Fleet) -> list[Joined]:
    """Let a new machine cut a material that the others cut with two of its three tools."""
    material, (first, second, third) = fleet.materials[0], fleet.tools
    known = KnownMaterial(_start(fleet.pairs[material, first]).law)
    for machine in range(MACHINES):
        tool = (first, second)[machine % 2]
        pair = fleets.on_machine(rng, fleet, [(material, tool)])[material, tool]
        known = known.changed(tool, more=_learnt(rng, pair)[0])
    found = []
    for tool in (first, third):
        pair = fleets.on_machine(rng, fleet, [(material, tool)])[material, tool]
        sensed = draw_read_cuts(rng, pair, TURN, LEARNT[-1])
        asked = tuple(TURN.draw(rng, pair) for _ in range(ASKED))
        others = PairPosterior(known.pair(tool), (), USUAL_SCATTER, 0)
        ways = {WAYS[1]: others} if tool == first else {WAYS[2]: others}
        for way, start in ({WAYS[0]: _start(pair), **ways} if tool == first else ways).items():
            found.append(Joined(way, *_course(start, pair, sensed, asked)))
    return found


def _start(pair: PowerPair) -> PairPosterior:
    return pair_ours.prior(pair.material)


def _course(
    start: PairPosterior, pair: PowerPair, sensed: ReadCuts, asked: tuple[Cut, ...]
) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Return errors and shares held after each number of cuts."""
    truth = np.array([true_forces(pair, cut) for cut in asked])[:, :COMPONENTS]
    size = np.linalg.norm(truth, axis=1)
    errors, held = [], []
    for count in LEARNT:
        posterior = start
        if count:
            posterior = posterior_of_readings(
                start, pair_ours.observed(pair, some(sensed, 0, count))
            )
        mean, sd = pair_ours.predicted_next(posterior, pair, TURN.name, asked)
        off = mean[:, :COMPONENTS] - truth
        errors.append(float(np.sqrt(np.mean((np.linalg.norm(off, axis=1) / size) ** 2))))
        held.append(float(np.mean(np.abs(off) <= Z * sd[:, :COMPONENTS])))
    return tuple(errors), tuple(held)


def _learnt(
    rng: np.random.Generator, pair: PowerPair
) -> tuple[InformationOfCuts, InformationOfCuts]:
    """Return the information of a pair's cuts: with the errors of its machine's gains, and
    without."""
    start = _start(pair)
    posterior = posterior_of_readings(
        start, pair_ours.observed(pair, draw_read_cuts(rng, pair, TURN, CUTS))
    ).past()
    return information_of_cuts(posterior.law, start.law), information_of_cuts(
        posterior.given(OWN_GAINS), start.law
    )


def _named(rng: np.random.Generator, fleet: fleets.Fleet, cause: str) -> NamedOne:
    """Let machines cut three materials with one tool, one machine off by a cause."""
    keys = [(material, fleet.tools[0]) for material in fleet.materials]
    victim = int(rng.integers(MACHINES))
    factor = float(np.exp(rng.choice([-1.0, 1.0]) * np.log(rng.uniform(*OFF))))
    known = {key: KnownMaterial(_start(fleet.pairs[key]).law) for key in keys}
    machines = []
    for machine in range(MACHINES):
        off = cause if machine == victim else CAUSES[0]
        pairs = _machine(rng, fleet, keys, off, factor)
        machines.append({key: _learnt(rng, pair) for key, pair in pairs.items()})
        for key in keys:
            known[key] = known[key].changed(key[1], more=machines[-1][key][0])
    named = {
        number: found.cause.name.lower()
        for number, own in enumerate(machines)
        if (found := _look(known, own)) is not None
    }
    return NamedOne(cause, named.pop(victim, None) if cause != CAUSES[0] else None, len(named))


def _machine(
    rng: np.random.Generator, fleet: fleets.Fleet, keys: Sequence[Key], off: str, factor: float
) -> dict[Key, PowerPair]:
    gain = factor if off == CAUSES[1] else 1.0
    pairs = fleets.on_machine(rng, fleet, keys, gain=gain)
    if off == CAUSES[2]:
        pairs[keys[0]] = fleets.harder_pair(pairs[keys[0]], factor)
    return pairs


def _look(
    known: Mapping[Key, KnownMaterial],
    own: Mapping[Key, tuple[InformationOfCuts, InformationOfCuts]],
) -> Disagrees | None:
    """Compare a machine with the others."""
    sides = [
        compared(
            as_sensed, as_stated=stated, others=known[key].without(key[1], stated).pair(key[1])
        )
        for key, (stated, as_sensed) in own.items()
    ]
    return disagrees(sides, compared_in_all=MACHINES * (len(known) + 1))
