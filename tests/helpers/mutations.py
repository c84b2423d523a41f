"""Mutations of bytes: cut off, replaced, inserted, moved, a few at once."""

from collections.abc import Callable

from hypothesis import strategies as st

Edit = Callable[[bytes], bytes]
PLACE = st.floats(0.0, 1.0, exclude_max=True)


def _cut(place: float) -> Edit:
    return lambda data: data[: max(1, int(place * len(data)))]


def _put(place: float, new: bytes, replaced: int) -> Edit:
    def edit(data: bytes) -> bytes:
        at = int(place * len(data))
        return data[:at] + new + data[at + replaced :]

    return edit


def _move(start: float, to: float, length: int) -> Edit:
    def edit(data: bytes) -> bytes:
        at = int(start * len(data))
        return _put(to, data[at : at + length], length)(data)

    return edit


TEXTS = st.sampled_from([b",", b"\n", b"\x00", b"\xff", b"nan", b"1e999", b'"', b";", b"-", b"\r"])
EDITS = st.one_of(
    st.builds(_cut, PLACE),
    st.builds(lambda place, byte: _put(place, bytes([byte]), 1), PLACE, st.integers(0, 255)),
    st.builds(_put, PLACE, st.one_of(TEXTS, st.binary(max_size=16)), st.integers(0, 16)),
    st.builds(_move, PLACE, PLACE, st.integers(1, 64)),
)
MUTATIONS = st.lists(EDITS, min_size=1, max_size=6)


def mutated(whole: bytes, edits: list[Edit]) -> bytes:
    """Return bytes after edits, one after the other."""
    for edit in edits:
        whole = edit(whole)
    return whole
