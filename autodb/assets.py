"""Find the kits that ship beside the code: calibration, schema, sample_jobs."""

from importlib.resources import files
from pathlib import Path


def kit(name: str) -> Path:
    """Return the folder of kit ``name``, in an installed wheel or in a checkout.

    Raises FileNotFoundError when the installation lacks it.
    """
    package = Path(str(files("autodb")))
    for folder in (package / "_assets" / name, package.parent / name):
        if folder.is_dir():
            return folder
    raise FileNotFoundError(f"kit '{name}' is not in this installation of autodb ({package})")
