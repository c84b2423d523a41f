"""`lookup`: one cut of a pair, or the pairs that a machine has; nothing is stored."""

import re
from functools import partial
from typing import TYPE_CHECKING, Annotated, Any

import typer

from autodb.cli._common import Database, Json, MachineName, opened_machine, say, show, table
from autodb.cli._reader import headed, in_english
from autodb.cli.everyday.predicting import (
    ToolPath,
    say_answer,
    show_figures,
    show_predicted,
    stated_tool,
)
from autodb.wording import day, phrase

if TYPE_CHECKING:
    from autodb.agent.answer.looking_up import Listed
    from autodb.agent.answer.prediction_basis import LookedUp, PredictionBasis
    from autodb.files.job_cut import JobCut

OPTIONS = {
    "operation": "--operation", "diameter_mm": "--diameter", "end_diameter_mm": "--end-diameter",
    "length_mm": "--length", "depth_mm": "--depth", "width_mm": "--width", "feed_mm_rev": "--feed",
    "feed_mm_tooth": "--feed", "direction_deg": "--direction", "ramp_deg": "--ramp",
    "pocket_diameter_mm": "--pocket-diameter", "speed_m_min": "--speed", "speed_rpm": "--rpm",
    "cutting_time_s": "--cutting-time", "flank_wear_mm": "--flank-wear",
}  # fmt: skip
"""Option of each key of a job's cut."""


def _number(option: str, metavar: str, what: str) -> Any:
    """Return an option whose number may have a decimal comma."""
    from autodb.files.units import typed_number

    return typer.Option(option, metavar=metavar, help=what, parser=partial(typed_number, option))


Material = Annotated[str | None, typer.Option("--material", help="Work material.")]
ToolName = Annotated[str | None, typer.Option("--tool", help="Name of the tool.")]
Lot = Annotated[
    str | None, typer.Option("--lot", metavar="NAME", help="Lot of the material: a bar, a heat.")
]
Operation = Annotated[
    str | None,
    typer.Option(
        "--operation",
        help="What the cut is: turn, face, taper, contour, bore, groove, thread, slot, side-up, "
        "side-down, ramp, pocket or drill; turn where none is given.",
    ),
]
Diameter = Annotated[
    float | None, _number("--diameter", "MM", "Machined diameter at the tool tip, of turning.")
]
Depth = Annotated[float | None, _number("--depth", "MM", "Depth of cut.")]
Width = Annotated[
    float | None,
    _number("--width", "MM", "Width of cut: of side milling, pockets, grooves; a thread's height."),
]
Feed = Annotated[float | None, _number("--feed", "MM", "Feed a revolution; of milling, a tooth.")]
Speed = Annotated[float | None, _number("--speed", "M/MIN", "Cutting speed.")]
Rpm = Annotated[float | None, _number("--rpm", "RPM", "Spindle speed instead.")]
EndDiameter = Annotated[
    float | None, _number("--end-diameter", "MM", "Diameter at the end of the cut.")
]
Length = Annotated[
    float | None, _number("--length", "MM", "How far a taper or contour goes along the axis.")
]
Direction = Annotated[
    float | None,
    _number("--direction", "DEG", "Feed of a mill from +x towards +y; of turning, inwards."),
]
Ramp = Annotated[float | None, _number("--ramp", "DEG", "Angle of a ramp.")]
PocketDiameter = Annotated[
    float | None, _number("--pocket-diameter", "MM", "Diameter of a round pocket.")
]
CuttingTime = Annotated[
    float | None, _number("--cutting-time", "S", "Time on the edge before the cut.")
]
FlankWear = Annotated[float | None, _number("--flank-wear", "MM", "Flank wear of the edge.")]

