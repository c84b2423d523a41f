"""Recordings that were answered with 202: on the disk until it is decided what becomes of them.

One file of JSON each, below ``accepted``, and beside it a lock that the service holds which has it
at work. A service that begins takes up those that nobody holds: what a stopped or killed one left.
"""

from dataclasses import dataclass
from pathlib import Path

from filelock import FileLock, Timeout
from pydantic import ValidationError

from autodb.agent.operate.access import Access
from autodb.files.targets import sync, write_text
from autodb.web.http.logs import LOG
from autodb.web.http.responses import adapter

ACCEPTED = "accepted"


@dataclass(frozen=True)
class Accepted:
    """The number of an import, its machine, where its file lies below the folder, and who sent."""

    number: int
    machine: str
    file: str
    by: Access


class Claim:
    """The right to decide about one that was accepted; nobody else has it meanwhile."""

    def __init__(self, note: Path) -> None:
        self._note = note
        self._lock = FileLock(note.with_suffix(".lock"), timeout=0, thread_local=False)

    def taken(self) -> bool:
        """Return whether it could be had, and there is something to decide."""
        try:
            self._lock.acquire()
        except Timeout:
            return False
        if self._note.exists():
            return True
        self.finish()
        return False

    def keep(self, one: Accepted) -> None:
        """Have it on the disk from now on, whatever ends."""
        self._note.parent.mkdir(exist_ok=True)
        self._lock.acquire()
        try:
            write_text(self._note, adapter(Accepted).dump_json(one).decode())
            sync(self._note.parent.parent)
        except BaseException:
            self.finish()
            raise

    def let_go(self) -> None:
        """Leave it to the service that begins next."""
        self._lock.release()

    def finish(self) -> None:
        """Take it away: it is decided."""
        self._note.unlink(missing_ok=True)
        Path(self._lock.lock_file).unlink(missing_ok=True)
        self._lock.release()


def accept(folder: Path, made: Path, one: Accepted) -> Claim:
    """Write what lies at a place to the disk, and that it was accepted; return the claim to it."""
    for path in (*made.iterdir(), made):
        sync(path)
    for above in made.relative_to(folder).parents:
        sync(folder / above)
    claim = Claim(_note(folder, made))
    claim.keep(one)
    return claim


def left(folder: Path) -> list[tuple[Accepted, Claim]]:
    """Return what was accepted that no service has at work, in its order."""
    found = []
    for note in sorted((folder / ACCEPTED).glob("*.json")):
        claim = Claim(note)
        if not claim.taken():
            continue
        one = _read(folder, note)
        if one is None:  # a person has to look at it; the others go on
            LOG.error("%s: says nothing that was accepted", note)
            claim.let_go()
        else:
            found.append((one, claim))
    return sorted(found, key=lambda one: one[0].number)


def _read(folder: Path, note: Path) -> Accepted | None:
    """Return what a note says; None where that cannot be read, or lies elsewhere."""
    try:
        one: Accepted = adapter(Accepted).validate_json(note.read_bytes())
    except ValidationError:
        return None
    made = (folder / one.file).parent
    ours = made.name == note.stem and made.resolve().is_relative_to(folder.resolve())
    return one if ours else None


def is_accepted(folder: Path, made: Path) -> bool:
    """Return whether what lies at a place was accepted, and is not decided."""
    return _note(folder, made).exists()


def _note(folder: Path, made: Path) -> Path:
    return folder / ACCEPTED / f"{made.name}.json"
