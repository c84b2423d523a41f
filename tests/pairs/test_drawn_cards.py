"""Material cards, drawn: written, read and written again they are the same text."""

import os
from pathlib import Path

import numpy as np
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from autodb.cutting.kienzle import ViewRange
from autodb.pairs.card import Bounded, KienzleCard
from autodb.pairs.cards import cards_as_csv, read_cards

TIMES = int(os.environ.get("AUTODB_MUTATIONS", "1"))
NAMES = st.text(
    st.characters(blacklist_categories=("Cc", "Cs", "Zl", "Zp", "Zs")), min_size=1, max_size=12
)
CARDS = st.builds(
    lambda name, source, size, off, m_c, chips, rake_deg: KienzleCard(
        name,
        Bounded(size, size * (1.0 - off), size * (1.0 + off)),
        m_c,
        (0.5 * m_c, 0.5 * (m_c + 0.9)),
        ViewRange(chips, 3.0 * chips, 100.0 * (1.0 + off), float(np.radians(rake_deg))),
        source,
    ),
    NAMES,
    NAMES,
    st.floats(150.0, 9000.0),
    st.floats(0.01, 0.4),
    st.floats(0.05, 0.6),
    st.floats(0.01, 0.3),
    st.floats(-12.0, 20.0),
)


def test_cards_are_the_same_after_any_way_through_a_file(tmp_path: Path) -> None:
    path = tmp_path / "cards.csv"

    @settings(
        max_examples=40 * TIMES,
        deadline=None,
        database=None,
        derandomize=TIMES == 1,
        suppress_health_check=list(HealthCheck),
    )
    @given(st.lists(CARDS, min_size=1, max_size=4, unique_by=lambda card: card.material))
    def check(cards: list[KienzleCard]) -> None:
        text = cards_as_csv(cards)
        path.write_text(text, "utf-8")
        again = read_cards(path)
        assert [(c.material, c.source) for c in again] == [(c.material, c.source) for c in cards]
        assert cards_as_csv(again) == text

    check()
