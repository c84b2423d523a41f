"""A lathe that has cut nothing, for which a shaft was predicted."""

from typing import TYPE_CHECKING

import pytest

from tests.conftest import Cli, Once
from tests.helpers.made_cuts import SHAFT, predict_job

if TYPE_CHECKING:
    pass


@pytest.fixture
def lathe(cli: Cli, once: Once) -> Cli:
    """Return the command line on a lathe that has cut nothing, for which a shaft was predicted."""

    def make() -> None:
        cli("init")
        cli("machine", "add", "lathe")
        predict_job(cli, "shaft", SHAFT)

    once(make)
    return cli
