"""Whether a message ends in what to do: a remedy in the imperative."""

import re

VERBS = (
    "add", "approach", "change", "check", "close", "copy", "correct", "create", "cut", "deliver",
    "double", "give", "go", "identify", "import", "install", "leave", "let", "make", "measure",
    "move", "name", "open", "pass", "program", "push", "put", "record", "remove", "rename",
    "repeat", "restore", "run", "save", "see", "send", "set", "sort", "start", "state", "store",
    "train", "try", "turn", "use", "wait", "write",
)  # fmt: skip


def has_remedy(line: str) -> bool:
    """Say whether a clause of a message begins with a verb in the imperative."""
    return re.search(rf"[;:,] (?:{'|'.join(VERBS)})\b", line) is not None
