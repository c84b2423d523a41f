"""What machines know of pairs, kept for as long as the database has nothing newer of them."""

import threading
from collections import OrderedDict
from dataclasses import dataclass

from autodb.agent.answer.looking_up import PairReader
from autodb.agent.answer.prediction_basis import PredictionBasis
from autodb.store import Store
from autodb.store.watched import Watched, opening

MOST = 1000
"""Pairs that are kept. Chosen: some 20 kB each, and as much more of each operation that is asked
for; looking for garbage among them takes 10 ms."""
Key = tuple[str, str, str]


@dataclass(frozen=True)
class Marked:
    """Grounds, and the mark of the state of the database that they are of."""

    mark: str
    basis: PredictionBasis


class LookupCache:
    """Grounds by machine, material and tool, as the database has them now.

    After any change of the database a pair that is kept costs a look at the numbers of its newest
    versions, and only where these differ it is read again.
    """

    def __init__(self, store: Store, watched: Watched) -> None:
        self._store, self._watched = store, watched
        self._lock = threading.Lock()
        self._opening = ""
        self._kept: OrderedDict[Key, Marked] = OrderedDict()

    def basis(self, machine: str, material: str, tool: str, *, mark: str | None = None) -> Marked:
        """Return what answers about a machine's pair rest on.

        ``mark``: of the database's state, where it was asked for already. Raises UnusableInput for
        a machine that is not there, or a pair that was learnt under an earlier law only.
        """
        key = machine, material, tool
        mark = self._watched.mark() if mark is None else mark
        kept = self._find(key, opening(mark))
        if kept is not None and kept.mark == mark:
            return kept
        with self._store.reading() as session:
            pair_reader = PairReader(session, machine)
            if (
                kept is not None
                and kept.basis.stamp == pair_reader.stamp(material, tool) is not None
            ):
                found = kept.basis
            else:
                found = pair_reader.basis(material, tool)
                session.expunge_all()
        return self._keep(key, Marked(mark, found))

    def _find(self, key: Key, opened: str) -> Marked | None:
        """Return what is kept of a pair; nothing of a database that another took the place of."""
        with self._lock:
            if opened != self._opening:
                self._opening = opened
                self._kept.clear()
            return self._kept.get(key)

    def _keep(self, key: Key, marked: Marked) -> Marked:
        with self._lock:
            if opening(marked.mark) == self._opening:
                self._kept[key] = marked
                self._kept.move_to_end(key)
                if len(self._kept) > MOST:
                    self._kept.popitem(last=False)
        return marked
