"""Databases here are made table by table: how one is made is what is asked."""

import pytest


@pytest.fixture(autouse=True)
def made_anew() -> None:
    """Have none copied."""
