"""Explain one axis effort over time."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from autodb.errors import UnusableInput
from autodb.explain import search
from autodb.explain.answer import ChannelAnswer, Considered, FitQuality, Trace, Where
from autodb.explain.axis import NAMED, AxisColumns, axis_columns, simulation_terms
from autodb.explain.causes import SIMPLE_ENOUGH, named_cause, plain_key, retuned, unknown_cause
from autodb.explain.fit import Estimate, estimate, held_out, quality, rms
from autodb.explain.locate import regimes
from autodb.explain.noise import Whitener
from autodb.explain.propose import propose
from autodb.explain.state import State, accepted_whitener, gram_of, noise_floor, whitener_of, work
from autodb.records import Recording

Array = NDArray[np.float64]

WORKING_HZ = 100.0
"""Rate that the search works at: friction, inertia and loads of an axis are slower."""
SHORTEST_S = 9.9
SHORTEST_ROWS = 300
GLITCH = 1000.0
GLITCH_ROWS = 20
"""A value GLITCH times the 20th largest is a glitch of the logger, not an effort."""
SURE_SDS = 4.0
GAP_S = 0.25
"""Rows this near to a block left out are not fitted on: noise is correlated over such times."""


def explain_axis(
    recording: Recording, simulation: Array, channel: str, includes: list[str] | None
) -> tuple[ChannelAnswer, Trace]:
    """Say what the simulation of one effort channel leaves out.

    ``simulation`` (n,) on the recording's time; ``includes`` the terms it already has, read off it
    when None.
    """
    measured = recording[channel]
    _check(recording, channel, measured, simulation)
    columns = axis_columns(recording, channel)
    own = _own_columns(simulation, columns, includes)
    state = State(
        t_s=recording.t_s,
        difference=measured - simulation,
        own=own,
        blocks=_blocks(columns, own),
        factor=max(1, int(recording.rate_hz / WORKING_HZ)),
        finer=columns.finer,
    )
    differs = rms(state.difference) > 1e-9 * max(rms(measured), rms(simulation))
    whitener = _search(state, columns) if differs else None
    trace = Trace(
        x_name="t",
        x=recording.t_s,
        recording=measured,
        simulation=simulation,
        corrected=simulation,
        regime_signals=columns.signals,
        considered=_considered(state),
    )
    unit = recording.unit(channel)
    if whitener is None:
        return _alike(unit), trace
    return _answer(state, columns, trace, unit, whitener)


def _alike(unit: str) -> ChannelAnswer:
    """Return the answer where recording and simulation are the same numbers."""
    return ChannelAnswer(
        unit=unit,
        mismatch=False,
        where=Where(),
        missing=(),
        fit=FitQuality(
            rms_before=0.0, rms_after=0.0, heldout_before=0.0, heldout_after=0.0, noise_floor=0.0
        ),
    )


def _check(recording: Recording, channel: str, measured: Array, simulation: Array) -> None:
    """Refuse what no search can judge: too short, or a glitch that outweighs everything."""
    seconds = float(recording.t_s[-1] - recording.t_s[0])
    if seconds < SHORTEST_S or len(recording) < SHORTEST_ROWS:
        raise UnusableInput(
            f"{recording.path}: {len(recording)} rows over {seconds:.3g} s are too short to leave "
            f"parts out of the fit; {SHORTEST_S:g} s and {SHORTEST_ROWS} rows would work"
        )
    for name, values in (("recording", measured), ("simulation", simulation)):
        size = np.abs(values)
        row, others = int(np.argmax(size)), float(np.partition(size, -GLITCH_ROWS)[-GLITCH_ROWS])
        if size[row] > GLITCH * others > 0:
            raise UnusableInput(
                f"{recording.path}: {channel} of the {name}, row {row + 1}: {values[row]:.3g} is "
                f"over {GLITCH:g} times all but a few rows; without that row it would work"
            )


def _own_columns(
    simulation: Array, columns: AxisColumns, includes: list[str] | None
) -> dict[str, Array]:
    """Return the columns of the simulation's own terms, and what of it they do not give."""
    read = simulation_terms(simulation, columns.named)
    names = [n for n in NAMED if n in (read if includes is None else includes)]
    own = {name: columns.named[name] for name in names}
    if own:
        matrix = np.column_stack(list(own.values()))
        rest = simulation - matrix @ np.linalg.lstsq(matrix, simulation, rcond=None)[0]
    else:
        rest = simulation
    if rms(rest) > 1e-3 * rms(simulation) and rms(rest) > 0:
        own["rest"] = rest
    return own


