"""A case of the proof on real axes: what a user has, and what is known of what is concealed."""

from dataclasses import dataclass, field

from autodb.proofs.cases.real.full_models import FittedModel
from autodb.proofs.cases.real.real_axis import Array, RealAxis

MISTUNED_BY = 0.03


@dataclass(frozen=True)
class RealSpec:
    """A case before it is made: ``variant`` is its tuning, or which rows a null has.

    ``recording`` is the folder's name of one that is `shown`. ``strength``: `weak`, `strong` or
    nothing.
    """

    kind: str
    recording: str
    term: str = ""
    strength: str = ""
    variant: str = ""

    @property
    def name(self) -> str:
        """Return a name that no other case has."""
        parts = (self.kind, self.recording, self.term, self.strength, self.variant)
        return "/".join(part for part in parts if part)


@dataclass(frozen=True)
class RealCase:
    """A recording of a real axis, a simulation of its effort, and what is true of both.

    ``concealed`` is what the simulation lacks, None in a null. ``sizes`` has the peak contribution
    of each fair name, the concealed one first. ``rms_full`` is the held-out error of the model that
    lacks nothing. ``seen``: the effect shows at all. ``own_peaks``: peak of each term that the
    simulation has. ``own`` has its columns; ``retuned`` terms were made wrong on purpose.
    """

    spec: RealSpec
    axis: RealAxis
    simulated: Array
    own: FittedModel
    rms_full: float
    concealed: str | None = None
    sizes: dict[str, float] = field(default_factory=dict)
    seen: bool = True
    includes: tuple[str, ...] = ()
    own_peaks: dict[str, float] = field(default_factory=dict)
    retuned: tuple[str, ...] = ()
    note: str = ""

    @property
    def name(self) -> str:
        """Return the name of the case."""
        return self.spec.name

    @property
    def kind(self) -> str:
        """Return `shown`, `left out`, `injected` or `null`."""
        return self.spec.kind

    @property
    def machine(self) -> str:
        """Return whose recording it is."""
        return self.axis.machine

    @property
    def strength(self) -> str:
        """Return how strongly the effect shows: `weak`, `strong`, or nothing of those that are."""
        return self.spec.strength

    @property
    def tuning(self) -> str:
        """Return what the simulation's own terms are, or which rows a null has."""
        return self.spec.variant

    @property
    def channel(self) -> str:
        """Return the channel that is explained."""
        return self.axis.channel

    @property
    def channels(self) -> dict[str, Array]:
        """Return what was recorded, by name, time first."""
        return self.axis.channels

    @property
    def simulation(self) -> dict[str, Array]:
        """Return time and the simulated effort."""
        return {"t": self.axis.t, self.axis.channel: self.simulated}

    @property
    def fair(self) -> tuple[str, ...]:
        """Return the names that are right, the concealed one first."""
        return tuple(self.sizes)

    @property
    def true_size(self) -> float | None:
        """Return the peak of what is concealed, in the unit of the channel."""
        return None if self.concealed is None else self.sizes[self.concealed]

    @property
    def decidable(self) -> bool:
        """Say whether the effect shows, and no other name does as well."""
        return self.seen and (len(self.sizes) == 1 or self.kind != "injected")
