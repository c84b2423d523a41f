"""Machines in the database, and a machine as answers about it need it: read by one query."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from sqlalchemy import Select, bindparam, func, select
from sqlalchemy.orm import Session
from sqlalchemy.orm.attributes import flag_modified

from autodb.errors import NotThere, UnusableInput, near_words
from autodb.files.machine import (
    SPINDLE,
    AxisFile,
    AxisLimits,
    Gear,
    MachineFile,
    SpindleFile,
    flat,
    lasting_part,
)
from autodb.files.toml import ReferenceValue
from autodb.store import Store, models
from autodb.wording import day, listed, msgid, phrase

_MACHINE = ("dialect", "units", "diameter", "shares")
_RETENTION = ("compress_after_days", "drop_after_days")
_AXIS = (
    *("carries", "current_sign", "carried_by", "moved_mass_kg", "vertical", "brake"),
    *("counterweight", "counterweight_force_N", "rated_A", "screw_pitch_mm", "gear_ratio"),
)
_LIMITS = {
    "force_N": "limit_force_N",
    "torque_N_m": "limit_torque_N_m",
    "power_W": "limit_power_W",
    "torque_curve": "limit_torque_curve",
    "power_curve": "limit_power_curve",
    "efficiency": "limit_efficiency",
    "speed_mm_min": "limit_speed_mm_min",
    "speed_rpm": "limit_speed_rpm",
    "travel_low_mm": "travel_low_mm",
    "travel_high_mm": "travel_high_mm",
}
_CONSTANT = {
    "value": "torque_constant_N_m_A",
    **{key: f"torque_constant_{key}" for key in ("lower", "upper", "source", "status", "date")},
}
_GEAR = ("name", "low_rpm", "high_rpm", "base_speed_rpm")
NOT_STATED = msgid("not stated")


def add_machine(store: Store, name: str, file: MachineFile) -> bool:
    """Add a machine; False when it is there already and its file says the same.

    Raises UnusableInput when it is there and the file says something else.
    """
    if not name.strip():
        raise UnusableInput(phrase("a machine needs a name; use one such as 'lathe-1'"))
    if not name.isprintable() or name != name.strip():
        raise UnusableInput(
            phrase(
                "machine '{name}': has line breaks, control characters, or blanks at its ends; "
                "use a name without them",
                name=name,
            )
        )
    if name.lower().endswith(".toml"):
        raise UnusableInput(
            phrase(
                "machine '{name}': that is a machine file; add what it describes with 'autodb "
                "machine add {stem} --file {name}'",
                name=name,
                stem=Path(name).stem,
            )
        )
    with store.writing() as session:
        existing = session.scalar(select(models.Machine).where(models.Machine.name == name))
        if existing is not None:
            changes = _changes(as_file(existing), file)
            if changes:
                raise UnusableInput(
                    phrase(
                        "machine '{name}' is there already and differs ({names}); change it with "
                        "'autodb machine update {name} --file FILE'",
                        name=name,
                        names=listed(changes[:3], "; "),
                    )
                )
            return False
        machine = models.Machine(name=name)
        _write(machine, file)
        session.add(machine)
    return True


def update_machine(store: Store, name: str, file: MachineFile) -> list[str]:
    """Make a machine what a file says; return what changed, one line each.

    Raises UnusableInput when an axis would go that something was learnt on, or the sign of a
    current would change under recordings that were imported with it.
    """
    with store.writing(name) as session:
        machine = find_machine(session, name)
        before = as_file(machine)
        changes = _changes(before, file)
        if not changes:
            return []
        _refuse_what_would_break(session, machine, before, file)
        _write(machine, file)
        flag_modified(machine, "name")  # the machine's version counts changes of its axes too
    return changes


def _changes(before: MachineFile, after: MachineFile) -> list[str]:
    old, new = flat(before), flat(lasting_part(after))
    return [
        phrase(
            "{key}: {was} → {now}",
            key=key,
            was=old.get(key, phrase(NOT_STATED)),
            now=new.get(key, phrase(NOT_STATED)),
        )
        for key in dict.fromkeys([*old, *new])
        if old.get(key) != new.get(key)
    ]


def _refuse_what_would_break(
    session: Session, machine: models.Machine, before: MachineFile, after: MachineFile
) -> None:
    for axis in before.axes:
        learnt = _learnt_on(session, machine.id, axis)
        if axis not in after.axes and learnt:
            raise UnusableInput(
                phrase(
                    "machine '{machine}': axis '{axis}' has {learnt} and cannot be removed; use a "
                    "file with [axes.{axis}]",
                    machine=machine.name,
                    axis=axis,
                    learnt=learnt,
                )
            )
    recorded = session.scalar(
        select(func.count(models.StoredRecording.id)).where(
            models.StoredRecording.machine_id == machine.id
        )
    )
    for axis, said in after.axes.items():
        was = before.axes.get(axis, said)
        if recorded and said.current_sign != was.current_sign:
            raise UnusableInput(
                phrase(
                    "machine '{machine}': axes.{axis}.current_sign cannot change after an import "
                    "({recorded} recordings took {current_sign}); add a machine of another name",
                    machine=machine.name,
                    axis=axis,
                    recorded=recorded,
                    current_sign=was.current_sign,
                )
            )


def _learnt_on(session: Session, machine_id: int, axis: str) -> str:
    """Return how many calibrations and models an axis has, in words; empty for none."""
    found = list[str]()
    for table, what in (
        (models.CalibrationVersion, msgid("calibrations ({count})")),
        (models.ChannelModel, msgid("models ({count})")),
        (models.DriveScale, msgid("scales ({count})")),
    ):
        n = session.scalar(
            select(func.count(table.id)).where(table.machine_id == machine_id, table.axis == axis)
        )
        if n:
            found.append(phrase(what, count=n))
    return listed(found, phrase(" and "))


def _write(machine: models.Machine, file: MachineFile) -> None:
    """Set every column of a machine, its axes and gears from a file."""
    for name in _MACHINE:
        setattr(machine, name, getattr(file, name))
    stated = file.dynamometer
    machine.dynamometer = None if stated is None else stated.model_dump(exclude_none=True)
    machine.rotary_order = None if file.rotary_order is None else list(file.rotary_order)
    for name in _RETENTION:
        setattr(machine, name, getattr(file.retention, name))
    machine.base_speed_rpm = file.spindle.base_speed_rpm
    machine.max_speed_rpm = file.spindle.max_speed_rpm
    have = {axis.name: axis for axis in machine.axes}
    rows = [have.get(name) or models.Axis(name=name) for name in file.axes]
    for row, axis in zip(rows, file.axes.values(), strict=True):
        for column, value in _axis_columns(axis).items():
            setattr(row, column, value)
    machine.axes = rows
    gears = {gear.name: gear for gear in machine.gears}
    machine.gears = [gears.get(gear.name) or models.GearRange() for gear in file.spindle.gear]
    for gear_row, gear in zip(machine.gears, file.spindle.gear, strict=True):
        for name in _GEAR:
            setattr(gear_row, name, getattr(gear, name))


def _axis_columns(axis: AxisFile) -> dict[str, Any]:
    constant = axis.torque_constant_N_m_A
    return {
        **{name: getattr(axis, name) for name in _AXIS},
        **{column: getattr(axis.limits, key) for key, column in _LIMITS.items()},
        **{
            column: None if constant is None else getattr(constant, key)
            for key, column in _CONSTANT.items()
        },
    }


def as_file(machine: models.Machine) -> MachineFile:
    """Return what is stored of a machine as its file would say it."""
    return MachineFile.model_validate(
        {
            **{name: getattr(machine, name) for name in _MACHINE},
            "rotary_order": machine.rotary_order,
            "dynamometer": machine.dynamometer,
            "retention": {name: getattr(machine, name) for name in _RETENTION},
            "spindle": SpindleFile(
                base_speed_rpm=machine.base_speed_rpm,
                max_speed_rpm=machine.max_speed_rpm,
                gear=tuple(
                    Gear(**{name: getattr(gear, name) for name in _GEAR}) for gear in machine.gears
                ),
            ),
            "axes": {axis.name: _as_axis_file(axis) for axis in machine.axes},
        }
    )


def limits_of(machine: models.Machine) -> dict[str, AxisLimits]:
    """Return what the axes of a machine may carry and where they may go, by name."""
    stated = {axis.name: _limits(axis) for axis in machine.axes}
    return _with_fastest(stated, machine.max_speed_rpm)


def _with_fastest(
    limits: dict[str, AxisLimits], max_speed_rpm: float | None
) -> dict[str, AxisLimits]:
    """Return limits of axes with the fastest speed of the spindle that a machine states."""
    own = limits.get(SPINDLE, AxisLimits())
    known = [rpm for rpm in (own.speed_rpm, max_speed_rpm) if rpm is not None]
    if not known:
        return limits
    return {**limits, SPINDLE: own.model_copy(update={"speed_rpm": min(known)})}


def limits_of_machine(store: Store, name: str) -> dict[str, AxisLimits]:
    """Return the limits of a machine by its name; raises UnusableInput where there is none."""
    with store.reading() as session:
        return limits_of(find_machine(session, name))


def _limits(axis: models.Axis) -> AxisLimits:
    return AxisLimits(**{key: getattr(axis, column) for key, column in _LIMITS.items()})


def _as_axis_file(axis: models.Axis) -> AxisFile:
    constant = None
    if axis.torque_constant_N_m_A is not None:
        constant = ReferenceValue(
            **{key: getattr(axis, column) for key, column in _CONSTANT.items()}
        )
    own = {name: getattr(axis, name) for name in _AXIS}
    return AxisFile(**own, limits=_limits(axis), torque_constant_N_m_A=constant)


def rename_machine(store: Store, name: str, new: str) -> None:
    """Give a machine another name; raises UnusableInput where one has it."""
    with store.writing(name) as session:
        machine = find_machine(session, name)
        if session.scalar(select(models.Machine.id).where(models.Machine.name == new)) is not None:
            raise UnusableInput(
                phrase("there is a machine '{new}' already; use another name", new=new)
            )
        machine.name = new


def retire_machine(store: Store, name: str, *, back: bool = False) -> bool:
    """Have nothing more come in of a machine, or again; False where it is so already."""
    with store.writing(name) as session:
        machine = find_machine(session, name)
        if (machine.retired_at is None) == back:
            return False
        machine.retired_at = None if back else models.now()
        return True


def working_machine(session: Session, name: str) -> models.Machine:
    """Return a machine that something may come in of; raises UnusableInput of a retired one."""
    machine = find_machine(session, name)
    if machine.retired_at is not None:
        raise UnusableInput(
            phrase(
                "machine '{name}' is retired since {retired_at}; run 'autodb machine retire "
                "{name} --undo'",
                name=name,
                retired_at=day(machine.retired_at),
            )
        )
    return machine


def machines_at_work(session: Session) -> list[str]:
    """Return the names of the machines that are not retired."""
    machine = models.table_of(models.Machine).c
    at_work = select(machine.name).where(machine.retired_at.is_(None)).order_by(machine.name)
    return list(session.connection().scalars(at_work))


def the_machine(session: Session, name: str | None) -> str:
    """Return the name of a machine that is there; None means the only one.

    Raises UnusableInput where there is none of that name, or not just one.
    """
    if name is not None:
        return find_machine(session, name).name
    names = machines_at_work(session)
    if not names:
        raise NotThere(phrase("no machine yet; add one with 'autodb machine add NAME'"))
    if len(names) > 1:
        raise UnusableInput(
            phrase("there are several machines: name one of {names}", names=", ".join(names))
        )
    return names[0]


def find_machine(session: Session, name: str) -> models.Machine:
    """Return the machine called ``name``; raises UnusableInput naming near ones."""
    machine = session.scalar(select(models.Machine).where(models.Machine.name == name))
    if machine is None:
        names = list(session.scalars(select(models.Machine.name)))
        hint = (
            near_words(name, names)
            if names
            else phrase("; add it with 'autodb machine add {name}'", name=name)
        )
        raise NotThere(phrase("no machine '{name}'{hint}", name=name, hint=hint))
    return machine


@dataclass(frozen=True)
class Owner:
    """A machine: its row's number, its name, and what its axes may carry, by their names."""

    id: int
    name: str
    limits: Mapping[str, AxisLimits]


def owner_of(machine: models.Machine) -> Owner:
    """Return a machine that was read already."""
    return Owner(machine.id, machine.name, limits_of(machine))


def owner_named(session: Session, name: str) -> Owner:
    """Read the machine called ``name``; raises NotThere naming near ones."""
    rows = session.connection().execute(_NAMED, {"name": name}).all()
    if not rows:
        return owner_of(find_machine(session, name))
    limits = {axis: _limits_in(own) for _, _, axis, *own in rows if axis}
    return Owner(rows[0].id, name, _with_fastest(limits, rows[0].max_speed_rpm))


def _limits_in(columns: list[Any]) -> AxisLimits:
    return AxisLimits(**dict(zip(_LIMITS, columns, strict=True)))


def _named() -> Select[Any]:
    machine, axis = models.table_of(models.Machine), models.table_of(models.Axis)
    columns = (axis.c[column] for column in _LIMITS.values())
    return (
        select(machine.c.id, machine.c.max_speed_rpm, axis.c.name, *columns)
        .select_from(machine)
        .outerjoin(axis, axis.c.machine_id == machine.c.id)
        .where(machine.c.name == bindparam("name"))
        .order_by(axis.c.id)
    )


_NAMED = _named()
