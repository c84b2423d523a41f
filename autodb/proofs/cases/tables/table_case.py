"""A case of the proof on published tables: what a user has, and what is known of each component."""

from dataclasses import dataclass, field

import pandas as pd

from autodb.proofs.cases.real.real_case import RealSpec
from autodb.proofs.cases.tables.published_tables import Array, PublishedTable
from autodb.proofs.cases.tables.table_models import PublishedModel


@dataclass(frozen=True)
class TableCase:
    """One component of a table, its simulation, and what is true of both.

    ``concealed``, ``sizes``, ``seen``, ``rms_full``, ``own_peaks`` and ``retuned`` are as those of
    a case of a real axis. A component that an effect leaves alone is a null.
    """

    spec: RealSpec
    channel: str
    rms_full: float
    concealed: str | None = None
    sizes: dict[str, float] = field(default_factory=dict)
    seen: bool = True
    own_peaks: dict[str, float] = field(default_factory=dict)
    retuned: tuple[str, ...] = ()

    @property
    def name(self) -> str:
        """Return a name that no other case has."""
        return f"{self.spec.name}/{self.channel}"

    @property
    def kind(self) -> str:
        """Return `left out`, `injected` or `null`."""
        return "null" if self.concealed is None else self.spec.kind

    @property
    def machine(self) -> str:
        """Return the table."""
        return self.spec.recording

    @property
    def recording(self) -> str:
        """Return the table and the component."""
        return f"{self.spec.recording} {self.channel}"

    @property
    def strength(self) -> str:
        """Return how strongly the effect shows: `weak`, `strong` or nothing."""
        return self.spec.strength

    @property
    def tuning(self) -> str:
        """Return what the simulation's own laws are, or `beside` an effect in other components."""
        if self.spec.kind == "null":
            return self.spec.variant
        return self.spec.variant.split(" ")[0] if self.concealed else "beside an effect"

    @property
    def fair(self) -> tuple[str, ...]:
        """Return the names that are right, the concealed one first."""
        return tuple(self.sizes)

    @property
    def true_size(self) -> float | None:
        """Return the peak of what is concealed, N."""
        return None if self.concealed is None else self.sizes[self.concealed]

    @property
    def decidable(self) -> bool:
        """Say whether the effect shows, and no other name does as well."""
        return self.seen and (len(self.sizes) == 1 or self.kind != "injected")


@dataclass(frozen=True)
class TabledCase:
    """A table with its simulation (C, n), the laws that it has, and a case for each component."""

    spec: RealSpec
    table: PublishedTable
    simulated: Array
    own: PublishedModel
    cases: tuple[TableCase, ...]

    @property
    def includes(self) -> tuple[str, ...]:
        """Return the laws that the simulation has."""
        return self.own.terms

    def recording(self) -> pd.DataFrame:
        """Return the cuts with what was measured."""
        return self.table.frame()

    def simulation(self) -> pd.DataFrame:
        """Return the cuts with what is simulated."""
        return self.table.with_forces(self.simulated).frame()