def _blocks(columns: AxisColumns, own: dict[str, Array]) -> dict[str, search.Block]:
    named = [
        search.Block(name, name, column[:, None], _variables(columns, name))
        for name, column in columns.named.items()
        if name not in own
    ]
    shapes = [search.Block(s.key, "unknown", s.columns, s.variables) for s in columns.shapes]
    return {block.key: block for block in (*named, *shapes)}


def _variables(columns: AxisColumns, term: str) -> tuple[str, ...]:
    place, speed = columns.signals
    axis = place.split(".", maxsplit=1)[0]
    of = {
        "coulomb": (f"{axis}.direction",),
        "viscous": (speed,),
        "inertia": (f"{axis}.acceleration",),
        "gravity": (),
        "external_load": ("t",),
    }
    return of[term]


def _search(state: State, columns: AxisColumns) -> Whitener:
    """Accept blocks one by one; the noise is estimated again after each."""
    for _ in range(search.MAX_STEPS):
        propose(state, columns, whitener_of(state))
        whitener = whitener_of(state)
        gram = gram_of(state, whitener, detail=True)
        step = search.step(gram, state.active, list(state.blocks.values()))
        state.first_step = state.first_step or step
        if step is None or not step.accepted:
            break
        key = _simplest(gram, state, step)
        state.active.append(key)
        state.chosen[key] = step.evidence
        if key in state.finer:
            state.detail[key] = state.finer[key]
    whitener = whitener_of(state)
    gram = gram_of(state, whitener, detail=False)
    kept = search.eliminate(gram, state.active, list(state.blocks.values()))
    state.active = _not_vetoed(state, kept)
    if "coulomb" in state.active:
        state.own["coulomb around standstill"] = state.finer["coulomb"]
    return whitener


def _not_vetoed(state: State, keys: list[str]) -> list[str]:
    """Return the blocks, in order, with which blocks of motion left out are predicted better."""
    own, difference = work(state, state.own_matrix()), work(state, state.difference)
    gap = round(GAP_S * WORKING_HZ)
    kept: list[str] = []
    best = rms(difference)
    for key in [k for k in state.active if k in keys]:
        columns = np.column_stack([own, state.working([*kept, key])])
        score = rms(held_out(columns, difference, gap=gap))
        if score < best:
            kept.append(key)
            best = score
    return kept


def _simplest(gram: search.Gram, state: State, step: search.Step) -> str:
    """Return the one-parameter law that does nearly as well as the best family, or the best."""
    if step.best.term != "unknown":
        return step.best.key
    without = gram.rss(gram.columns(state.active))

    def explained(key: str) -> float:
        return without - gram.rss(gram.columns([*state.active, key]))

    simple = [n for n in NAMED if n in state.blocks and n not in state.active]
    best = max(simple, key=explained, default=None)
    if best is None or explained(best) < SIMPLE_ENOUGH * explained(step.best.key):
        return step.best.key
    return best


