"""Terms of another package: every command knows them, with no file of the program changed.

The truth is a drag that is largest at one speed, as eddy currents make it, and dry friction that an
acceleration presses, in formulas that are written here once more, another way, and noise.
"""

import json
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pytest
from numpy.testing import assert_allclose
from numpy.typing import NDArray
from pyarrow import csv

from autodb.agent.rows.machines import find_machine
from autodb.agent.sense.identifying import newest_model, stored_terms
from autodb.errors import UnusableInput
from autodb.explain import explain
from autodb.explain.answer import Cause
from autodb.records.tables import Recording
from autodb.sensing.drives.feed_axis import default_terms, identify
from autodb.store import open_store
from autodb.terms import vocabulary
from autodb.terms.term import Contribution, Factor, InputChange, Term, TermParameter
from autodb.terms.vocabulary import add_term, added_terms, all_terms, effect_called, term_called
from tests.conftest import Cli, Once
from tests.helpers.campaigns import first
from tests.helpers.trapezoids import COULOMB, INERTIA, VISCOUS, WEIGHT, moves

Array = NDArray[np.float64]
NOISE_A, LOAD_A = 0.02, 0.5
PEAK_A, PEAK_MM_S = 0.6, 25.0
"""The drag, and the speed where it is largest."""
PRESSED = 4e-4
"""Share of dry friction gained per mm/s² of acceleration."""
SETTLING_MM_S = 6.0
OWN = "coulomb,viscous,inertia,gravity"
ALL = f"{OWN},eddy_drag,pressed_friction"


def _eddy_drag(velocity_mm_s: Array, *, speed_mm_s: float) -> Array:
    return velocity_mm_s / (1.0 + (velocity_mm_s / speed_mm_s) ** 2)


def _pressed_friction(acceleration_mm_s2: Array, *, rise: float) -> Array:
    return 1.0 + rise * np.abs(acceleration_mm_s2) / 1000.0


def _settling(direction: Array, velocity_mm_s: Array, *, speed_mm_s: float) -> Array:
    return direction * np.abs(velocity_mm_s) / (np.abs(velocity_mm_s) + speed_mm_s)


DRAG = Contribution(
    name="eddy_drag",
    title="drag of eddy currents",
    channels=("axis",),
    inputs=("velocity",),
    function=_eddy_drag,
    coefficients=(TermParameter("coefficient", "U·s/mm", "drag per speed at creep", lower=0.0),),
    shape=(
        TermParameter(
            "speed", "mm/s", "speed of the largest drag", 1.0, 2000.0,
            keyword="speed_mm_s", starts=(10.0, 30.0, 100.0, 300.0),
        ),
    ),
    needs=("position",),
    statement="Eddy currents brake the slide, most of all at one speed.",
    excited_by="constant-speed passes in both directions at several speeds",
    source="Wouterse, IEE Proceedings B 138 (1991), 153-158",
    check="Check the gap of the eddy-current brake; a drag that falls at speed may come from it.",
    check_source="Wouterse, IEE Proceedings B 138 (1991), 153-158",
    belongs_to="machine",
)  # fmt: skip
PRESSING = Factor(
    name="pressed_friction",
    title="friction that acceleration presses",
    channels=("axis",),
    inputs=("acceleration",),
    function=_pressed_friction,
    shape=(
        TermParameter(
            "rise", "1", "share of friction gained per 1000 mm/s²", 0.0, 5.0,
            keyword="rise", starts=(0.1,),
        ),
    ),
    modifies=("coulomb",),
    needs=("position",),
    statement="An acceleration presses the guideways, and friction grows with it.",
    excited_by="moves at several accelerations",
    source="by construction",
    check="Check where the drive pulls; a slide that tilts may press its guideways.",
    check_source="by construction",
    belongs_to="machine",
)  # fmt: skip
SETTLING = InputChange(
    name="settling_friction",
    title="friction that settles with speed",
    channels=("axis",),
    inputs=("velocity",),
    function=_settling,
    changes=("direction",),
    shape=(
        TermParameter(
            "speed", "mm/s", "speed of half the friction", 0.1, 500.0,
            keyword="speed_mm_s", starts=(2.0, 20.0),
        ),
    ),
    modifies=("coulomb",),
    needs=("position",),
    statement="Friction comes to its level only as the axis runs faster.",
    excited_by="slow passes in both directions",
    source="by construction",
    check="Check the seals at creep speed; friction that comes with speed may be theirs.",
    check_source="by construction",
    belongs_to="machine",
)  # fmt: skip


