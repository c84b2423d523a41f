"""A recording of the database, read again as it came in, and with the signs of its machine."""

from dataclasses import replace

from autodb.agent.ingest.importing import whole_file
from autodb.errors import UnusableInput
from autodb.files.side import SideFile
from autodb.records.source import open_as_stored
from autodb.records.tables import CutTable, Recording
from autodb.store import models
from autodb.wording import phrase


def as_imported(row: models.StoredRecording) -> Recording | CutTable:
    """Read a recording with the side file that it came in with.

    Raises UnusableInput where no file of it is there as it was imported.
    """
    path = whole_file(row)
    if path is None:
        raise UnusableInput(
            phrase(
                "{file}: the file is missing or has changed since its import; put it back "
                "under its path",
                file=row.path,
            )
        )
    return open_as_stored(path, SideFile.model_validate(row.side)).choose().read()


def signed(recording: Recording, machine: models.Machine) -> Recording:
    """Return a recording whose axis currents have the sign that the machine's axes state."""
    signs = {f"{axis.name}.current": axis.current_sign for axis in machine.axes}
    channels = {
        name: values * signs[name] if signs.get(name, 1) != 1 else values
        for name, values in recording.channels.items()
    }
    return replace(recording, channels=channels)
