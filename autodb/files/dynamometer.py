"""What a side file or a machine's file states of the dynamometer, or of where forces are from."""

from typing import Annotated

from pydantic import BeforeValidator, Field, model_validator

from autodb.files.toml import NotNegative, Positive, Section
from autodb.wording import phrase

COMPONENTS = ("x", "y", "z")


class OfComponents(Section):
    """A number for each component of the force; None: not stated of this one."""

    x: NotNegative | None = None
    y: NotNegative | None = None
    z: NotNegative | None = None


def _for_each(value: object) -> object:
    plain = isinstance(value, int | float) and not isinstance(value, bool)
    return dict.fromkeys(COMPONENTS, value) if plain else value


Each = Annotated[
    OfComponents, BeforeValidator(_for_each, json_schema_input_type=OfComponents | float)
]
"""One number for all components, or a table of x, y, z."""


def of_component(each: OfComponents | None, component: str) -> float | None:
    """Return what is stated of a component; None: nothing."""
    found: float | None = None if each is None else getattr(each, component)
    return found


class StatedUncertainty(Section):
    """Expanded uncertainty (k = 2) of a force as its source states it, in all.

    ``uncertainty_percent`` of the force, ``uncertainty_N`` beside it; both are added in quadrature.
    """

    uncertainty_percent: Each | None = None
    uncertainty_N: Each | None = None

    @property
    def stated(self) -> bool:
        """Whether it is stated at all."""
        return self.uncertainty_percent is not None or self.uncertainty_N is not None


class DynamometerSection(StatedUncertainty):
    """A dynamometer: what its certificate and its maker state, and what is known of its mounting.

    ``certificate_percent``: expanded uncertainty of the force with ``certificate_k``;
    ``crosstalk_percent``: limit of what another component adds, of that one's force; ``drift_N``:
    limit over a recording; ``mounting_percent``: limit of what the mounting changes of the force;
    ``noise_N``: standard deviation of the mean of one cut.
    """

    name: str | None = None
    certificate: str | None = None
    certificate_date: str | None = Field(default=None, pattern=r"^\d{4}(-\d{2}(-\d{2})?)?$")
    certificate_percent: Each | None = None
    certificate_k: Positive = 2.0
    crosstalk_percent: Each | None = None
    drift_N: Each | None = None
    mounting_percent: Each | None = None
    noise_N: Each | None = None

    @model_validator(mode="after")
    def _whole_or_parts(self) -> "DynamometerSection":
        parts = ("certificate_percent", "crosstalk_percent", "drift_N", "mounting_percent")
        also = next((name for name in parts if getattr(self, name) is not None), None)
        if self.stated and also is not None:
            raise ValueError(
                phrase(
                    "uncertainty_percent and uncertainty_N are the whole, {also} is a part of it; "
                    "state one or the other",
                    also=also,
                )
            )
        return self


class PublicationSection(StatedUncertainty):
    """A publication that forces were taken from: a handbook, a thesis, an article."""

    title: str
    author: str | None = None
    year: int | None = None
    page: str | int | None = None
    url: str | None = None

    @property
    def words(self) -> str:
        """The source as it is cited."""
        page = None if self.page is None else f"p. {self.page}"
        year = None if self.year is None else str(self.year)
        return ", ".join(one for one in (self.author, self.title, year, page, self.url) if one)