def _answer(
    state: State, columns: AxisColumns, trace: Trace, unit: str, whitener: Whitener
) -> tuple[ChannelAnswer, Trace]:
    """Turn the accepted columns into causes, a corrected channel and scores."""
    _drop_unsure(state, whitener)
    named, shapes = state.named(), state.shapes()
    fitted, correction, unknown_part = _fit(state, named, shapes, whitener)
    causes = [named_cause(state, key, at, fitted, unit) for key, at in _places(state, named)]
    if shapes:
        share = (
            1.0
            - (
                rms(state.difference - correction)
                / rms(state.difference - correction + unknown_part)
            )
            ** 2
        )
        causes.append(unknown_cause(state, shapes, part=unknown_part, share=share, unit=unit))
    causes += retuned(state, fitted, trace.simulation, whitener, unit)
    if not causes:
        correction = np.zeros_like(correction)
    parts = np.column_stack([state.own_matrix(), state.matrix(state.active)])
    after = state.difference - correction
    answer = ChannelAnswer(
        unit=unit,
        mismatch=bool(causes),
        where=Where(
            intervals=tuple(state.intervals[k] for k in named if k in state.intervals),
            regime=tuple(regimes(correction, columns.signals) if causes else ()),
        ),
        missing=tuple(causes),
        fit=quality(
            before=state.difference,
            after=after,
            columns=parts if causes else state.none(),
            floor=noise_floor(state),
            gap=round(GAP_S / float(np.median(np.diff(state.t_s)))),
        ),
        unexplained=_unexplained(state, after, len(causes)),
    )
    return answer, replace(trace, corrected=trace.simulation + correction)


def _drop_unsure(state: State, whitener: Whitener) -> None:
    """Take back named blocks whose value is not ``SURE_SDS`` honest standard deviations from none.

    Slow noise can pass the search, which judges with the saturated model's noise.
    """
    named = state.named()
    fitted, _, _ = _fit(state, named, [], whitener)
    for key, at in _places(state, named):
        if abs(fitted.coefficients[at]) < SURE_SDS * fitted.sd[at]:
            state.active.remove(key)


def _places(state: State, named: list[str]) -> list[tuple[str, int]]:
    """Return each named block with the place of its first column."""
    widths = [state.blocks[key].columns.shape[1] for key in named]
    return list(zip(named, (np.cumsum(widths) - widths).tolist(), strict=True))


def _fit(
    state: State, named: list[str], shapes: list[str], whitener: Whitener
) -> tuple[Estimate, Array, Array]:
    """Fit named and own columns first, the unnamed shapes on what those leave.

    A shape can imitate a named column; fitted second it cannot change the named one's size. The
    saturated model takes slow noise into its own smooth columns: standard deviations are the larger
    of those with its noise and with the noise that the accepted columns leave.
    """
    first = np.column_stack([state.matrix(named), state.own_matrix()])
    fitted = _estimate(state, first, whitener)
    slow = _estimate(state, first, accepted_whitener(state))
    fitted = Estimate(fitted.coefficients, np.maximum(fitted.sd, slow.sd))
    correction = first @ fitted.coefficients
    second = state.matrix(shapes)
    if not shapes:
        return fitted, correction, np.zeros_like(correction)
    left = whitener(work(state, np.column_stack([second, state.difference - correction])))
    unknown_part = second @ estimate(left[:, :-1], left[:, -1]).coefficients
    return fitted, correction + unknown_part, unknown_part


def _estimate(state: State, columns: Array, whitener: Whitener) -> Estimate:
    white = whitener(work(state, np.column_stack([columns, state.difference])))
    return estimate(white[:, :-1], white[:, -1])


def _unexplained(state: State, after: Array, causes: int) -> str | None:
    if len(state.active) < search.MAX_STEPS:
        return None
    share = rms(after) ** 2 / rms(state.difference) ** 2
    return f"{100 * share:.0f} % of the difference's energy is left after {causes} causes."


def _considered(state: State) -> tuple[Considered, ...]:
    if state.first_step is None:
        return ()
    values = state.first_step.evidence
    return tuple(
        Considered(
            name=plain_key(key),
            evidence=value,
            verdict="accepted" if key in state.active else "not needed",
        )
        for key, value in sorted(values.items(), key=lambda item: -item[1])
    )
