"""Milled cuts with hidden effects, each of a size that shows as clearly as wanted."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from autodb.proofs.cases.base.build import TUNINGS, recorded_whole, simulated, sized, stacked
from autodb.proofs.cases.base.case import Array, Case, Rival, Yardstick
from autodb.proofs.cases.mill.mill_families import MILL_FAMILIES
from autodb.proofs.cases.mill.milling import (
    Milling,
    MillWorld,
    draw_link_noise,
    draw_mill_law,
    draw_milling,
)

FORCES = ("force.x", "force.y", "force.z")


@dataclass(frozen=True)
class MillCase(Case):
    """A case with what its side file says of tool and cut."""

    side: Mapping[str, Mapping[str, float | str]]


def draw_mill_case(seed: int, kinds: Sequence[str], wanted: float, *, family: int) -> MillCase:
    """The milled cut of a seed: these kinds of MILL_KINDS hidden, each with clarity ``wanted``.

    Clarity is over x, y and z together. Cut, law, effects, noise and simulation have streams of
    their own; families of seeds have nothing in common. The same arguments give the same bytes.
    """
    cutting, made, shaped, noisy, kept = (
        np.random.default_rng([family, seed, stream]) for stream in range(61, 66)
    )
    families = [one for kind in kinds for one in MILL_FAMILIES if one.kind == kind]
    cut = draw_milling(cutting, tilts=any(one.tilts for one in families))
    world = MillWorld(cut, draw_mill_law(made), (0.0,) * cut.teeth)
    noise = draw_link_noise(made)
    drawn = [one.draw(shaped, world) for one in families]

    left_out = {effect.term for effect in drawn if effect.own}
    own = [term for term in world.parts if term not in left_out]
    columns = world.courses[[("shear", "edge_force").index(term) for term in own]]
    columns = columns.reshape(-1, 3, cut.t_s.size)
    world, effects = sized(world, drawn, Yardstick.beside(columns, noise.whitened), wanted)

    truth, hidden = stacked(world, effects)
    disturbed = np.array([noise.draw(noisy, cut.t_s.size) for _ in FORCES])
    measured = recorded_whole(world, effects, disturbed)
    included = np.array([world.parts[term] for term in own])
    tuning = str(kept.choice(TUNINGS))
    simulation = simulated(kept, included, columns, measured, tuning)
    stretches = [effect.interval(world) for effect in drawn]
    return MillCase(
        seed=seed,
        kind="+".join(kinds) or "nothing",
        wanted=wanted,
        reached=all(one.clarity > 0.99 * wanted and np.any(one.part) for one in hidden),
        tuning=tuning,
        channels={**_channels(kept, cut), **dict(zip(FORCES, measured, strict=True))},
        simulation={"t": cut.t_s, **dict(zip(FORCES, simulation, strict=True))},
        includes=tuple(own),
        explained=FORCES,
        hidden=hidden,
        interval=next((stretch for stretch in stretches if stretch), None),
        measured=measured,
        simulated=simulation,
        truth=truth,
        own=columns,
        whitened=noise.whitened,
        rivals=lambda: _rivals(world),
        side=_side(cut),
    )


def _channels(rng: np.random.Generator, cut: Milling) -> dict[str, Array]:
    """Time, slide and table; of every fourth the spindle's angle was not recorded."""
    channels = {"t": cut.t_s, "x.position": cut.x_mm}
    if np.any(cut.a_rad) or np.any(cut.c_rad):
        channels |= {"a.angle": np.degrees(cut.a_rad), "c.angle": np.degrees(cut.c_rad)}
    if rng.random() < 0.25:
        return {**channels, "spindle.speed": np.full_like(cut.t_s, cut.speed_rpm)}
    return {**channels, "spindle.angle": np.degrees(cut.angle_rad)}


def _side(cut: Milling) -> dict[str, dict[str, float | str]]:
    """What a shop writes down of tool and cut."""
    return {
        "tool": {
            "diameter_mm": cut.diameter_mm,
            "teeth": cut.teeth,
            "helix_deg": float(np.degrees(cut.helix_rad)),
        },
        "cut": {
            "operation": cut.operation,
            "depth_mm": cut.depth_mm,
            "width_mm": cut.width_mm,
            "feed_mm_tooth": cut.feed_mm,
            "speed_rpm": cut.speed_rpm,
            "feed_direction_deg": float(np.degrees(cut.direction_rad)),
        },
    }


def _rivals(world: MillWorld) -> Iterator[Rival]:
    """Every effect at every shape of its grid, on this cut."""
    for family in MILL_FAMILIES:
        for effect in family.grid(world):
            yield Rival(effect.term, effect.columns(world, world.base))
