"""The NC program of a protocol's cuts on a machine, as text; the same input gives the same text."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from autodb.errors import UnusableInput, near
from autodb.files.machine import MachineFile
from autodb.nc import milling, turning
from autodb.nc.dialects import DIALECTS
from autodb.nc.fits import Mounted, mounted, refuse_what_a_lathe_would_hit, refuse_what_does_not_fit
from autodb.nc.steps import CutPath, StraightMove, rapid
from autodb.nc.words import Words
from autodb.standard import CutProtocol, run_order


@dataclass(frozen=True)
class _Job:
    """All that a program is made from; ``retracted``: axes in the order in which they go back."""

    protocol: CutProtocol
    on: Mounted
    words: Words
    paths: tuple[CutPath, ...]
    retracted: tuple[str, ...]
    zero: str
    stock: str
    x_factor: float


def protocol_program(
    protocol: CutProtocol, machine: MachineFile, *, dialect: str, source: str
) -> str:
    """Return the NC program of a protocol.

    ``source`` names the machine's file in messages. Raises UnusableInput naming the dialects there
    are, the key that is missing, or the cut, axis and limit that do not fit.
    """
    if dialect not in DIALECTS:
        raise UnusableInput(f"no NC program for dialect '{dialect}'{near(dialect, DIALECTS)}")
    lathe, mill = DIALECTS[dialect]
    if protocol.bar is not None:
        job = _on_lathe(protocol, machine, lathe, source)
    elif protocol.block is not None:
        job = _on_mill(protocol, machine, mill, source)
    else:
        raise UnusableInput(f"protocol '{protocol.name}': [bar] or [block] is missing; state one")
    return "".join(f"{line}\n" for line in _text(job))


def _on_lathe(protocol: CutProtocol, machine: MachineFile, words: Words, source: str) -> _Job:
    bar = protocol.bar
    assert bar is not None
    if machine.diameter is None:
        raise UnusableInput(
            f"{source}: diameter is missing; state whether the control takes X as a diameter"
        )
    on = mounted(machine, axes=("x", "z"), retracted=("x", "z"), source=source)
    paths = tuple(
        turning.turning_paths(
            protocol, bar, run_order(protocol), clearance_mm=on.setup.clearance_mm
        )
    )  # fmt: skip
    refuse_what_does_not_fit(paths, on)
    refuse_what_a_lathe_would_hit(paths, on, bar_diameter_mm=bar.diameter_mm)
    counts = "diameters" if machine.diameter else "radii"
    free_mm = bar.length_mm + on.setup.clearance_mm
    return _Job(
        protocol=protocol,
        on=on,
        words=words,
        paths=paths,
        retracted=("x", "z"),
        zero=f"X on the spindle's axis, in {counts}, Z at the bar's face",
        stock=f"bar Ø{bar.diameter_mm:g}, at least {free_mm:g} mm out of the jaws",
        x_factor=2.0 if machine.diameter else 1.0,
    )


def _on_mill(protocol: CutProtocol, machine: MachineFile, words: Words, source: str) -> _Job:
    block = protocol.block
    assert block is not None
    on = mounted(machine, axes=("x", "y", "z"), retracted=("z",), source=source)
    paths = tuple(
        milling.milling_paths(
            protocol, block, run_order(protocol), clearance_mm=on.setup.clearance_mm
        )
    )  # fmt: skip
    refuse_what_does_not_fit(paths, on)
    return _Job(
        protocol=protocol,
        on=on,
        words=words,
        paths=paths,
        retracted=("z",),
        zero="the middle of the block's top",
        stock=f"block {block.size_x_mm:g} x {block.size_y_mm:g} x {block.height_mm:g}",
        x_factor=1.0,
    )


def _text(job: _Job) -> Iterator[str]:
    """Yield the lines: header, modes, retract, dry run, the cuts, end."""
    words = job.words
    yield from (line.format(name=_name(job.protocol)) for line in words.opening)
    yield from (words.said(line) for line in _header(job))
    yield from (line.format(limit_rpm=int(job.on.limit_rpm)) for line in words.modes)
    yield from _home(job)
    yield from words.x_in_diameters if job.x_factor > 1 else words.x_in_radii
    tool = {"tool": job.on.setup.tool, "retract_z": f"{job.on.retract_mm['z']:.3f}"}
    yield from (line.format(**tool) for line in words.begin)
    yield words.said("dry run in air: block skip on leaves it out")
    for path in {path.cut.name: path for path in reversed(job.paths)}.values():
        yield from (f"/{line}" for line in _cut(job, path, path.lifted(), "in air"))
    yield from _retract(job)
    yield from _stop(job, "end of the dry run: check what it showed")
    for number, path in enumerate(job.paths, 1):
        if path.new_stock:
            yield from _stop(job, f"clamp a new {job.stock}, and set program zero again")
        yield from _cut(job, path, path.moves, f"{number} of {len(job.paths)}")
        yield "M1"
    yield from words.closing


def _name(protocol: CutProtocol) -> str:
    """Return a protocol's name in the letters that every control takes."""
    plain = (c if c.isascii() and c.isalnum() else "_" for c in protocol.name.upper())
    return "".join(plain)[:24]


def _header(job: _Job) -> Iterator[str]:
    protocol, on = job.protocol, job.on
    stocks = 1 + sum(path.new_stock for path in job.paths)
    yield "not proven on your machine: check it, dry run it, keep a hand on feed hold"
    yield f"standard cuts {protocol.name}, seed {protocol.seed}: {len(job.paths)} cuts"
    yield f"work: {protocol.material}"
    yield f"tool: {protocol.tool}, place {on.setup.tool}"
    yield f"stock: {job.stock}; {stocks} needed"
    at = ", ".join(f"{axis} {mm:.3f}" for axis, mm in on.zero_mm.items())
    yield f"program zero: {job.zero}"
    yield f"there, with G54 and the tool's offset, the axes stand at {at}"
    yield f"speed limit {on.limit_rpm:g} rpm"
    yield from job.words.notes


def _home(job: _Job) -> Iterator[str]:
    """Yield the first motion: each axis back in machine coordinates, one after the other."""
    factor = 1.0 if job.words.home_in_radii else job.x_factor
    for axis in job.retracted:
        machine_mm = job.on.retract_mm[axis] + job.on.zero_mm[axis]
        scaled = machine_mm * (factor if axis == "x" else 1.0)
        yield job.words.home.format(axis=axis.upper(), value=f"{scaled:.3f}")


def _retract(job: _Job) -> Iterator[str]:
    for axis in job.retracted:
        yield job.words.moved(rapid(**{axis: job.on.retract_mm[axis]}), x_factor=job.x_factor)


def _cut(job: _Job, path: CutPath, moves: Sequence[StraightMove], which: str) -> Iterator[str]:
    cut = path.cut
    yield job.words.said(f"{cut.name}, {which}")
    yield job.words.spindle.format(rpm=int(cut.speed_rpm), turn=job.on.setup.spindle)
    yield from (job.words.moved(move, x_factor=job.x_factor) for move in moves)
    yield from _retract(job)


def _stop(job: _Job, why: str) -> Iterator[str]:
    yield "M5"
    yield job.words.said(why)
    yield "M0"
