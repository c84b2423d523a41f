"""The numerical core under other kernels than this processor's: `python -m tests.by_hand.kernels`.

BLAS chooses its kernels by the processor, and so does NumPy: sums are rounded in another order. A
test that passes under one kernel only is a defect of the product. A kernel that this processor
lacks is left out with a word.
"""

import os
import subprocess
import sys

CORE = (
    "fitting", "cutting/test_shear.py", "cutting/test_elements.py", "terms/test_terms.py",
    "explain/engine/test_own_terms.py", "explain/cuts/test_six_cuts.py", "forward/test_forward.py",
    "whole/test_one_answer.py", "whole/test_sample_jobs.py",
)  # fmt: skip
LEFT_OUT = "mackey_glass or 95_per_cent"
"""Campaigns of many fits, which `make test` runs once."""
CHOSEN = (
    "import numpy, scipy.linalg, threadpoolctl;"
    "print(*sorted({one['architecture'] for one in threadpoolctl.threadpool_info()"
    " if one['internal_api'] == 'openblas'}))"
)
VECTORS = (
    "from numpy._core._multiarray_umath import __cpu_dispatch__ as ways, __cpu_features__ as has;"
    "print(*[one for one in ways if has.get(one)])"
)
"""What NumPy's own loops use beyond its baseline here: AVX2 and AVX-512, by the names it has."""


def main() -> int:
    """Run the core under each kernel; return 1 where any test fails under one."""
    failed = False
    for kernel in ("Haswell", "Nehalem"):
        taken = _said(CHOSEN, OPENBLAS_CORETYPE=kernel)
        if taken != kernel:
            print(f"OPENBLAS_CORETYPE={kernel}: left out, this processor takes {taken}")
            continue
        failed |= _run(f"OpenBLAS {taken}", OPENBLAS_CORETYPE=kernel)
    vectors = _said(VECTORS)
    if not vectors:
        print("NPY_DISABLE_CPU_FEATURES: left out, NumPy uses none beyond its baseline here")
    else:
        failed |= _run(f"NumPy without {vectors}", NPY_DISABLE_CPU_FEATURES=vectors)
    return int(failed)


def _said(code: str, **settings: str) -> str:
    done = subprocess.run(
        [sys.executable, "-c", code],
        env={**os.environ, **settings}, capture_output=True, text=True, check=True,
    )  # fmt: skip
    return done.stdout.strip()


def _run(what: str, **settings: str) -> bool:
    print(f"{what}:", flush=True)
    files = [f"tests/{name}" for name in CORE]
    options = ["-q", "-n", "2", "--dist", "worksteal", "-k", f"not ({LEFT_OUT})"]
    done = subprocess.run(
        [sys.executable, "-m", "pytest", *options, *files],
        env={**os.environ, **settings}, check=False,
    )  # fmt: skip
    return done.returncode != 0


if __name__ == "__main__":
    sys.exit(main())
