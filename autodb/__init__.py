"""Every CNC machine keeps its own machining database.

    import autodb

    db = autodb.open("shop.sqlite3", create=True)
    m = db.add_machine("lathe-1")
    m.import_(cuts)                      # a pandas table, any data frame, or a file
    m.calibrate()
    m.refresh()
    m.predict("job.toml").to_pandas()
    autodb.explain(recording, simulation).plot()

Names load when they are used: importing the package imports nothing.
"""

import sys
from importlib import import_module
from types import ModuleType
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from autodb.errors import UnusableInput
    from autodb.library.alone import explain_data as explain
    from autodb.library.alone import identify_data as identify
    from autodb.library.database import Database
    from autodb.library.database import open_database as open  # noqa: A004 - as `gzip.open`
    from autodb.library.machine import ShopMachine

__version__ = "0.3.0"
__all__ = ["Database", "ShopMachine", "UnusableInput", "explain", "identify", "open"]

_PLACES = {
    "Database": "library.database:Database",
    "ShopMachine": "library.machine:ShopMachine",
    "UnusableInput": "errors:UnusableInput",
    "explain": "library.alone:explain_data",
    "identify": "library.alone:identify_data",
    "open": "library.database:open_database",
}


def __getattr__(name: str) -> Any:
    if name not in _PLACES:
        raise AttributeError(f"module '{__name__}' has no attribute '{name}'")
    module, _, attribute = _PLACES[name].partition(":")
    return getattr(import_module(f"{__name__}.{module}"), attribute)


class _Package(ModuleType):
    """The package, whose `explain` is the function, also once the room of that name is imported."""

    @property
    def explain(self) -> Any:
        """The function."""
        return __getattr__("explain")

    @explain.setter
    def explain(self, room: ModuleType) -> None:
        """Leave the room where `import` finds it: in sys.modules."""


sys.modules[__name__].__class__ = _Package
