"""What machines know of pairs, kept for as long as the database stays as it is."""

import threading
from collections import OrderedDict
from dataclasses import dataclass

from autodb.agent.grounds import Grounds
from autodb.agent.looking_up import Shelf
from autodb.store import Store
from autodb.store.watched import Watched

MOST = 2000
"""Pairs that are kept. Chosen: some 20 kB each."""
Key = tuple[str, str, str]


@dataclass(frozen=True)
class Marked:
    """Grounds, and the mark of the state of the database that they are of."""

    mark: str
    grounds: Grounds


class Shelves:
    """Grounds by machine, material and tool, as the database has them now."""

    def __init__(self, store: Store, watched: Watched) -> None:
        self._store, self._watched = store, watched
        self._lock = threading.Lock()
        self._mark = ""
        self._kept: OrderedDict[Key, Grounds] = OrderedDict()

    def grounds(self, machine: str, material: str, tool: str) -> Marked:
        """Return what answers about a machine's pair rest on.

        Raises UnusableInput for a machine that is not there, or a pair that was learnt under an
        earlier law only.
        """
        key = machine, material, tool
        mark = self._watched.mark()
        with self._lock:
            if mark != self._mark:
                self._mark = mark
                self._kept.clear()
            found = self._kept.get(key)
            if found is not None:
                self._kept.move_to_end(key)
                return Marked(mark, found)
        with self._store.reading() as session:
            found = Shelf(session, machine).grounds(material, tool)
            session.expunge_all()
        with self._lock:
            if mark == self._mark:
                self._kept[key] = found
                if len(self._kept) > MOST:
                    self._kept.popitem(last=False)
        return Marked(mark, found)
