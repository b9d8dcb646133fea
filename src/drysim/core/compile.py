"""The engine: kernels compiled by numba or as plain Python, and their cache.

The kernels of the core have one source and two engines: compiled by numba, or left as plain
Python. The engine is settled once, before the first kernel is imported.

Compiled kernels are kept in the user's cache folder under a name made from the core's source,
Python and numba, so that they are never stale. A power loss may leave a file that is cut short
or ends in zeros. Numba would fail on the first in every process, and run the second: so each
file is kept with its checksum, which is verified before a byte is unpickled, and one that is
not whole counts as not there and is compiled again. Nor is a full disk an error.
"""

from __future__ import annotations

import contextlib
import hashlib
import os
import pickle
import stat
import sys
import tempfile
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any, TypeVar, cast

from drysim.errors import DrysimError

Kernel = TypeVar("Kernel", bound=Callable[..., Any])

ENGINE_VARIABLE = "DRYSIM_ENGINE"

PLAIN, COMPILED, AUTO = "plain", "compiled", "auto"

MAX_PLAIN_STEPS = 200_000
"""Up to this many steps plain Python ends before the compiler is loaded (2 µs a step)."""

COLD_CACHE_FACTOR = 10
"""So many times as much work is worth it to compile what a law has of its own: 20 s, once."""

CHECKSUM_BYTES = 32
"""Bytes at the beginning of a cached file: the SHA-256 of all behind them."""


# The kernels.


def compiled(function: Kernel) -> Kernel:
    """Compile a kernel with numba and keep it on disk; leave it alone in the plain engine.

    A kernel may not allocate: arrays come from its caller and are not counted as references,
    which would cost more than a step at each call. One that serves small scenes takes few
    arguments and no tuples: numba looks at each of them, and longest at those.
    """
    return function if is_plain() else jit(function, forceinline=False)


def inlined(function: Kernel) -> Kernel:
    """Compile a kernel like `compiled`, into its callers: for what a hot loop calls often."""
    return function if is_plain() else jit(function, forceinline=True)


def inlined_with_fma(function: Kernel) -> Kernel:
    """Compile a kernel like `inlined`, with the sum of a product rounded once, not twice.

    That is less work where all lanes of a register are busy. What is mirrored stays so; plain
    Python rounds twice and agrees to rounding. A kernel that others share may be given too: it
    stays what it is for them.
    """
    if is_plain():
        return function
    plain = cast(Kernel, getattr(function, "py_func", function))
    return jit(plain, "fused", forceinline=True, fastmath={"contract"})


def jit(function: Kernel, subfolder: str = "", **options: Any) -> Kernel:
    """Compile a kernel, with the cache folder of exactly this source, or one beneath it."""
    numba = import_numba()
    make: Any = numba.njit
    kernel = make(nogil=True, error_model="numpy", _nrt=False, **options)(function)
    settings: Any = numba.config
    before, folder = settings.CACHE_DIR, cache_folder()
    if folder is not None:
        settings.CACHE_DIR = str(folder / subfolder)
        try:
            kernel._cache = checked_cache_class()(kernel.py_func)
        finally:
            settings.CACHE_DIR = before
    return cast(Kernel, kernel)


def import_numba() -> Any:
    """Return numba.

    Raises
    ------
    DrysimError
        When it cannot be loaded: a part of it may be missing, or the memory for it.
    """
    try:
        import numba
    except (ImportError, OSError) as fault:
        reason, *_ = str(fault).partition(". ")
        raise DrysimError(
            f"the compiler (numba) cannot be loaded: {reason}",
            f"it takes some 0.5 GB of address space (ulimit -v); {ENGINE_VARIABLE}={PLAIN} does "
            "without it, more slowly",
        ) from fault
    return numba


def is_compiling() -> bool:
    """Return whether a kernel is being compiled just now, which nothing may interrupt."""
    lock = sys.modules.get("numba.core.compiler_lock")
    return lock is not None and bool(lock.global_compiler_lock.is_locked())


def as_engine_array(values: Any) -> Any:
    """Return an array as the engine reads it fastest: plain Python indexes lists."""
    return values.tolist() if is_plain() and hasattr(values, "tolist") else values


# The engine.


def engine() -> str:
    """Return the engine in force: `plain` or `compiled`.

    Raises
    ------
    ValueError
        When the environment variable DRYSIM_ENGINE holds another word.
    """
    word = os.environ.get(ENGINE_VARIABLE, AUTO)
    if word not in (PLAIN, COMPILED, AUTO):
        raise ValueError(
            f"{ENGINE_VARIABLE} must be {PLAIN}, {COMPILED} or {AUTO}, not {word!r}"
        )
    return COMPILED if word == AUTO else word


