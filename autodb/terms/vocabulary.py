"""Every effect that the program knows: its own terms, those of other packages, and effects without
a term.

A term from elsewhere is added with ``add_term``, or named by an entry point of the group
`autodb.terms` of an installed package. All that lists, fits, finds or names effects asks here when
it runs, so that every command knows it.
"""

from collections.abc import Collection, Iterator
from contextlib import contextmanager
from dataclasses import replace
from functools import cache
from importlib.metadata import entry_points

from autodb.errors import UnusableInput
from autodb.terms.chip import BUILT_UP_EDGE, HARD_SPOT, SIZE_EFFECT, SPEED_SOFTENING
from autodb.terms.drive import (
    COGGING,
    COMPLIANCE,
    CROSS_COUPLING,
    EXTERNAL_LOAD,
    FRICTION_RIPPLE,
    GRAVITY,
    INERTIA,
    SPRING,
    TILT,
    WINDAGE,
)
from autodb.terms.engagement import DEFLECTION, DEPTH_ERROR
from autodb.terms.friction import (
    ASYMMETRY,
    BACKLASH,
    COULOMB,
    POSITION_FRICTION,
    PRESLIDING,
    STRIBECK,
    VISCOUS,
)
from autodb.terms.nose import NOSE_AXIAL, NOSE_LENGTH, NOSE_RADIAL, NOSE_THINNING
from autodb.terms.process import EDGE_FORCE, EDGE_WEAR, SHEAR, TOOL_WEAR
from autodb.terms.ripple import COGGING_HARMONICS, COGGING_TABLE
from autodb.terms.sensor import GAIN, LAG, LOST_SIGN, SATURATION, SENSOR_DRIFT
from autodb.terms.table import (
    CROSSTALK,
    TABLE_GRAVITY_X,
    TABLE_GRAVITY_Y,
    TABLE_GRAVITY_Z,
    TABLE_INERTIA_X,
    TABLE_INERTIA_Y,
    TABLE_INERTIA_Z,
    THERMAL_DRIFT,
)
from autodb.terms.term import (
    Channel,
    Contribution,
    Home,
    NamedEffect,
    Term,
)
from autodb.terms.warming import WARMUP

TERMS: tuple[Term, ...] = (
    INERTIA,
    VISCOUS,
    COULOMB,
    GRAVITY,
    TILT,
    STRIBECK,
    ASYMMETRY,
    POSITION_FRICTION,
    FRICTION_RIPPLE,
    SPRING,
    COGGING,
    COGGING_HARMONICS,
    COGGING_TABLE,
    CROSS_COUPLING,
    WARMUP,
    PRESLIDING,
    BACKLASH,
    COMPLIANCE,
    LAG,
    WINDAGE,
    EXTERNAL_LOAD,
    SENSOR_DRIFT,
    GAIN,
    SATURATION,
    LOST_SIGN,
    SHEAR,
    EDGE_FORCE,
    TOOL_WEAR,
    EDGE_WEAR,
    SIZE_EFFECT,
    SPEED_SOFTENING,
    BUILT_UP_EDGE,
    HARD_SPOT,
    DEPTH_ERROR,
    NOSE_AXIAL,
    NOSE_RADIAL,
    NOSE_LENGTH,
    NOSE_THINNING,
    DEFLECTION,
    TABLE_GRAVITY_X,
    TABLE_GRAVITY_Y,
    TABLE_GRAVITY_Z,
    TABLE_INERTIA_X,
    TABLE_INERTIA_Y,
    TABLE_INERTIA_Z,
    THERMAL_DRIFT,
    CROSSTALK,
)

GROUP = "autodb.terms"
"""Entry points that name the terms of an installed package."""
RUNOUT = NamedEffect(
    name="runout",
    title="run-out of the tool",
    check="Check the run-out of the tool in its holder with a dial gauge, the taper for dirt, and "
    "the teeth for chips; force once a turn may be any of them, and another feed a tooth tells a "
    "chipped tooth from run-out.",
    check_source="Kline and DeVor, Int. J. Mach. Tool Des. Res. 23 (1983), 123-140; ISO 230-7 for "
    "the spindle",
    sits=("tool", "machine"),
    belongs_to="tool",
)
CHATTER = NamedEffect(
    name="chatter",
    title="chatter",
    check="Check the finished surface for marks, and overhang, clamping and edge; a narrow band at "
    "no multiple of the spindle's turning may be chatter, and another spindle speed or less depth "
    "shows it.",
    check_source="P1 section 2; Altintas, Manufacturing Automation, 2nd ed. (2012), chapter 4",
    sits=("machine", "tool", "pair"),
)
NO_NAME = NamedEffect(
    name="unknown",
    title="an effect without a known name",
    check="Check what else changed with the signals named here, such as tool, work, coolant, "
    "temperature or programme; a repeat that changes one of them at a time may tell.",
    check_source="P1 section 2",
    sits=("machine", "tool", "material", "sensor", "calibration", "pair"),
)
WITHOUT_TERM = (RUNOUT, CHATTER, NO_NAME)
TAKEN = frozenset({"size", "share", "slight", "change", "share_of_all"})
"""Names of numbers that an explanation says of any effect, or states as others."""
_added: list[Term] = []


