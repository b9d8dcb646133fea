"""Engine of the core: kernels compiled by numba or run as plain Python, and their cache.

The kernels have one source and two engines. The engine is chosen once, before the first kernel
is imported: compiled in a Python session, which may solve anything next, and by the size of its
only job in a command (`auto`).

Compiled kernels are cached on disk in the user's cache folder, under a key made of the core's
source, Python and numba versions, so a cached kernel is never stale. A power loss may truncate
a cached file or fill its end with zeros. Numba would fail on the first in every process and
execute the second. Each file is therefore stored with its checksum, which is verified before
unpickling; a damaged file counts as missing and is compiled again. A full disk is not an error.
"""

from __future__ import annotations

import contextlib
import hashlib
import os
import pickle
import stat
import sys
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any, TypeVar, cast

from drysim.errors import DrysimError

Kernel = TypeVar("Kernel", bound=Callable[..., Any])

ENGINE_VARIABLE = "DRYSIM_ENGINE"

PLAIN, COMPILED, AUTO = "plain", "compiled", "auto"

MAX_PLAIN_STEPS = 200_000
"""Most steps for which plain Python (2 µs per step) is faster than loading the compiler."""

COLD_CACHE_FACTOR = 10
"""Multiple of `MAX_PLAIN_STEPS` that justifies compiling kernels not yet cached: 20 s, once."""

ZERO = 0
"""A number that kernels pass to others as `int(ZERO)`: numba compiles a kernel once more for
each literal integer among its arguments."""

CHECKSUM_BYTES = 32
"""Length of the SHA-256 checksum at the start of a cached file."""


# The kernels.


def compiled(function: Kernel) -> Kernel:
    """Compile a kernel with numba and cache it on disk; unchanged in the plain engine.

    A kernel must not allocate: arrays come from the caller and are not reference-counted, which
    would cost more than a step per call. A kernel for small scenes takes few arguments and no
    tuples, because numba unboxes every argument at each call, tuples most slowly.
    """
    return function if is_plain() else jit(function, forceinline=False)


def inlined(function: Kernel) -> Kernel:
    """Compile a kernel like `compiled`, inlined into its callers: for hot loops."""
    return function if is_plain() else jit(function, forceinline=True)


def merged(function: Kernel) -> Kernel:
    """Compile a kernel as part of the only kernel that calls it: for the outer loops.

    Numba optimises and emits all that a kernel calls once more with the kernel. Each level of
    calls above a large kernel would double the time that it takes to compile.
    """
    return function if is_plain() else jit(function, inline="always")


def jit(function: Kernel, **options: Any) -> Kernel:
    """Compile a kernel with the cache folder of this source."""
    numba = import_numba()
    make: Any = numba.njit
    # No kernel is called through a C function pointer: omitting that wrapper saves an eighth of
    # the time to compile.
    options |= {"nogil": True, "error_model": "numpy", "_nrt": False, "no_cfunc_wrapper": True}
    kernel = make(**options)(function)
    settings: Any = numba.config
    before, folder = settings.CACHE_DIR, cache_folder()
    if folder is not None:
        settings.CACHE_DIR = str(folder)
        try:
            kernel._cache = checked_cache_class()(kernel.py_func)
        finally:
            settings.CACHE_DIR = before
    return cast(Kernel, kernel)


def import_numba() -> Any:
    """Import and return numba.

    Raises
    ------
    DrysimError
        If numba cannot be loaded, for lack of a file or of memory.
    """
    try:
        import numba
    except (ImportError, OSError) as fault:
        reason, *_ = str(fault).partition(". ")
        raise DrysimError(
            f"the compiler (numba) cannot be loaded: {reason}",
            "it needs about 0.5 GB of address space (see ulimit -v); "
            f"{ENGINE_VARIABLE}={PLAIN} runs without it, more slowly",
        ) from fault
    return numba


def is_compiling() -> bool:
    """Return whether a kernel is being compiled now, which must not be interrupted."""
    lock = sys.modules.get("numba.core.compiler_lock")
    return lock is not None and bool(lock.global_compiler_lock.is_locked())


def as_engine_array(values: Any) -> Any:
    """Return an array in the fastest form for the engine: plain Python indexes lists."""
    return values.tolist() if is_plain() and hasattr(values, "tolist") else values


# The engine.