@cache
def is_plain() -> bool:
    """Return whether the kernels are plain; the first kernel settles it for all of them."""
    return engine() == PLAIN


def choose_engine(steps: int, kernels: str = "") -> None:
    """Settle `auto` for a job of so many steps; nothing to do once kernels are loaded.

    Parameters
    ----------
    steps : int
        In steps of sampled motion under Coulomb's law.
    kernels : str
        What the job needs besides, as `module.function`, any of them, separated by blanks.
    """
    loaded = "drysim.core.oscillator" in sys.modules
    if loaded or os.environ.get(ENGINE_VARIABLE, AUTO) != AUTO:
        return
    plain = steps <= MAX_PLAIN_STEPS or (
        steps <= COLD_CACHE_FACTOR * MAX_PLAIN_STEPS and not is_cached(kernels)
    )
    os.environ[ENGINE_VARIABLE] = PLAIN if plain else COMPILED


def is_cached(kernels: str) -> bool:
    """Return whether one of these kernels is on disk already, named as in `choose_engine`."""
    folder = cache_folder()
    return not kernels or any(
        folder is not None and any(folder.glob(f"*/{name}-*.nbi")) for name in kernels.split()
    )


# The cache.


@cache
def checked_cache_class() -> Any:
    """Return the class of numba's caches that hold what is whole, and else nothing.

    The folder is that which numba is set to, see `cache_folder`.
    """
    from numba.core.caching import FunctionCache, IndexDataCacheFile

    class ChecksummedIndex(IndexDataCacheFile):
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
                sealed = stream.read()
            checksum, words = sealed[:CHECKSUM_BYTES], sealed[CHECKSUM_BYTES:]
            if hashlib.sha256(words).digest() != checksum:
                raise ValueError("a kernel on disk is not what was written")
            return pickle.loads(words)

        def _write(self, path: str, data: Any) -> None:
            words = self._dump(data)
            with self._open_for_write(path) as stream:
                stream.write(hashlib.sha256(words).digest() + words)

    class CheckedCache(FunctionCache):
        """The kernels of one function that can be read."""

        def __init__(self, py_func: Any) -> None:
            super().__init__(py_func)
            stamp = self._impl.locator.get_source_stamp()
            self._cache_file = ChecksummedIndex(
                self._cache_path, self._impl.filename_base, stamp
            )

        def load_overload(self, sig: Any, target_context: Any) -> Any:
            """Return a kernel, or None where there is none that is whole."""
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

    return CheckedCache


@cache
def cache_folder() -> Path | None:
    """Return a folder for kernels of exactly this source that the user alone may write.

    It lies in the user's cache folder, else below the temporary folder, where anybody may have
    made one before: there each folder on the way must be the user's own. None without either.
    """
    name, own = f"kernels-{source_key()}", f"cache-{_user_id()}"
    home = os.environ.get("XDG_CACHE_HOME", "")
    if not os.path.isabs(home):  # which the specification says to ignore
        home = os.path.join(os.path.expanduser("~"), ".cache")
    cache, temporary = Path(home, "drysim"), Path(tempfile.gettempdir())
    user_folder = temporary / own
    candidates = (
        (cache, (cache / name,)),
        (temporary, (user_folder, user_folder / "drysim", user_folder / "drysim" / name)),
    )
    for parent, folders in candidates:
        try:
            if not parent.is_absolute():
                continue
            parent.mkdir(parents=True, exist_ok=True, mode=0o700)
            for folder in folders:
                folder.mkdir(exist_ok=True, mode=0o700)
        except OSError:
            continue
        if all(map(_is_private, folders)) and os.access(folders[-1], os.W_OK):
            return folders[-1]
    return None


def _is_private(folder: Path) -> bool:
    """Return whether a folder, no link, is the user's own, and nobody else may write there."""
    about = folder.lstat()
    if not stat.S_ISDIR(about.st_mode) or about.st_uid != _user_id():
        return False
    return not hasattr(os, "getuid") or not about.st_mode & (stat.S_IWGRP | stat.S_IWOTH)


def _user_id() -> int:
    """Return the number of the user; 0 where the system knows none."""
    return os.getuid() if hasattr(os, "getuid") else 0


def source_key() -> str:
    """Return a short name that changes with any line of the core, Python and numba."""
    numba = import_numba()
    words = f"{sys.version}{numba.__version__}{source_digest()}"
    return hashlib.sha256(words.encode()).hexdigest()[:16]


def source_digest() -> str:
    """Return the SHA-256 of the core's source (hex): what makes two tables of numbers alike."""
    digest = hashlib.sha256()
    for file in sorted(Path(__file__).parent.rglob("*.py")):
        digest.update(file.read_bytes())
    return digest.hexdigest()
