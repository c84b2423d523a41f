"""One arena of the C library's allocator for all threads, so that memory does not grow with them.

Pages are made in threads, and glibc gives each an arena of its own that keeps what one page took:
some 6 MB a thread, of at most 40. Threads that hold the interpreter in turn seldom meet in one.
"""

import ctypes
import platform

M_ARENA_MAX = -8
"""The parameter's number (glibc, malloc.h)."""


def share_one() -> bool:
    """Have threads that begin from now on share the first arena; return whether they do."""
    if platform.libc_ver()[0] != "glibc":
        return False
    return bool(ctypes.CDLL(None).mallopt(M_ARENA_MAX, 1))