def engine() -> str:
    """Return the requested engine: `plain` or `compiled`.

    Raises
    ------
    ValueError
        If the environment variable DRYSIM_ENGINE has another value.
    """
    word = os.environ.get(ENGINE_VARIABLE, COMPILED)
    if word not in (PLAIN, COMPILED, AUTO):
        raise ValueError(
            f"{ENGINE_VARIABLE} must be {PLAIN}, {COMPILED} or {AUTO}, not {word!r}"
        )
    return COMPILED if word == AUTO else word


@cache
def is_plain() -> bool:
    """Return whether the kernels are plain; the first call fixes the answer for the process."""
    return engine() == PLAIN


def choose_engine(steps: int, kernels: str = "") -> None:
    """Choose the engine for `auto` from the size of a job; no effect once kernels are loaded.

    Only a command sets `auto`: it has one job.

    Parameters
    ----------
    steps : int
        Work in steps of sampled motion with Coulomb friction.
    kernels : str
        Kernels specific to the job as `module.function`, separated by blanks; one of them
        suffices.
    """
    loaded = "drysim.core.oscillator" in sys.modules
    if loaded or os.environ.get(ENGINE_VARIABLE) != AUTO:
        return
    plain = steps <= MAX_PLAIN_STEPS or (
        steps <= COLD_CACHE_FACTOR * MAX_PLAIN_STEPS and not is_cached(kernels)
    )
    os.environ[ENGINE_VARIABLE] = PLAIN if plain else COMPILED


def is_cached(kernels: str) -> bool:
    """Return whether one of these kernels, named as in `choose_engine`, is on disk."""
    folder = cache_folder()
    return not kernels or any(
        folder is not None and any(folder.glob(f"*/{name}-*.nbi")) for name in kernels.split()
    )


# The cache.


@cache
def checked_cache_class() -> Any:
    """Return a numba cache class that verifies checksums and ignores damaged files.

    The folder is the one set in numba's configuration, see `cache_folder`.
    """
    from numba.core.caching import FunctionCache, IndexDataCacheFile

    class ChecksummedIndex(IndexDataCacheFile):
        """Index and kernels of a function, in files with a checksum."""

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
                raise ValueError("checksum of a cached kernel does not match")
            return pickle.loads(words)

        def _write(self, path: str, data: Any) -> None:
            words = self._dump(data)
            with self._open_for_write(path) as stream:
                stream.write(hashlib.sha256(words).digest() + words)

    class CheckedCache(FunctionCache):
        """Cache of the kernels of one function."""

        def __init__(self, py_func: Any) -> None:
            super().__init__(py_func)
            stamp = self._impl.locator.get_source_stamp()
            self._cache_file = ChecksummedIndex(
                self._cache_path, self._impl.filename_base, stamp
            )

        def load_overload(self, sig: Any, target_context: Any) -> Any:
            """Return a kernel, or None if there is no undamaged one."""
            try:
                return super().load_overload(sig, target_context)
            except Exception:  # a file of another machine may raise anything
                with contextlib.suppress(OSError):
                    self.flush()
                return None

        def save_overload(self, sig: Any, data: Any) -> None:
            """Save a kernel if the disk has room for it."""
            with contextlib.suppress(OSError):
                super().save_overload(sig, data)

    return CheckedCache


@cache
def cache_folder() -> Path | None:
    """Return a folder for the kernels of this source that only the user may write, or None.

    It lies in the user's cache folder, else below the temporary folder. As anybody may create
    folders there, each folder on that path must be owned by the user.
    """
    import tempfile

    name, own = f"kernels-{source_key()}", f"cache-{_user_id()}"
    home = os.environ.get("XDG_CACHE_HOME", "")
    if not os.path.isabs(home):  # relative: to be ignored by the XDG specification
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
    """Return whether a path is a folder, not a link, that only the user owns and may write."""
    about = folder.lstat()
    if not stat.S_ISDIR(about.st_mode) or about.st_uid != _user_id():
        return False
    return not hasattr(os, "getuid") or not about.st_mode & (stat.S_IWGRP | stat.S_IWOTH)


def _user_id() -> int:
    """Return the user ID; 0 where the system has none."""
    return os.getuid() if hasattr(os, "getuid") else 0


def source_key() -> str:
    """Return a short key that changes with the core's source, Python and numba."""
    numba = import_numba()
    words = f"{sys.version}{numba.__version__}{source_digest()}"
    return hashlib.sha256(words.encode()).hexdigest()[:16]


def source_digest() -> str:
    """Return the SHA-256 of the core's source (hex), which identifies the numerical results."""
    digest = hashlib.sha256()
    for file in sorted(Path(__file__).parent.rglob("*.py")):
        digest.update(file.read_bytes())
    return digest.hexdigest()