@pytest.fixture(autouse=True)
def _added() -> Iterator[None]:
    with added_terms(DRAG, PRESSING):
        yield


def _effort(
    channels: dict[str, Array], *, drag: float = 1.0, pressed: float = 1.0, settling: float = 0.0
) -> Array:
    """Return the effort of an axis with shares of both effects, without noise."""
    v, a = channels["x.velocity"], channels["x.acceleration"]
    brake = 2.0 * PEAK_A * PEAK_MM_S * v / (PEAK_MM_S**2 + v**2)
    dry = COULOMB * np.clip(v / 0.05, -1.0, 1.0) * v**2 / (v**2 + settling * np.abs(v) + 1e-300)
    pressing = pressed * PRESSED * dry * np.sqrt(a**2)
    return dry + pressing + VISCOUS * v + INERTIA * a + WEIGHT + drag * brake


def _noise(channels: dict[str, Array], seed: int) -> Array:
    return np.random.default_rng([seed, 3]).normal(0, NOISE_A, len(channels["t"]))


def _written(name: str, seed: int, added: Array | float = 0.0, **share: float) -> Path:
    """Write a simulation, which has no noise, or a recording, which does."""
    channels = moves(seed)
    effort = _effort(channels, **share) + added
    csv.write_csv(pa.table({**channels, "x.current": effort}), name)
    return Path(name)


def _recorded(name: str, seed: int, added: Array | float = 0.0, **share: float) -> Path:
    return _written(name, seed, _noise(moves(seed), seed) + added, **share)


def _causes(printed: str) -> dict[str, dict[str, Any]]:
    found = json.loads(printed)["channels"]["x.current"]["missing"]
    return {cause["term"]: cause for cause in found}


def _size(cause: dict[str, Any], name: str = "size") -> float:
    return float(cause["parameters"][name]["value"])


@pytest.fixture
def machine(cli: Cli, once: Once) -> Cli:
    """Return the command line beside a machine that was seen before the effects, and one after."""

    def identify_both() -> None:
        cli("init")
        Path("m.toml").write_text("[axes.x]\n")
        before, air = _recorded("before.csv", 1, drag=0.0, pressed=0.0), _recorded("air.csv", 1)
        for name, terms, seen in (("plain", OWN, before), ("mill", ALL, air)):
            cli("machine", "add", name, "--file", "m.toml")
            done = cli("identify", seen, "--terms", terms, "--machine", name)
            assert done.code == 0
        assert "eddy_drag" in done.out

    once(identify_both)
    return cli


def _stored(name: str) -> dict[tuple[str, str], tuple[float, float]]:
    store = open_store("sqlite:///autodb.sqlite3")
    with store.reading() as session:
        row = newest_model(session, find_machine(session, name).id, "x.current")
        assert row is not None
        terms = stored_terms(row)
    store.close()
    return {(t.term, t.parameter): (t.value, t.sd or 0.0) for t in terms}


TRUTH = {
    ("eddy_drag", "coefficient"): 2.0 * PEAK_A / PEAK_MM_S,
    ("eddy_drag", "speed"): PEAK_MM_S,
    ("pressed_friction", "rise"): 1000.0 * PRESSED,
    ("coulomb", "level"): COULOMB,
}


def test_identify_recovers_their_parameters(machine: Cli) -> None:  # noqa: ARG001
    found = _stored("mill")
    for key, truth in TRUTH.items():
        value, sd = found[key]
        assert_allclose(value, truth, rtol=0.02, err_msg=str(key))
        assert 0.0 < sd < 0.01 * truth


