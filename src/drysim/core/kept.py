"""Compiled kernels as they are kept on disk: what cannot be read is compiled again."""

from __future__ import annotations

import contextlib
import hashlib
import pickle
from functools import cache
from typing import Any

CHECKSUM = 32
"""Bytes at the beginning of a file: the SHA-256 of all behind them."""


def keep(kernel: Any) -> None:
    """Make a kernel live on in the cache folder that numba is set to."""
    kernel._cache = cache_class()(kernel.py_func)


def sealed(words: bytes) -> bytes:
    """Return bytes with their checksum before them."""
    return hashlib.sha256(words).digest() + words


def unsealed(words: bytes) -> bytes:
    """Return what was sealed.

    Raises
    ------
    ValueError
        When it is not what was written.
    """
    if hashlib.sha256(words[CHECKSUM:]).digest() != words[:CHECKSUM]:
        raise ValueError("a kernel on disk is not what was written")
    return words[CHECKSUM:]


@cache
def cache_class() -> Any:
    """Give the class of numba's caches that hold what is whole, and else nothing.

    Notes
    -----
    A power loss may leave a file that is cut short or ends in zeros. Numba would fail on the
    first in every process, and run the second: so each file is kept with its checksum, which is
    verified before a byte is unpickled, and one that is not whole counts as not there. Nor is a
    full disk an error. The folder is named for the version of numba and belongs to the user
    alone: see `compiled.cache_folder`.
    """
    from numba.core.caching import FunctionCache, IndexDataCacheFile

    class Sealed(IndexDataCacheFile):
        """The index of a function's kernels, and the kernels, in files with a checksum."""

        def _load_index(self) -> Any:
            try:
                stamp, overloads = self._read(self._index_path)
            except FileNotFoundError:
                return {}
            return overloads if stamp == self._source_stamp else {}

        def _save_index(self, overloads: Any) -> None:
            self._write(self._index_path, (self._source_stamp, overloads))

        def _load_data(self, name: str) -> Any:
            return self._read(self._data_path(name))

        def _save_data(self, name: str, data: Any) -> None:
            self._write(self._data_path(name), data)

        def _read(self, path: str) -> Any:
            with open(path, "rb") as stream:
                return pickle.loads(unsealed(stream.read()))

        def _write(self, path: str, data: Any) -> None:
            with self._open_for_write(path) as stream:
                stream.write(sealed(self._dump(data)))

    class Sound(FunctionCache):
        """The kernels of one function that can be read."""

        def __init__(self, py_func: Any) -> None:
            super().__init__(py_func)
            stamp = self._impl.locator.get_source_stamp()
            self._cache_file = Sealed(self._cache_path, self._impl.filename_base, stamp)

        def load_overload(self, sig: Any, target_context: Any) -> Any:
            """Give a kernel, or None where there is none that is whole."""
            try:
                return super().load_overload(sig, target_context)
            except Exception:  # what numba makes of a file of another machine may be anything
                with contextlib.suppress(OSError):
                    self.flush()
                return None

        def save_overload(self, sig: Any, data: Any) -> None:
            """Keep a kernel, if there is room for it."""
            with contextlib.suppress(OSError):
                super().save_overload(sig, data)

    return Sound
