"""The proof of explanations: its runs, its tables, its command, and what draws its cases."""

import ast
import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from types import ModuleType

import pytest

from autodb.proofs import catalogue
from autodb.proofs.carrying_out import begin_runs, carry_out
from autodb.proofs.cases.plan import PlannedCase, draw_concealed
from autodb.proofs.catalogue import PROOFS, Proof, proof
from autodb.proofs.generators import CONCEALED, CONCEALED_MILLS
from autodb.proofs.runs.explain import left_out
from autodb.proofs.runs.explain.explain_score import ScoredCase
from autodb.proofs.runs.explain.explain_summary import ExplainSummary
from autodb.proofs.runs.found import markdown
from tests.conftest import ROOT, Cli
from tests.helpers.explained_cases import entry, scored

EXPLAIN = proof("explain")


def _by_seed(seed: int) -> list[ScoredCase]:
    """A right answer, but for every fifth; every third hides nothing."""
    if seed % 3 == 0:
        return [replace(scored(()), seed=seed)]
    named = (entry("lag" if seed % 5 == 0 else "spring", 0.5 + 0.01 * seed),)
    return [replace(scored(("spring",), *named), seed=seed)]


def _made(run: Callable[[int], list[ScoredCase]]) -> Proof[ScoredCase]:
    return replace(EXPLAIN, run=run)


def _files(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in folder.iterdir()}


@pytest.mark.parametrize("after", [0, 1, 7])
def test_an_interrupted_proof_goes_on_and_ends_the_same(tmp_path: Path, after: int) -> None:
    called: list[int] = []

    def interrupted(seed: int) -> list[ScoredCase]:
        if len(called) == after:
            raise KeyboardInterrupt
        called.append(seed)
        return _by_seed(seed)

    carry_out(begin_runs(_made(_by_seed), tmp_path / "one"), 12, progress=lambda _: None)
    with pytest.raises(KeyboardInterrupt):
        carry_out(begin_runs(_made(interrupted), tmp_path / "two"), 12, progress=lambda _: None)
    assert sorted(begin_runs(_made(_by_seed), tmp_path / "two").finished) == called
    carry_out(begin_runs(_made(_by_seed), tmp_path / "two"), 12, progress=lambda _: None)
    assert _files(tmp_path / "one") == _files(tmp_path / "two")


@pytest.mark.campaign
def test_two_workers_find_what_one_finds(tmp_path: Path) -> None:
    counts: list[int] = []
    quick = proof("pairs")
    two = carry_out(begin_runs(quick, tmp_path / "two"), 2, progress=counts.append, workers=2)
    one = carry_out(begin_runs(quick, tmp_path / "one"), 2, progress=lambda _: None)
    assert one == two
    assert counts == [0, 1, 2]
    lines = [(tmp_path / name / "pairs.jsonl").read_bytes().splitlines() for name in ("one", "two")]
    assert sorted(lines[0]) == sorted(lines[1])


def test_a_summary_comes_back_from_json_and_prints_every_table(tmp_path: Path) -> None:
    found = carry_out(begin_runs(_made(_by_seed), tmp_path), 12, progress=lambda _: None)
    assert isinstance(found, ExplainSummary)
    assert ExplainSummary.from_json(found.to_json()) == found
    page = markdown(found)
    assert page.startswith("explain: 12 runs, seeds 1 to 12, autodb ")
    for table in found.tables():
        assert f"**{table.title}**" in page
        assert all(len(row) == len(table.heads) for row in table.rows)


@pytest.mark.campaign  # one at every change: test_fixed_cases.py
def test_a_case_is_explained_and_scored() -> None:
    """A coulomb friction left out, clear as a machine's: named, and the current is corrected."""
    one = left_out.scored_case(draw_concealed(11, asked=PlannedCase(("coulomb",), 200.0)))
    assert one.refused == ""
    assert one.terms == ("coulomb",)
    assert "coulomb" in one.found
    assert one.recovery is not None
    assert one.recovery < 0.5


def test_a_case_that_cannot_be_as_clear_is_kept_without_an_answer() -> None:
    one = left_out.scored_case(draw_concealed(11, asked=PlannedCase(("gain",), 1e6, table=True)))
    assert not one.reached
    assert one.named == ()
    assert one.clarities[0] < 1e6


def test_a_refused_case_says_why(monkeypatch: pytest.MonkeyPatch) -> None:
    from autodb.errors import UnusableInput

    def refuse(*_: object, **__: object) -> None:
        raise UnusableInput("too short")

    monkeypatch.setattr(left_out, "explain", refuse)
    one = left_out.scored_case(draw_concealed(1))
    assert (one.refused, one.named, one.recovery) == ("too short", (), None)


@pytest.mark.parametrize(
    ("drawn_by", "digested"), [("plan", CONCEALED), ("mill.mill_plan", CONCEALED_MILLS)]
)
def test_the_generator_is_all_that_draws_a_case(
    drawn_by: str, digested: tuple[ModuleType, ...]
) -> None:
    """What a drawn case is made of, module by module, is what a table's digest is taken of."""
    package = "autodb.proofs.cases"
    used, ahead = {package}, [f"{package}.{drawn_by}"]
    while ahead:
        name = ahead.pop()
        used.add(name)
        tree = ast.parse((ROOT / f"{name.replace('.', '/')}.py").read_text(encoding="utf-8"))
        for node in ast.walk(tree):
            if isinstance(node, ast.ImportFrom) and str(node.module).startswith(package):
                ahead += {_module(str(node.module), alias.name) for alias in node.names} - used
    assert {module.__name__ for module in digested} == used


def _module(package: str, name: str) -> str:
    """Return the module that an import of a name is from."""
    inside = ROOT / f"{package.replace('.', '/')}/{name}.py"
    return f"{package}.{name}" if inside.exists() else package


def test_the_command_proves_explanations(cli: Cli, monkeypatch: pytest.MonkeyPatch) -> None:
    assert "explain" in cli("prove").out
    monkeypatch.setattr(catalogue, "PROOFS", (PROOFS[0], _made(_by_seed)))
    done = cli("prove", "explain", "--runs", 12, "--out", "here")
    assert done.code == 1
    assert "FAILED" in done.out
    assert (
        "12 of 12 runs are already there"
        in cli("prove", "explain", "--runs", 12, "--out", "here").out
    )
    written = json.loads(Path("here/explain.json").read_text("utf-8"))
    assert written["seeds"] == [1, 12]
    assert written["confusion"]["spring"] == {"lag": 2, "spring": 6}


def test_the_command_refuses_what_changes_nothing(refused: Callable[..., str]) -> None:
    assert "go with the name of a proof" in refused("prove", "--workers", 2)
    assert "did you mean explain" in refused("prove", "explian")
    assert "is a file" in refused("prove", "explain", "--runs", 1, "--out", __file__)


def test_one_worker_is_no_choice(cli: Cli) -> None:
    done = cli("prove", "explain", "--workers", 1)
    assert done.code == 2
    assert "'--workers'" in done.err
