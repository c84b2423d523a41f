"""What is learnt: drive models, cutting parameters, and priors shared between machines."""

from typing import TYPE_CHECKING, Any

from sqlalchemy import ForeignKey, Index, UniqueConstraint
from sqlalchemy.orm import Mapped, mapped_column, relationship

from autodb.store.models._base import Base, link, now
from autodb.store.models.recording import StoredRecording
from autodb.store.models.sensing import SensedForce
from autodb.store.models.work import Material, Pair

if TYPE_CHECKING:
    from autodb.store.models.answers import Mismatch

channel_model_recording = link("channel_model_recording", "channel_model", "recording")
channel_model_mismatch = link("channel_model_mismatch", "channel_model", "mismatch")
"""The mismatches that a version's new terms came from: the version is what confirming them made."""
cutting_parameters_force = link("cutting_parameters_force", "cutting_parameters", "sensed_force")
cutting_parameters_mismatch = link("cutting_parameters_mismatch", "cutting_parameters", "mismatch")
"""The mismatches that a version's terms came from."""
EVERY = "every"
"""Operation and component of parameters that hold for all of them."""
fleet_prior_parameters = link("fleet_prior_parameters", "fleet_prior", "cutting_parameters")


class ChannelModel(Base):
    """One version of an axis' identified drive model: terms, values, covariance, protocol.

    ``errors``: how far off it is by what the axis does; NULL: not counted. ``off_law``: what
    friction is off its laws; NULL: the terms are all. ``parent``: the version whose posterior it
    took as prior; NULL: it started from none.
    """

    __tablename__ = "channel_model"
    __table_args__ = (UniqueConstraint("machine_id", "channel", "version"),)
    id: Mapped[int] = mapped_column(primary_key=True)
    machine_id: Mapped[int] = mapped_column(ForeignKey("machine.id"), index=True)
    axis: Mapped[str]
    channel: Mapped[str]
    version: Mapped[int]
    unit: Mapped[str]
    terms: Mapped[list[Any]]
    covariance: Mapped[list[Any]]
    relative_error: Mapped[float]
    protocol: Mapped[str]
    errors: Mapped[dict[str, Any] | None]
    off_law: Mapped[dict[str, Any] | None]
    created_at: Mapped[str] = mapped_column(default=now)
    undone_at: Mapped[str | None]
    parent_id: Mapped[int | None] = mapped_column(
        ForeignKey("channel_model.id", name="fk_channel_model_parent")
    )
    parent: Mapped["ChannelModel | None"] = relationship(remote_side="ChannelModel.id")
    recordings: Mapped[list[StoredRecording]] = relationship(secondary=channel_model_recording)


class CuttingParameters(Base):
    """One version of a pair's posterior on a machine: coordinates of ``law``, their covariance.

    ``operation`` and ``component`` are EVERY: a law of edge elements holds for all of them; earlier
    versions of autodb kept a law for each, with its ``process_share`` and ``misfit_N``. ``state``:
    the process state that it is of; NULL: the usual one. ``shared``: errors behind the coordinates,
    by key with the covariance that they began with; ``scatter``: share and weight of its parts,
    and how far the law may be off; ``terms``: effects beside the law that a person confirmed, by
    name, what of each is no error in ``shared``; NULL: none.
    ``forces``: what this version added to ``previous``; without a previous version it starts from
    ``prior``, or from what ``started_from`` says, ``relative`` where that is another pair.
    ``start``: mean and covariance of the law's coordinates before any of the pair's own cuts; NULL:
    not known. ``undone_at``: when the version was taken back.
    """

    __tablename__ = "cutting_parameters"
    __table_args__ = (
        UniqueConstraint(
            "machine_id", "pair_id", "operation", "component", "version",
            name="uq_cutting_parameters_key",
        ),
        Index("ix_cutting_parameters_state", "machine_id", "pair_id", "state", "version"),
    )  # fmt: skip
    id: Mapped[int] = mapped_column(primary_key=True)
    machine_id: Mapped[int] = mapped_column(ForeignKey("machine.id"), index=True)
    pair_id: Mapped[int] = mapped_column(ForeignKey("pair.id"), index=True)
    operation: Mapped[str]
    component: Mapped[str]
    version: Mapped[int]
    law: Mapped[str]
    state: Mapped[str | None]
    mean: Mapped[list[Any]]
    covariance: Mapped[list[Any]]
    process_share: Mapped[float | None]
    misfit_N: Mapped[float | None]
    shared: Mapped[list[Any] | None]
    scatter: Mapped[dict[str, Any] | None]
    terms: Mapped[dict[str, Any] | None]
    start: Mapped[dict[str, Any] | None]
    n_cuts: Mapped[int]
    previous_id: Mapped[int | None] = mapped_column(ForeignKey("cutting_parameters.id"))
    prior_id: Mapped[int | None] = mapped_column(
        ForeignKey("fleet_prior.id", name="fk_cutting_parameters_prior")
    )
    started_from: Mapped[str | None]
    relative_id: Mapped[int | None] = mapped_column(
        ForeignKey("cutting_parameters.id", name="fk_cutting_parameters_relative")
    )
    created_at: Mapped[str] = mapped_column(default=now)
    undone_at: Mapped[str | None]
    pair: Mapped[Pair] = relationship()
    previous: Mapped["CuttingParameters | None"] = relationship(
        foreign_keys=previous_id, remote_side="CuttingParameters.id"
    )
    relative: Mapped["CuttingParameters | None"] = relationship(
        foreign_keys=relative_id, remote_side="CuttingParameters.id"
    )
    prior: Mapped["FleetPrior | None"] = relationship()
    forces: Mapped[list[SensedForce]] = relationship(secondary=cutting_parameters_force)
    mismatches: Mapped[list["Mismatch"]] = relationship(
        secondary=cutting_parameters_mismatch,
        order_by="Mismatch.id",
        back_populates="parameters_of_pairs",
    )


class FleetPrior(Base):
    """What several machines know of a material: where a machine new to it starts from.

    ``mean`` and ``covariance``: of the material, whatever the tool; ``known``: the spreads, what
    each tool's pairs told in sum, and which machines disagree.
    """

    __tablename__ = "fleet_prior"
    __table_args__ = (
        UniqueConstraint(
            "material_id", "operation", "component", "law", "version", name="uq_fleet_prior_key"
        ),
    )
    id: Mapped[int] = mapped_column(primary_key=True)
    material_id: Mapped[int] = mapped_column(ForeignKey("material.id"), index=True)
    operation: Mapped[str]
    component: Mapped[str]
    law: Mapped[str]
    version: Mapped[int]
    mean: Mapped[list[Any]]
    covariance: Mapped[list[Any]]
    machines: Mapped[int]
    known: Mapped[dict[str, Any] | None]
    created_at: Mapped[str] = mapped_column(default=now)
    material: Mapped[Material] = relationship()
    parameters: Mapped[list[CuttingParameters]] = relationship(secondary=fleet_prior_parameters)