def add_term(term: Term) -> None:
    """Add a term to those that every command knows.

    Raises UnusableInput where one of its name and form is there already, or where it lacks what the
    commands say of it or search for it with.
    """
    _refuse_incomplete(term, all_terms())
    _added.append(term)


@contextmanager
def added_terms(*terms: Term) -> Iterator[None]:
    """Add terms for the length of a block."""
    before = list(_added)
    try:
        for term in terms:
            add_term(term)
        yield
    finally:
        _added[:] = before


def all_terms() -> tuple[Term, ...]:
    """Return the program's own terms, then those that were added."""
    return (*TERMS, *_installed(), *_added)


@cache
def _installed() -> tuple[Term, ...]:
    """Return the terms of installed packages; an entry point names a term or a tuple of them."""
    found = list[Term]()
    for point in entry_points(group=GROUP):
        named = point.load()
        for term in named if isinstance(named, tuple) else (named,):
            _refuse_incomplete(term, (*TERMS, *found))
            found.append(term)
    return tuple(found)


def _refuse_incomplete(term: Term, known: tuple[Term, ...]) -> None:
    """Refuse a term that another one is called, or that lacks words, columns or starts."""
    said = f"term '{term.name}'" + (f" in the form '{term.form}'" if term.form else "")
    taken = {(one.name, one.form) for one in known} | {(one.name, "") for one in WITHOUT_TERM}
    if (term.name, term.form) in taken:
        raise UnusableInput(f"{said} is there already; give yours another name")
    if not term.name.isidentifier():
        raise UnusableInput(f"{said}: a name is one word of letters, digits and underscores")
    first = next((one for one in known if one.name == term.name), term)
    if first is term and term.form:
        raise UnusableInput(f"{said} has no plain form; add that first")
    for what in ("title", "check", "check_source"):
        if not getattr(first, what):
            raise UnusableInput(f"{said} has no {what}; reports and advice print it")
    if isinstance(term, Contribution) and not term.coefficients:
        raise UnusableInput(f"{said} has no coefficients; name one for each of its columns")
    for parameter in term.parameters:
        if parameter.name in TAKEN:
            raise UnusableInput(f"{said}: call '{parameter.name}' otherwise; explain uses it")
    for parameter in term.shape:
        if not parameter.keyword or not parameter.starts:
            raise UnusableInput(
                f"{said}: shape parameter '{parameter.name}' needs a keyword and starts"
            )


def vocabulary() -> frozenset[str]:
    """Return the names of every effect that a simulation may say it includes."""
    return frozenset(one.name for one in (*all_terms(), RUNOUT, CHATTER))


def effect_called(name: str) -> NamedEffect:
    """Return what is said of an effect; of a name that is not known here, what is said of none."""
    for one in (*all_terms(), *WITHOUT_TERM):
        if one.name == name:
            return one
    return replace(NO_NAME, name=name, title=name.replace("_", " "))


def title_of(name: str, variables: Collection[str]) -> str:
    """Return what an effect that depends on some variables is called: of several forms that one's
    which needs a signal where it does, as a weight that turns does beside a constant load.
    """
    forms = [one for one in all_terms() if one.name == name and one.title]
    alike = [one for one in forms if bool(one.needs) == bool(variables)]
    return alike[0].title if len(forms) > 1 and alike else effect_called(name).title


def term_called(name: str, form: str = "") -> Term:
    """Return the term of this name and form; raises UnusableInput where there is none."""
    for term in all_terms():
        if (term.name, term.form) == (name, form):
            return term
    raise UnusableInput(
        f"there is no term '{' '.join((name, form)).strip()}'; install the package that has it"
    )


def terms_on(channel: Channel) -> dict[str, Term]:
    """Return the terms of a kind of channel by name, of several forms the first."""
    found: dict[str, Term] = {}
    for term in all_terms():
        if channel in term.channels:
            found.setdefault(term.name, term)
    return found


def friction_terms() -> frozenset[str]:
    """Return the names of terms that are friction."""
    return frozenset(term.name for term in all_terms() if term.friction)


def of_the_machine() -> frozenset[str]:
    """Return the names of terms that belong to a machine and not to one recording."""
    return frozenset(term.name for term in all_terms() if term.belongs_to == "machine")


def where_kept(name: str, channel: str) -> Home:
    """Return where an effect confirmed in a channel is kept; of an unknown name its recording.

    What belongs to no machine's axis is found in forces, and kept if found there.
    """
    home = effect_called(name).belongs_to
    return home if home == "machine" or channel.startswith("force.") else "recording"


def statement_parts(statement: str) -> list[str]:
    """Return what was stated of a cause: what its effect does, empty where no term is, and the
    rest, where there is any.
    """
    does = next((t.statement for t in all_terms() if statement.startswith(t.statement)), "")
    rest = statement.removeprefix(does).strip()
    return [does, *filter(None, [rest])]