def test_explain_says_that_they_are_missing(cli: Cli) -> None:
    recording = _recorded("b.csv", 2)
    simulation = _written("s.csv", 2, drag=0.0, pressed=0.0)
    said = cli("explain", recording, "--simulation", simulation).out
    assert f"eddy_drag: {DRAG.check}\n" in said
    assert f"pressed_friction: {PRESSING.check}\n" in said
    page = Path("b-explained/report.html").read_text()
    for term in (DRAG, PRESSING):
        assert f"{term.title} " in page.replace("</", " </")
        assert f"{term.check} <small>({term.check_source})</small>" in page
    found = _causes(Path("b-explained/explanation.json").read_text())
    assert set(found) == {"eddy_drag", "pressed_friction"}
    pressed = COULOMB * PRESSED * np.quantile(np.abs(moves(2)["x.acceleration"]), 0.9995)
    for name, size in (("eddy_drag", PEAK_A), ("pressed_friction", pressed)):
        assert found[name]["kind"] == "missing"
        assert found[name]["confidence"] >= 0.9
        assert_allclose(_size(found[name]), size, rtol=0.05)
    for (name, parameter), truth in TRUTH.items():
        if name in found:
            assert_allclose(_size(found[name], parameter), truth, rtol=0.02)
    assert found["eddy_drag"]["variables"] == ["x.velocity"]


@pytest.mark.parametrize("term", first(1, ["eddy_drag", "pressed_friction"]))
def test_explain_says_that_one_is_set_wrong(cli: Cli, term: str) -> None:
    share = {"eddy_drag": "drag", "pressed_friction": "pressed"}[term]
    simulation = _written("s.csv", 2, **{share: 0.7})
    done = cli(
        "explain", _recorded("b.csv", 2), "--simulation", simulation, "--includes", ALL, "--json"
    )
    (cause,) = _causes(done.out).values()
    assert (cause["term"], cause["kind"]) == (term, "mistuned")
    assert cause["confidence"] >= 0.9
    assert_allclose(_size(cause, "factor"), 1.0 / 0.7, rtol=0.02)


def test_nothing_is_said_of_a_simulation_that_has_them(cli: Cli) -> None:
    given = ("--simulation", _written("s.csv", 2), "--includes", ALL, "--json")
    assert _causes(cli("explain", _recorded("b.csv", 2), *given).out) == {}


def test_several_recordings_say_where_it_sits(cli: Cli) -> None:
    asked: list[Any] = ["explain"]
    for seed, name in ((2, "b"), (3, "c")):
        asked.append(_recorded(f"{name}.csv", seed))
        Path(f"{name}.toml").write_text('[recording]\nmachine = "mill"\n')
        asked += ["--simulation", _written(f"{name}-simulated.csv", seed, drag=0.0)]
    assert cli(*asked, "--self-contained").code == 0
    together = json.loads(Path("together/together.json").read_text())
    (effect,) = together["effects"]
    assert effect["term"] == "eddy_drag"
    assert [seat["factor"] for seat in effect["sits_in"]] == ["machine"]
    assert_allclose([v["value"] for v in effect["values"]], 2.0 * PEAK_A / PEAK_MM_S, rtol=0.05)
    assert DRAG.title in Path("together/together.html").read_text()
    assert not list(Path("together").rglob("*.js"))


def test_reconstruct_takes_them_off_the_load(machine: Cli) -> None:
    t = moves(4)["t"]
    load = np.where((t > 12.0) & (t < 28.0), LOAD_A, 0.0)
    cut = _recorded("cut.csv", 4, load)
    left = {}
    for name in ("plain", "mill"):
        machine("reconstruct", cut, "--machine", name, "--out", f"{name}.csv")
        sensed = csv.read_csv(f"{name}.csv")
        moving = np.array(sensed["x.state"].to_pylist()) == ""
        inner = (np.abs(t - 12.0) > 0.3) & (np.abs(t - 28.0) > 0.3) & moving
        left[name] = float(np.std((sensed["x.load"].to_numpy() - load)[inner]))
    assert left["mill"] < 0.02
    assert left["plain"] > 5.0 * left["mill"]


def test_the_machine_predicts_with_them(machine: Cli) -> None:
    recording = _recorded("d.csv", 5)
    found = json.loads(machine("explain", recording, "--machine", "mill", "--json").out)
    answer = found["channels"]["x.current"]
    assert answer["missing"] == []
    assert_allclose(answer["fit"]["rms_before"], NOISE_A, rtol=0.05)


def test_a_confirmed_one_becomes_part_of_the_machine_s_model(machine: Cli) -> None:
    assert ("eddy_drag", "speed") not in _stored("plain")
    machine("explain", _recorded("e.csv", 6, pressed=0.0), "--machine", "plain")
    said = machine("mismatch", "list", "plain").out
    number = next(line.split()[0] for line in said.splitlines() if "eddy_drag" in line)
    shown = machine("mismatch", "show", number).out
    assert f"advice: {DRAG.check} ({DRAG.check_source})" in shown
    done = machine("mismatch", "confirm", number)
    assert "version 2 of machine 'plain'" in done.out
    assert_allclose(_stored("plain")["eddy_drag", "speed"][0], PEAK_MM_S, rtol=0.02)


