"""What a term is."""

from dataclasses import dataclass
from typing import Literal


@dataclass(frozen=True)
class Parameter:
    """One named parameter: its unit in terms of the channel's unit ``U``, and its meaning."""

    name: str
    unit: str
    meaning: str


@dataclass(frozen=True)
class Term:
    """One physical effect that a channel can contain.

    ``name`` is an identifier of the vocabulary; ``channel`` the kind of channel it acts on;
    ``needs`` what must be recorded to see it; ``statement`` a sentence in shop words;
    ``excited_by`` the move or cut that shows it best; ``alike`` the effects that one recording can
    never tell it from, ``told_apart_by`` what could.
    """

    name: str
    channel: Literal["axis", "cuts"]
    parameters: tuple[Parameter, ...]
    needs: tuple[str, ...]
    statement: str
    excited_by: str
    source: str
    alike: tuple[str, ...] = ()
    told_apart_by: str | None = None
