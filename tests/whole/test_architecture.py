"""The page on the architecture names the rooms that there are, files that exist, true ways."""

import re
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import grimp
import pytest

from docs.make import house, style
from tests.conftest import ROOT

PAGE = (ROOT / "docs" / "architecture.md").read_text("utf-8")
METHOD = sorted((ROOT / "docs" / "method").glob("*.md"))
ROOMS = {
    f"{path.parent.relative_to(ROOT).as_posix()}/" for path in ROOT.glob("autodb/**/__init__.py")
}
WAYS = {
    "From a job to its forces": 12,
    "From a cut's current to a parameter": 18,
    "From a recording to an explanation": 17,
}
"""Sections that follow an answer through modules, and how many steps each may have at most."""
IN_CODE = re.compile(
    r"`((?:autodb|tests|docs|schema|calibration|sample_jobs|benchmarks)/[\w./-]*)`"
)
NAMED = re.compile(r"`((?:autodb\.)?(?:explain|signals|sensing|pairs|cutting)(?:\.\w+)+)`")


def test_every_room_is_on_the_page_and_no_other() -> None:
    tree = PAGE.split("## The tree")[1].split("\n## ")[0]
    named = re.findall(r"`(autodb/(?:\w+/)*)`", tree)
    assert len(named) == len(set(named))
    assert set(named) == ROOMS


@pytest.mark.parametrize("page", ["docs/architecture.md", "CONTRIBUTING.md"])
def test_paths_on_the_page_exist(page: str) -> None:
    named = IN_CODE.findall((ROOT / page).read_text("utf-8"))
    assert len(named) >= 3
    assert [path for path in named if not (ROOT / path).exists()] == []


@pytest.mark.parametrize("way", WAYS)
def test_each_module_of_a_way_is_imported_by_one_before_it(way: str) -> None:
    steps = PAGE.split(f"## {way}")[1].split("\n## ")[0]
    modules = [_module(path) for path in re.findall(r"`(autodb/[\w/]+\.py)`", steps)]
    assert len(set(modules)) == len(modules)
    reached: set[str] = set()
    for module in modules:
        if not module.startswith("autodb.cli."):
            assert module in reached, module
        reached |= set(_imported(module))


def test_no_way_is_long() -> None:
    for way, most in WAYS.items():
        steps = PAGE.split(f"## {way}")[1].split("\n## ")[0]
        assert 5 <= len(re.findall(r"^\d+\. ", steps, re.MULTILINE)) <= most, way


def _module(path: str) -> str:
    return path.removesuffix(".py").replace("/", ".").removesuffix(".__init__")


@cache
def _graph() -> grimp.ImportGraph:
    return grimp.build_graph("autodb", exclude_type_checking_imports=True)


def _imported(module: str) -> Iterator[str]:
    """Yield what a module imports, and of a room that it imports from what that passes on."""
    for name in _graph().find_modules_directly_imported_by(module):
        yield name
        if (ROOT / name.replace(".", "/")).is_dir():
            yield from _graph().find_modules_directly_imported_by(name)


@pytest.mark.parametrize("page", METHOD, ids=lambda page: page.stem)
def test_names_of_the_code_on_the_pages_of_the_method_are_there(page: Path) -> None:
    for name in NAMED.findall(page.read_text("utf-8")):
        assert _is_there(name if name.startswith("autodb.") else f"autodb.{name}"), name


def _is_there(name: str) -> bool:
    """Say whether a dotted name is a module, a room, or something defined in one of these."""
    path = ROOT / name.replace(".", "/")
    if path.is_dir() or path.with_suffix(".py").exists():
        return True
    inside, _, last = name.rpartition(".")
    path = ROOT / inside.replace(".", "/")
    found = path / "__init__.py" if path.is_dir() else path.with_suffix(".py")
    defined = rf"\b(?:def|class|import) .*\b{last}\b|^{last}\b|^    {last},|\"{last}\""
    return found.exists() and bool(re.search(defined, found.read_text("utf-8"), re.MULTILINE))


def test_every_page_of_the_service_is_served() -> None:
    room = ROOT / "autodb" / "web" / "pages"
    routed = {path.stem for path in room.glob("*.py") if "router = APIRouter" in path.read_text()}
    listed = re.search(r"^PAGES = \((.*?)\)", (room / "__init__.py").read_text(), re.M | re.S)
    assert listed is not None
    assert set(re.findall(r"\w+", listed[1])) == routed


def test_the_figure_is_that_of_the_contracts(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    rooms = [room for floor in house.floors() for room in floor]
    assert sorted(rooms) == sorted(house.WORDS)
    assert {f"autodb/{room}/" for room in rooms} >= {r for r in ROOMS if r.count("/") == 2}
    monkeypatch.setattr(style, "FIGURES", tmp_path)
    house.draw()
    drawn = (tmp_path / "rooms.svg").read_bytes()
    assert drawn == (ROOT / "docs" / "figures" / "rooms.svg").read_bytes()


def test_contributing_names_targets_of_the_makefile() -> None:
    targets = set(re.findall(r"^(\w[\w-]*):", (ROOT / "Makefile").read_text(), re.MULTILINE))
    named = set(re.findall(r"\bmake ([\w-]+)", (ROOT / "CONTRIBUTING.md").read_text("utf-8")))
    assert named <= targets
