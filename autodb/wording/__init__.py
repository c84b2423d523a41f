"""What is said, in the reader's language, and numbers with the reader's marks and units.

Sentences are written in English where they are said; catalogues (``de.po``) have the others.
"""

from autodb.wording.amounts import amount_words, day, localized, shop_amount, significant
from autodb.wording.presentation import (
    ENGLISH,
    Presentation,
    ShopUnit,
    presentation,
    presented,
)
from autodb.wording.sentences import (
    Worded,
    language_of,
    listed,
    listed_stretches,
    msgid,
    phrase,
    phrase_many,
    stored_msgid,
)

__all__ = [
    "ENGLISH",
    "Presentation",
    "ShopUnit",
    "Worded",
    "amount_words",
    "day",
    "language_of",
    "listed",
    "listed_stretches",
    "localized",
    "msgid",
    "phrase",
    "phrase_many",
    "presentation",
    "presented",
    "shop_amount",
    "significant",
    "stored_msgid",
]
