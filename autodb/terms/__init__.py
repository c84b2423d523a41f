"""The physics of every channel: one term is one effect with named parameters.

Adding physics is one function and its test: write the column, list it in ``TERMS``.
"""

from autodb.terms._term import Parameter, Term
from autodb.terms.drive import EXTERNAL_LOAD, GRAVITY, INERTIA
from autodb.terms.friction import COULOMB, VISCOUS
from autodb.terms.process import EDGE_FORCE, SHEAR, TOOL_WEAR

TERMS: tuple[Term, ...] = (
    COULOMB,
    VISCOUS,
    INERTIA,
    GRAVITY,
    EXTERNAL_LOAD,
    SHEAR,
    EDGE_FORCE,
    TOOL_WEAR,
)

__all__ = ["TERMS", "Parameter", "Term"]
