"""What `identify` prints: the terms of an axis, how far off they are, and what is kept of them."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

from autodb.cli._common import say, show, table
from autodb.cli._reader import headed, shown_again
from autodb.cli.understand.over_time import say_time
from autodb.cli.understand.staging import show_sweep
from autodb.wording import day, listed, localized, msgid, phrase, shop_amount, significant

if TYPE_CHECKING:
    from collections.abc import Mapping

    from autodb.agent.sense.identifying import KeptModel, ModelVersion
    from autodb.records import tables
    from autodb.sensing.drives.fit.axis_model import Identified, IdentifiedTerm, PlainFit
    from autodb.sensing.drives.fit.discrepancy import FrictionDiscrepancy
    from autodb.sensing.drives.masses import Mass

KEEPS = msgid("ripple: {amplitude}, keeps its sign in both directions ({term})")
FLIPS = msgid("ripple: {amplitude}, flips with the direction ({term})")
KEEPS_FIRST = msgid(
    "ripple: {amplitude}, its first harmonic, keeps its sign in both directions ({term})"
)
FLIPS_FIRST = msgid("ripple: {amplitude}, its first harmonic, flips with the direction ({term})")
TWICE = 2.0
"""Times its friction of before that no axis comes to by wear between two sweeps. Chosen."""
MOST_IN_SPREAD = 8
"""Coefficients that a table over filters has room for."""


def show_fit(
    model: "Identified",
    moves: "tables.Recording",
    other: "tables.Recording | None",
    spread: "list[PlainFit]",
) -> None:
    """Print the terms, how far off they are, and what they owe to the filter."""
    _show_terms(model)
    _say_of_model(model)
    say_time(moves)
    show_sweep(model, moves)
    if other is not None:
        _show_cross_test(model, other)
    _show_spread(spread)


def show_masses(masses: "Mapping[str, Mass]") -> None:
    """Print the mass of each slide alone, where it is known."""
    if not masses:
        return
    factor, unit = shop_amount(1.0, "kg")
    said = (
        f"{axis} {localized(f'{factor * mass.kg:.4g} ± {factor * mass.sd_kg:.2g}')} {unit}"
        for axis, mass in masses.items()
    )
    say(phrase("slides alone (± 1 sd): {masses}", masses=", ".join(said)))


def show_versions(versions: "Sequence[ModelVersion]") -> None:
    """Print the numbers of each version: how the axis drifted."""
    from autodb.sensing.drives.fit.axis_model import readable

    if not versions:
        return
    every = [t for v in versions for t in readable(v.terms)]
    names = list(dict.fromkeys((t.key, t.parameter) for t in every))
    units = {(t.key, t.parameter): _shop_unit(t.unit)[1] for v in versions for t in v.terms}
    heads = (f">{key} {parameter} [{units[key, parameter]}]" for key, parameter in names)
    head = (headed(phrase("version")), phrase("day"), phrase("from"))
    rows = table(phrase("Versions"), *head, *heads)
    for version in versions:
        known = {(t.key, t.parameter): t for t in version.terms}
        numbers = (_with_sd(known.get(name)) for name in names)
        files = ", ".join(version.recordings)
        rows.add_row(str(version.number), day(version.day), files, *numbers)
    show(rows)


def _with_sd(term: "IdentifiedTerm | None") -> str:
    if term is None:
        return ""
    return f"{_number(term.value, term.unit, '.4g')} ± {_number(term.sd or 0.0, term.unit, '.2g')}"


def _show_terms(model: "Identified") -> None:
    """Print a table of the terms of a model, and of plain least squares beside them."""
    from autodb.sensing.drives.fit.axis_model import amplitudes, readable

    plain = {(t.key, t.parameter): t for t in model.plain.terms}
    rows = table(
        phrase("{channel} of axis {axis}", channel=model.channel, axis=model.axis),
        *(phrase("term"), phrase("parameter"), headed(phrase("value")), headed(phrase("sd"))),
        *(phrase("unit"), headed(phrase("plain least squares")), headed(phrase("sd"))),
    )
    for term in [*readable(model.fitted), *amplitudes(model)]:
        other = plain.get((term.key, term.parameter))
        beside = _numbers(other) if other else ("", "")
        unit = _shop_unit(term.unit)[1]
        rows.add_row(term.key, term.parameter, *_numbers(term), unit, *beside)
    show(rows)


def _say_of_model(model: "Identified") -> None:
    """Print how far off a model is, what it does not hold, and its ripples."""
    from autodb.sensing.drives.fit.axis_model import amplitudes

    factor, unit = shop_amount(1.0, model.unit)
    rms = localized(f"{factor * model.residual_rms:.3f}")
    error = _percent(model.relative_error)
    say(phrase("relative error {error} %, rms {rms} {unit}", error=error, rms=rms, unit=unit))
    said = phrase(
        "plain least squares: {error} %, and {held_out} % on held-out blocks of motion",
        error=_percent(model.plain.relative_error), held_out=_percent(model.held_out_error),
    )  # fmt: skip
    say(said)
    say(phrase("protocol: {what}", what=shown_again(str(model.protocol))))
    if model.unit == "A":
        said = phrase(
            "in amperes; determine the force constant (N/A) with 'autodb scale', from a known "
            "mass, a push or a standard cut"
        )
        say(said)
    for sentence in model.not_excited:
        say_not_excited(sentence)
    for sentence in model.doubts:
        say(phrase("doubtful: {what}", what=shown_again(sentence)))
    for t in amplitudes(model):
        scale, shown = shop_amount(1.0, t.unit)
        amplitude = f"{localized(significant(scale * t.value))} {shown}"
        said = phrase(_ripple_sentence(t), amplitude=amplitude, term=t.term)
        say(said)
    _show_cogging(model)


def say_not_excited(sentence: str) -> None:
    """Print a parameter that no move excited, and the moves that would."""
    name, _, move = sentence.partition(": ")
    move = phrase(move) if move else move
    say(phrase("not excited, not estimated: {name}: {move}", name=name, move=move))


def _ripple_sentence(t: "IdentifiedTerm") -> str:
    if t.form == "tilt":
        return msgid("weight: at most {amplitude} at the angle that lifts it ({term})")
    flips = t.form == "periodic"
    if t.form in ("table", "harmonics"):
        return FLIPS_FIRST if flips else KEEPS_FIRST
    return FLIPS if flips else KEEPS


def _percent(share: float) -> str:
    return localized(f"{100 * share:.2f}")


def _show_cogging(model: "Identified") -> None:
    """Print which form of cogging was kept, and what each leaves of blocks left out."""
    for kept in (one for one in model.cogging if one.kept):
        tried = listed(
            phrase("{form} {error} %", form=one.called, error=_percent(one.held_out_error))
            for one in model.cogging
        )
        scale, unit = shop_amount(1.0, "deg" if model.axis in "abc" else "mm")
        said = phrase(
            "cogging: {form} over {period} {unit} kept; on held-out blocks: {tried}",
            form=kept.called, period=localized(f"{scale * kept.period:.5g}"), unit=unit,
            tried=tried,
        )  # fmt: skip
        say(said)


def _show_cross_test(model: "Identified", other: "tables.Recording") -> None:
    """Print how well the model does on a recording that it was not fitted to."""
    from autodb.sensing.drives.feed_axis import cross_test, without_ripple

    def error(
        terms: "Sequence[IdentifiedTerm]", off_law: "FrictionDiscrepancy | None" = None
    ) -> str:
        return _percent(cross_test(other, model.axis, model.protocol, terms, off_law))

    plain, file = [*model.plain.terms, *model.plain.given], other.path.name
    said = phrase(
        "on {file}: relative error {error} %; plain least squares {plain} %",
        file=file, error=error(model.terms, model.off_law), plain=error(plain),
    )  # fmt: skip
    say(said)
    smooth = without_ripple(model.terms)
    if len(smooth) < len(model.terms):
        say(phrase("on {file} without the ripple: {error} %", file=file, error=error(smooth)))


def show_kept(kept: "KeptModel", machine: str) -> None:
    """Print which version a model became, and what moved since the one it started from."""
    model = kept.model
    nodes = [m for m in model.moved if m.parameter.startswith("node_")]
    if nodes:
        said = phrase(
            "moved since version {version}: {count} nodes of {term}",
            version=kept.parent, count=len(nodes), term=nodes[0].key,
        )  # fmt: skip
        say(said)
    for m in (m for m in model.moved if m not in nodes):
        before, now = (_number(v, m.unit, ".6g") for v in (m.before, m.now))
        before_sd, now_sd = (_number(v, m.unit, ".2g") for v in (m.before_sd, m.now_sd))
        said = phrase(
            "moved since version {version}: {term} {parameter} from {before} ± {before_sd} to "
            "{now} ± {now_sd} {unit}",
            version=kept.parent, term=m.key, parameter=m.parameter, before=before,
            before_sd=before_sd, now=now, now_sd=now_sd, unit=_shop_unit(m.unit)[1],
        )  # fmt: skip
        say(said)
        if m.key == "coulomb" and m.now > TWICE * m.before:
            said = phrase(
                "{axis} takes more than {times} times the friction it took: a brake that drags, a "
                "clamp, or a dry way?",
                axis=model.axis, times=f"{TWICE:g}",
            )  # fmt: skip
            say(said)
    _say_version(kept, machine)


def _say_version(kept: "KeptModel", machine: str) -> None:
    what = phrase(
        "{channel}: version {version} of machine '{machine}'",
        channel=kept.model.channel, version=kept.version, machine=machine,
    )  # fmt: skip
    if kept.already_there:
        what = phrase("{what}: already there", what=what)
    elif kept.parent is not None:
        what = phrase("{what}, started from version {parent}", what=what, parent=kept.parent)
        if not kept.model.moved:
            what = phrase("{what}; nothing moved by more than its uncertainty", what=what)
    say(what)


def _numbers(term: "IdentifiedTerm") -> tuple[str, str]:
    sd = phrase("given") if term.sd == 0 else _number(term.sd or 0.0, term.unit, ".2g")
    return _number(term.value, term.unit, ".6g"), sd


def _number(value: float, unit: str, form: str) -> str:
    return localized(f"{value * _shop_unit(unit)[0]:{form}}")


def _shop_unit(unit: str) -> tuple[float, str]:
    """Return factor and unit that a shop reads: kg and N·s/m where the effort is in newtons."""
    known = {"N·s²/mm": (1000.0, "kg"), "N·s/mm": (1000.0, "N·s/m")}
    factor, read = known.get(unit, (1.0, unit))
    scale, shown = shop_amount(1.0, read)
    return factor * scale, shown


def _show_spread(spread: "list[PlainFit]") -> None:
    if not spread or len(spread[0].terms) > MOST_IN_SPREAD:
        return
    names = [f"{t.key} {t.parameter}" for t in spread[0].terms]
    heads = [name.replace(" level", "").replace(" coefficient", "") for name in names]
    heads = heads if len(set(heads)) == len(heads) else names
    rows = table(
        phrase("Plain least squares over filters"),
        *(headed(phrase("low-pass Hz")), phrase("anti-alias"), *(f">{n}" for n in heads)),
        headed(phrase("error %")),
    )
    for fit in spread:
        rows.add_row(
            localized(f"{fit.protocol.cutoff_hz:g}"),
            phrase("yes") if fit.protocol.anti_alias else phrase("no"),
            *(_number(t.value, t.unit, ".5g") for t in fit.terms),
            _percent(fit.relative_error),
        )
    show(rows)
