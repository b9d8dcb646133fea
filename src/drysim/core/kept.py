"""Compiled kernels as they are kept on disk: what cannot be read is compiled again."""

from __future__ import annotations

import contextlib
import pickle
import zlib
from functools import cache
from typing import Any


def keep(kernel: Any) -> None:
    """Make a kernel live on in the cache folder that numba is set to."""
    kernel._cache = cache_class()(kernel.py_func)


@cache
def cache_class() -> Any:
    """Give the class of numba's caches that hold what is whole, and else nothing.

    Notes
    -----
    A power loss may leave a file that is cut short or ends in zeros. Numba would fail on the
    first in every process, and run the second: so each kernel is kept with its checksum, and
    one that cannot be read whole counts as not there. Nor is a full disk an error.
    """
    from numba.core.caching import CompileResultCacheImpl, FunctionCache
    from numba.core.serialize import dumps

    class Checked(CompileResultCacheImpl):
        """A kernel as bytes, with their checksum."""

        def reduce(self, cres: Any) -> tuple[int, bytes]:
            """Give what is kept of a kernel."""
            made: bytes = dumps(super().reduce(cres))
            return zlib.crc32(made), made

        def rebuild(self, target_context: Any, reduced_data: tuple[int, bytes]) -> Any:
            """Give the kernel again."""
            checksum, made = reduced_data
            if zlib.crc32(made) != checksum:
                raise ValueError("a kernel on disk is not what was written")
            return super().rebuild(target_context, pickle.loads(made))

    class Sound(FunctionCache):
        """The kernels of one function that can be read."""

        _impl_class = Checked

        def load_overload(self, sig: Any, target_context: Any) -> Any:
            """Give a kernel, or None where there is none that is whole."""
            try:
                return super().load_overload(sig, target_context)
            except Exception:  # what a damaged pickle raises may be anything
                with contextlib.suppress(OSError):
                    self.flush()
                return None

        def save_overload(self, sig: Any, data: Any) -> None:
            """Keep a kernel, if there is room for it."""
            with contextlib.suppress(OSError):
                super().save_overload(sig, data)

    return Sound