def test_a_change_of_an_input_is_fitted_and_found(monkeypatch: pytest.MonkeyPatch) -> None:
    def recording(seed: int, *, settling: float, noise: float) -> Recording:
        channels = moves(seed)
        effort = _effort(channels, drag=0.0, pressed=0.0, settling=settling)
        effort = effort + noise * _noise(channels, seed)
        return Recording(Path("moves.csv"), {**channels, "x.current": effort})

    monkeypatch.setattr(vocabulary, "_added", [])
    with added_terms(SETTLING):
        seen = recording(1, settling=SETTLING_MM_S, noise=1.0)
        model = identify(seen, terms=(*default_terms("axis"), "settling_friction"))
        assert_allclose(model.value("settling_friction"), SETTLING_MM_S, rtol=0.03)
        done = explain(seen, recording(1, settling=0.0, noise=0.0), includes=OWN.split(","))
    cause: Cause = done.explanation.channels["x.current"].missing[0]
    assert (cause.term, cause.kind) == ("settling_friction", "missing")
    assert_allclose(cause.parameters["speed"].value, SETTLING_MM_S, rtol=0.1)


REFUSED: tuple[tuple[Callable[[Term], Term], str], ...] = (
    (lambda t: t, "term 'eddy_drag' is there already; give yours another name"),
    (lambda t: replace(t, name="unknown"), "term 'unknown' is there already; "),
    (lambda t: replace(t, name="eddy drag"), "term 'eddy drag': a name is one word of letters"),
    (lambda t: replace(t, name="brake", title=""), "term 'brake' has no title; "),
    (lambda t: replace(t, name="brake", check=""), "term 'brake' has no check; "),
    (lambda t: replace(t, name="brake", check_source=""), "term 'brake' has no check_source; "),
    (lambda t: replace(t, name="brake", form="new"), "in the form 'new' has no plain form; "),
    (lambda t: replace(t, name="brake", coefficients=()), "term 'brake' has no coefficients; "),
    (
        lambda t: replace(t, name="brake", shape=(replace(t.shape[0], starts=()),)),
        "term 'brake': shape parameter 'speed' needs a keyword and starts",
    ),
    (
        lambda t: replace(t, name="brake", coefficients=(replace(t.coefficients[0], name="size"),)),
        "term 'brake': call 'size' otherwise; explain uses it",
    ),
)


@pytest.mark.parametrize(("changed", "said"), REFUSED)
def test_what_the_commands_could_not_use_is_refused(
    changed: Callable[[Term], Term], said: str
) -> None:
    before = all_terms()
    with pytest.raises(UnusableInput) as refused:
        add_term(changed(DRAG))
    assert said in str(refused.value)
    assert "\n" not in str(refused.value)
    assert all_terms() == before


def test_a_form_of_a_known_effect_has_its_words() -> None:
    with added_terms(replace(DRAG, form="cold", title="", check="", check_source="")):
        assert term_called("eddy_drag", "cold").form == "cold"
        assert effect_called("eddy_drag").title == DRAG.title


def test_without_its_package_a_term_is_refused_by_its_name(machine: Cli) -> None:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(vocabulary, "_added", [])
        cut = _recorded("cut.csv", 4)
        done = machine("reconstruct", cut, "--machine", "mill")
        assert done.code == 2
        assert "there is no term 'eddy_drag'; install the package that has it" in done.err
        assert effect_called("eddy_drag").title == "eddy drag"


def test_an_installed_package_s_entry_point_names_its_terms(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    class Point:
        def load(self) -> tuple[Term, ...]:
            return (SETTLING,)

    def entry_points(*, group: str) -> list[Point]:
        return [Point()] if group == "autodb.terms" else []

    monkeypatch.setattr(vocabulary, "entry_points", entry_points)
    vocabulary._installed.cache_clear()
    try:
        assert effect_called("settling_friction") is SETTLING
    finally:
        vocabulary._installed.cache_clear()
        monkeypatch.undo()
    assert SETTLING not in all_terms()
