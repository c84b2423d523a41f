"""Machines in the database."""

import tomllib
from dataclasses import replace
from pathlib import Path
from typing import Literal

from pydantic import BaseModel, ConfigDict, ValidationError
from sqlalchemy import select
from sqlalchemy.orm import Session

from autodb.errors import UnusableInput, near
from autodb.records import Recording
from autodb.store import Store, models


class AxisFile(BaseModel):
    """One axis of a machine file."""

    model_config = ConfigDict(extra="forbid")
    carries: Literal["tool", "work"] = "tool"
    current_sign: Literal[-1, 1] = 1


class MachineFile(BaseModel):
    """A machine file (TOML): the driven axes by name."""

    model_config = ConfigDict(extra="forbid")
    axes: dict[str, AxisFile]


LATHE = MachineFile(
    axes={"x": AxisFile(), "z": AxisFile(), "spindle": AxisFile(carries="work")},
)
"""What `machine add NAME` takes without a file: a two-axis lathe."""


def read_machine_file(path: Path) -> MachineFile:
    """Read a machine file; raises UnusableInput with file and key."""
    try:
        return MachineFile.model_validate(tomllib.loads(path.read_text(encoding="utf-8")))
    except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
        raise UnusableInput(f"{path}: not a readable TOML file ({error})") from None
    except ValidationError as error:
        first = error.errors()[0]
        where = ".".join(str(part) for part in first["loc"])
        raise UnusableInput(f"{path}: {where}: {first['msg']}") from None


def add_machine(store: Store, name: str, file: MachineFile) -> bool:
    """Add a machine with its axes; False when it is there already with the same axes.

    Raises UnusableInput when it is there with other axes.
    """
    if not name.strip():
        raise UnusableInput("a machine needs a name; 'lathe-1' would work")
    if not file.axes:
        raise UnusableInput("a machine needs axes; '[axes.z]' in its file would work")
    wanted = {axis: (a.carries, a.current_sign) for axis, a in file.axes.items()}
    with store.writing() as session:
        existing = session.scalar(select(models.Machine).where(models.Machine.name == name))
        if existing is not None:
            have = {axis.name: (axis.carries, axis.current_sign) for axis in existing.axes}
            if have != wanted:
                raise UnusableInput(f"machine '{name}' is there already with other axes: {have}")
            return False
        machine = models.Machine(name=name)
        for axis, (carries, sign) in wanted.items():
            machine.axes.append(models.Axis(name=axis, carries=carries, current_sign=sign))
        session.add(machine)
    return True


def signed(recording: Recording, machine: models.Machine) -> Recording:
    """Return a recording whose axis currents have the sign that the machine's axes state."""
    signs = {f"{axis.name}.current": axis.current_sign for axis in machine.axes}
    channels = {
        name: values * signs[name] if signs.get(name, 1) != 1 else values
        for name, values in recording.channels.items()
    }
    return replace(recording, channels=channels)


def find_machine(session: Session, name: str) -> models.Machine:
    """Return the machine called ``name``; raises UnusableInput naming near ones."""
    machine = session.scalar(select(models.Machine).where(models.Machine.name == name))
    if machine is None:
        names = list(session.scalars(select(models.Machine.name)))
        hint = near(name, names) if names else f": 'autodb machine add {name}' makes it"
        raise UnusableInput(f"no machine '{name}'{hint}")
    return machine
