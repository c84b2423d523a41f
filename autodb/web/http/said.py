"""What the service says beside what the library says: shapes of its answers alone."""

from dataclasses import dataclass, field
from typing import Literal

from autodb.agent.answer.overview import MachineSeen, MismatchSaid
from autodb.agent.ingest.importing import Imported
from autodb.agent.operate.access import Noted
from autodb.agent.sense.sensors import Sensor
from autodb.forward.limits import Exceeding, LimitStanding
from autodb.forward.prediction import PredictedCut


@dataclass(frozen=True)
class Machines:
    """Machines by name; ``next``: the name to ask for more after, None where there are none."""

    machines: list[MachineSeen]
    next: str | None


@dataclass(frozen=True)
class Senses:
    """A machine's force sensors, and the forces that none of them senses."""

    sensors: list[Sensor]
    not_sensed: list[str]


@dataclass(frozen=True)
class Step:
    """One step of a trace: a sentence, and what it came from."""

    text: str
    sources: list["Step"] = field(default_factory=list)


@dataclass(frozen=True)
class Decision:
    """A mismatch as it stands after a decision; ``already``: it was decided so before.

    ``kept``: the versions, in words, that hold the confirmed term now; ``back``: what was taken
    back with a decision.
    """

    mismatch: MismatchSaid
    already: bool
    kept: tuple[str, ...]
    back: tuple[str, ...] = ()


@dataclass(frozen=True)
class AuditLine:
    """One entry of the audit log."""

    id: int
    entry: Noted


@dataclass(frozen=True)
class Importing:
    """How far the import of a recording is that was sent: what it is at, and what came of it.

    ``came_in``: what is in the database once it is done; ``refused``: the one line why it is not.
    """

    number: int
    machine: str
    file: str
    state: Literal["waiting", "reading", "done", "refused"] = "waiting"
    progress: str = ""
    came_in: Imported | None = None
    refused: str | None = None


@dataclass(frozen=True)
class BatchLine:
    """One line of a batch: the cut of that line of the request, or why there is none."""

    row: int
    cut: PredictedCut | None = None
    exceeds: tuple[Exceeding, ...] = ()
    limits: tuple[LimitStanding, ...] = ()
    problem: str | None = None


@dataclass(frozen=True)
class End:
    """The last line of a batch: how many were answered, and how many were not."""

    answered: int
    refused: int