Wanted = Annotated[
    str | None,
    typer.Option(
        "--largest",
        metavar="WHAT",
        help="Look for the largest feed, depth or speed that keeps the machine's limits.",
    ),
]
Share = Annotated[
    float | None,
    typer.Option(
        "--share", metavar="PERCENT", min=1.0, max=100.0,
        help="Of each force, torque and power limit, with --largest; 100 where none is given.",
    ),
]  # fmt: skip
Sure = Annotated[
    float | None,
    typer.Option(
        "--sure", metavar="PERCENT", min=50.0, max=99.9,
        help="How surely limits are kept, with --largest; 95 where none is given.",
    ),
]  # fmt: skip


def lookup(
    machine: MachineName = None,
    material: Material = None,
    tool: ToolName = None,
    tool_file: ToolPath = None,
    lot: Lot = None,
    operation: Operation = None,
    diameter: Diameter = None,
    depth: Depth = None,
    width: Width = None,
    feed: Feed = None,
    speed: Speed = None,
    rpm: Rpm = None,
    end_diameter: EndDiameter = None,
    length: Length = None,
    direction: Direction = None,
    ramp: Ramp = None,
    pocket_diameter: PocketDiameter = None,
    cutting_time: CuttingTime = None,
    flank_wear: FlankWear = None,
    largest: Wanted = None,
    share: Share = None,
    sure: Sure = None,
    json: Json = False,
    db: Database = None,
) -> None:
    """Predict one cut of a work-tool pair; without a cut, list the machine's pairs."""
    from autodb.agent.answer.looking_up import PairReader
    from autodb.errors import UnusableInput

    given = {
        "--operation": operation, "--diameter": diameter, "--depth": depth, "--width": width,
        "--feed": feed, "--speed": speed, "--rpm": rpm, "--end-diameter": end_diameter,
        "--length": length, "--direction": direction, "--ramp": ramp,
        "--pocket-diameter": pocket_diameter, "--cutting-time": cutting_time,
        "--flank-wear": flank_wear,
    }  # fmt: skip
    if largest is None and (share is not None or sure is not None):
        raise UnusableInput(
            phrase("--share and --sure go with --largest; add it, or leave them out")
        )
    cut, geometry = _cut_asked(given, largest), dict[str, float]()
    if tool_file is not None:
        tool, geometry = stated_tool(tool_file, tool, [] if cut is None else [cut.operation])
    if cut is not None and (material is None or tool is None):
        raise UnusableInput(phrase("a cut needs --material and --tool"))
    if cut is None and lot is not None:
        raise UnusableInput(phrase("--lot goes with a cut; state one, or leave --lot out"))
    with (
        in_english(json),
        opened_machine(db, machine) as (store, name),
        store.reading() as session,
    ):
        pair_reader = PairReader(session, name)
        if cut is None:
            _list(name, pair_reader.pairs(material, tool), json=json)
            return
        basis = pair_reader.basis(str(material), str(tool)).of_lot(lot).with_tool(geometry)
        shares = (share or 100.0) / 100.0, (sure or 95.0) / 100.0
        _say_of_cut(basis, cut, largest, shares, json=json)


def _cut_asked(given: dict[str, Any], largest: str | None) -> "JobCut | None":
    """Return the cut that options state, None: they state none; raises UnusableInput."""
    stated = {option: value for option, value in given.items() if value is not None}
    if largest is not None:
        stated = _completed(stated, largest)
    return _cut(stated) if stated else None


def _say_of_cut(
    basis: "PredictionBasis",
    cut: "JobCut",
    largest: str | None,
    shares: tuple[float, float],
    *,
    json: bool,
) -> None:
    """Print the prediction of a cut, or the largest of what is asked for."""
    if largest is None:
        _answer(basis.look_up(cut), json=json)
    else:
        _show_largest(basis, cut, largest, shares, json=json)


