"""How a running agent is: one line to read, one file that another program looks at."""

import json
import time
from dataclasses import asdict, dataclass, field
from datetime import datetime
from pathlib import Path

from autodb.errors import UnusableInput, no_such_file
from autodb.files.targets import write_text

STALE_S = 60.0
"""From when on a health file that nobody writes any more says that the agent is gone."""


@dataclass
class Health:
    """What an agent is at. Instants are s since 1970.

    ``state``: "connected", or why it is not. ``values_per_s``: over the last health interval.
    ``late`` and ``lost``: values that came too late for their place, and that a server's queue
    lost; ``gaps``: times that something may be missing. ``refresh``: why the last one failed;
    empty: it did not.
    """

    machine: str
    at_s: float = field(default_factory=time.time)
    state: str = "starting"
    values_per_s: float = 0.0
    cutting_since_s: float | None = None
    cuts: int = 0
    last_cut: str | None = None
    gaps: int = 0
    late: int = 0
    lost: int = 0
    waiting: int = 0
    refreshed_at_s: float | None = None
    refresh: str = ""
    memory_MB: float = 0.0

    @property
    def well(self) -> bool:
        """Whether it reads the machine, and nothing keeps it from refreshing."""
        return self.state == "connected" and not self.refresh

    def line(self) -> str:
        """Return it as one line."""
        cutting = self.cutting_since_s is not None
        parts = [
            f"{_clock(self.at_s)} {self.machine}: {self.state}",
            f"{self.values_per_s:.0f} values/s",
            f"cutting since {_clock(self.cutting_since_s)}" if cutting else "not cutting",
            f"{self.cuts} cuts recorded, {self.waiting} wait in the inbox",
            f"last pass {_clock(self.refreshed_at_s)}",
            f"{self.memory_MB:.0f} MB",
        ]
        counts = (("gaps", self.gaps), ("values too late", self.late), ("lost", self.lost))
        parts += [f"{count} {what}" for what, count in counts if count]
        return "; ".join([*parts, f"refresh: {self.refresh}"] if self.refresh else parts)

    def write(self, path: Path) -> None:
        """Write it whole, in the place of the one before; raises OSError."""
        self.at_s, self.memory_MB = time.time(), memory_MB()
        write_text(path, json.dumps(asdict(self), indent=1) + "\n")


def read_health(path: Path) -> Health:
    """Read what an agent wrote last; raises UnusableInput where it wrote nothing."""
    try:
        return Health(**json.loads(path.read_text(encoding="utf-8")))
    except FileNotFoundError:
        raise no_such_file(path, "start the agent, which writes it") from None
    except (ValueError, TypeError) as error:
        raise UnusableInput(f"{path}: not what an agent writes ({error})") from None


def is_stale(health: Health) -> bool:
    """Say whether an agent has written nothing for a while."""
    return time.time() - health.at_s > STALE_S


def memory_MB() -> float:
    """Return the memory that this process holds now, MB; 0 where the system does not say."""
    try:
        pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[1])
    except (OSError, ValueError, IndexError):
        return 0.0
    return pages * 4096 / 1e6


def _clock(instant_s: float | None) -> str:
    if instant_s is None:
        return "none yet"
    return datetime.fromtimestamp(instant_s).astimezone().strftime("%H:%M:%S")
