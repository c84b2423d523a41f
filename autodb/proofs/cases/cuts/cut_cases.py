"""Tables of cuts with hidden effects, each of a size that shows as clearly as wanted."""

from collections.abc import Iterator, Sequence

import numpy as np

from autodb.proofs.cases.base.build import TUNINGS, recorded_whole, simulated, sized, stacked
from autodb.proofs.cases.base.case import Array, Case, Rival, Yardstick
from autodb.proofs.cases.cuts.cut_effects import components_apart
from autodb.proofs.cases.cuts.cut_families import CUT_FAMILIES
from autodb.proofs.cases.cuts.cuts import CaseCuts, CutWorld, draw_cuts, draw_law, scatter_N

FORCES = ("force.x", "force.y", "force.z")
CUT_KINDS = tuple(family.kind for family in CUT_FAMILIES)


def draw_table_case(seed: int, kinds: Sequence[str], wanted: float, *, family: int) -> Case:
    """The table of a seed: these kinds of CUT_KINDS hidden, each with clarity ``wanted``.

    Clarity is over x, y and z together. Cuts, law, effects, scatter and simulation have streams of
    their own; families of seeds have nothing in common. The same arguments give the same bytes.
    """
    cutting, made, shaped, noisy, kept = (
        np.random.default_rng([family, seed, stream]) for stream in range(51, 56)
    )
    world = CutWorld(draw_cuts(cutting), draw_law(made))
    drawn = [f.draw(shaped, world.cuts) for kind in kinds for f in CUT_FAMILIES if f.kind == kind]
    scatter = scatter_N(world, made)

    def whitened(values: Array) -> Array:
        return np.asarray(values / scatter, dtype=np.float64)

    left_out = {effect.term for effect in drawn if effect.own}
    own = [term for term in world.parts if term not in left_out]
    columns = np.concatenate([components_apart(world.parts[term]) for term in own])
    world, effects = sized(world, drawn, Yardstick.beside(columns, whitened), wanted)

    truth, hidden = stacked(world, effects)
    measured = recorded_whole(world, effects, scatter * noisy.standard_normal(scatter.shape))
    included = np.array([world.parts[term] for term in own])
    tuning = str(kept.choice(TUNINGS))
    simulation = simulated(kept, included, columns, measured, tuning)
    channels = _channels(world.cuts)
    stretches = [effect.interval(world) for effect in drawn]
    return Case(
        seed=seed,
        kind="+".join(kinds) or "nothing",
        wanted=wanted,
        reached=all(one.clarity > 0.99 * wanted and np.any(one.part) for one in hidden),
        tuning=tuning,
        channels={**channels, **dict(zip(FORCES, measured, strict=True))},
        simulation={
            "cut": channels["cut"],
            "t": channels["t"],
            **dict(zip(FORCES, simulation, strict=True)),
        },
        includes=tuple(own),
        explained=FORCES,
        hidden=hidden,
        interval=next((stretch for stretch in stretches if stretch), None),
        measured=measured,
        simulated=simulation,
        truth=truth,
        own=columns,
        whitened=whitened,
        rivals=lambda: _rivals(world),
    )


def _channels(cuts: CaseCuts) -> dict[str, Array]:
    """Columns of a cut table but for its forces; of one edge its name is not told."""
    channels = {
        "cut": np.arange(1.0, cuts.t_s.size + 1.0),
        "t": cuts.t_s,
        "cutting.speed": cuts.speed_m_min,
        "cutting.feed": cuts.feed_mm,
        "cutting.depth": cuts.depth_mm,
        "work.diameter": cuts.diameter_mm,
        "spindle.speed": 1000.0 * cuts.speed_m_min / (np.pi * cuts.diameter_mm),
        "tool.cutting_time": cuts.used_s,
        "z.position": cuts.z_mm,
    }
    return {**channels, "tool.edge": cuts.edge} if cuts.labelled else channels


def _rivals(world: CutWorld) -> Iterator[Rival]:
    """Every effect at every shape of its grid, on these cuts."""
    for family in CUT_FAMILIES:
        for effect in family.grid(world.cuts):
            yield Rival(effect.term, effect.columns(world, world.base))