def _cut(stated: dict[str, Any]) -> "JobCut":
    """Return a job's cut of what options state; raises UnusableInput naming options."""
    from pydantic import ValidationError

    from autodb.errors import UnusableInput, near_words
    from autodb.files.job_cut import KEYS, OPERATIONS, JobCut

    operation = stated.get("--operation", "turn")
    if operation not in OPERATIONS:
        raise UnusableInput(
            phrase(
                "--operation '{operation}': there is none{hint}",
                operation=operation,
                hint=near_words(operation, OPERATIONS),
            )
        )
    needs = KEYS[operation].needs
    other_feed = "feed_mm_rev" if "feed_mm_tooth" in needs else "feed_mm_tooth"
    keys = {option: key for key, option in OPTIONS.items() if key != other_feed}
    try:
        return JobCut.model_validate({keys[option]: value for option, value in stated.items()})
    except ValidationError as error:
        from autodb.wording.mistakes import mistake_words

        first = error.errors()[0]
        where = "".join(f"{OPTIONS[str(part)]}: " for part in first["loc"])
        message = mistake_words(first)
        said = re.sub(r"\w+", lambda word: OPTIONS.get(word[0], word[0]), message)
        said = said.replace("--operation '", "operation '")
        raise UnusableInput(f"{where}{said}") from None


def _completed(stated: dict[str, Any], largest: str) -> dict[str, Any]:
    """Return what options state, with any value of what is asked for; raises UnusableInput."""
    from autodb.errors import UnusableInput, near_words

    anything = {"feed": ("--feed", 0.1), "depth": ("--depth", 1.0), "speed": ("--speed", 100.0)}
    if largest not in anything:
        raise UnusableInput(
            phrase(
                "--largest '{largest}': is nothing to look for{hint}",
                largest=largest,
                hint=near_words(largest, anything),
            )
        )
    option, value = anything[largest]
    options = (option, "--rpm") if largest == "speed" else (option,)
    given = [one for one in options if one in stated]
    if given:
        raise UnusableInput(
            phrase(
                "--largest {largest} and {given} exclude each other; use one",
                largest=largest,
                given=given[0],
            )
        )
    return {**stated, option: value}


def _show_largest(
    basis: "PredictionBasis",
    cut: "JobCut",
    what: str,
    shares: tuple[float, float],
    *,
    json: bool,
) -> None:
    """Print the largest of what is asked for; ``shares``: of each limit, and how surely."""
    from autodb.agent.answer.bounds.largest import largest_value

    found = largest_value(basis, cut, what, share=shares[0], sure=shares[1])
    if json:
        from pydantic import TypeAdapter

        from autodb.agent.answer.bounds.largest import Largest

        say(TypeAdapter(Largest).dump_json(found, indent=1).decode())
        return
    _answer(found.answer, json=False)
    say(found.statement)


def _list(machine: str, pairs: "list[Listed]", *, json: bool) -> None:
    if json:
        from pydantic import TypeAdapter

        from autodb.agent.answer.looking_up import Listed

        say(TypeAdapter(list[Listed]).dump_json(pairs, indent=1).decode())
        return
    if not pairs:
        say(
            phrase(
                "machine '{machine}' has no fitted pair yet; run 'autodb refresh' to fit pairs to "
                "its cuts",
                machine=machine,
            )
        )
        return
    rows = table(
        phrase("Work-tool pairs of '{machine}'", machine=machine),
        *(phrase("material"), phrase("tool"), headed(phrase("cuts")), headed(phrase("version"))),
        phrase("learnt"),
    )
    for pair in pairs:
        rows.add_row(
            pair.material, pair.tool, f"{pair.cuts}", f"{pair.version}", day(pair.learnt_at[:10])
        )
    show(rows)


def _answer(answer: "LookedUp", *, json: bool) -> None:
    if json:
        from pydantic import TypeAdapter

        from autodb.agent.answer.prediction_basis import LookedUp

        say(TypeAdapter(LookedUp).dump_json(answer, indent=1).decode())
        return
    show_predicted(f"{answer.material} / {answer.tool}", [answer.cut])
    show_figures([answer.cut], [answer.figures])
    say_answer([answer.cut], answer)
