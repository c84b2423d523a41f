"""Forces from drive signals by networks that remember (LSTM); needs the extra `lstm`."""

from importlib.util import find_spec

from autodb.errors import UnusableInput


def need_torch() -> None:
    """Raise UnusableInput, saying what to install, where PyTorch is not there."""
    if find_spec("torch") is None:
        raise UnusableInput("networks need PyTorch: run pip install 'autodb[lstm]'")
