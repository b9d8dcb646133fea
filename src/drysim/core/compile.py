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
import sys
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any, TypeVar, cast

from drysim.errors import DrysimError
from drysim.interrupt import deferred_interrupt
from drysim.system import PrivateFolder, private_folder

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


def summed(function: Kernel) -> Kernel:
    """Compile a kernel whose sums and maxima are formed in any order, several at a time.

    Nothing else in it may depend on the order: differences are formed in kernels it calls.
    """
    fastmath = {"nnan", "nsz", "reassoc"}
    return function if is_plain() else jit(function, forceinline=False, fastmath=fastmath)


def python_of(kernel: Any) -> Any:
    """Return a kernel as plain Python, for a few calls that are not worth to compile it."""
    return getattr(kernel, "py_func", kernel)


def jit(function: Kernel, **options: Any) -> Kernel:
    """Compile a kernel and keep it in the cache folder of this source."""
    numba = import_numba()
    make: Any = numba.njit
    # No kernel is called through a C function pointer: omitting that wrapper saves an eighth of
    # the time to compile.
    options |= {"nogil": True, "error_model": "numpy", "_nrt": False, "no_cfunc_wrapper": True}
    kernel = make(**options)(function)
    if (folder := cache_folder()) is not None:
        kernel._cache = kernel_cache_class()(function, folder)
    return cast(Kernel, kernel)


def import_numba() -> Any:
    """Import and return numba.

    Raises
    ------
    DrysimError
        If numba cannot be loaded, for lack of a file or of memory.
    """
    try:
        with deferred_interrupt():
            import numba
    except (ImportError, OSError) as fault:
        reason, *_ = str(fault).partition(". ")
        raise DrysimError(
            f"the compiler (numba) cannot be loaded: {reason}",
            "it needs about 0.5 GB of address space (see ulimit -v); "
            f"{ENGINE_VARIABLE}={PLAIN} runs without it, more slowly",
        ) from fault
    except Exception as fault:  # numba reads its settings when it is imported
        reason = " ".join(str(fault).split())
        raise DrysimError(
            f"the compiler (numba) cannot be loaded: {type(fault).__name__}: {reason}",
            "remove .numba_config.yaml from this folder, or unset the variables NUMBA_*; "
            f"{ENGINE_VARIABLE}={PLAIN} runs without it, more slowly",
        ) from fault
    box_named_tuples_without_python()
    return numba


def box_named_tuples_without_python() -> None:
    """Have numba make the named tuples that kernels return without running Python code.

    Numba looks up their class and calls it, both in Python. There a signal that came during the
    kernel, such as Ctrl-C, raises its exception; numba does not look for it and uses the result
    that is missing, which ends the process.
    """
    from numba.core import types
    from numba.core.boxing import box_tuple
    from numba.core.pythonapi import _boxers

    def box_named_tuple(typ: Any, val: Any, c: Any) -> Any:
        values = box_tuple(typ, val, c)
        constants = tuple.__new__, typ.instance_class
        make, kind = (
            c.env_manager.read_const(c.env_manager.add_const(constant))
            for constant in constants
        )
        made = c.pyapi.call_function_objargs(make, (kind, values))
        c.pyapi.decref(values)
        return made

    _boxers.functions[types.NamedTuple] = box_named_tuple
    _boxers.functions[types.NamedUniTuple] = box_named_tuple


def is_compiling() -> bool:
    """Return whether a kernel is being compiled now, which must not be interrupted."""
    lock = sys.modules.get("numba.core.compiler_lock")
    return lock is not None and bool(lock.global_compiler_lock.is_locked())


def as_engine_array(values: Any) -> Any:
    """Return an array in the fastest form for the engine: plain Python indexes lists."""
    return values.tolist() if is_plain() and hasattr(values, "tolist") else values


# The engine.


def engine() -> str:
    """Return the requested engine: `plain` or `compiled`; plain where numba is disabled.

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
    # A numba that the user has switched off cannot compile.
    disabled = getattr(sys.modules.get("numba.core.config"), "DISABLE_JIT", 0)
    return PLAIN if word == PLAIN or disabled else COMPILED


@cache
def is_plain() -> bool:
    """Return whether the kernels are plain; the first call fixes the answer for the process."""
    if engine() == COMPILED:
        import_numba()  # whose settings decide
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
        folder is not None and any(folder.path.glob(f"{name}-*.nbc"))
        for name in kernels.split()
    )


# The cache.


@cache
def kernel_cache_class() -> Any:
    """Return a numba cache class: one file with a checksum for each kernel and signature.

    numba's own cache reads its files by path and checks nothing. A file that is damaged counts
    as missing.
    """
    from numba.core.caching import _Cache
    from numba.core.compiler import CompileResult
    from numba.core.serialize import dumps

    class KernelCache(_Cache):
        """Compiled versions of one function in a private folder."""

        def __init__(self, function: Any, folder: PrivateFolder) -> None:
            self._function = function
            self._folder = folder

        @property
        def cache_path(self) -> str:
            """Path of the folder."""
            return str(self._folder.path)

        def load_overload(self, sig: Any, target_context: Any) -> Any:
            """Return a kernel, or None if there is no undamaged one."""
            target_context.refresh()
            try:
                sealed = self._folder.read(self._file(sig, target_context.codegen()))
                return CompileResult._rebuild(target_context, *unseal(sealed))
            except Exception:  # a file of another machine may raise anything
                return None

        def save_overload(self, sig: Any, data: Any) -> None:
            """Save a kernel if the disk has room for it."""
            if data.library.has_dynamic_globals:  # addresses of this process
                return
            with contextlib.suppress(OSError):
                sealed = seal(dumps(data._reduce()))
                self._folder.write(self._file(sig, data.codegen), sealed)

        def _file(self, sig: Any, codegen: Any) -> str:
            """Return the name of the file of a signature on a processor."""
            key = repr((sig, codegen.magic_tuple())).encode()
            return f"{kernel_name(self._function)}-{hashlib.sha256(key).hexdigest()[:16]}.nbc"

        def enable(self) -> None:
            """Do nothing: the cache is always in use."""

        def disable(self) -> None:
            """Do nothing: the cache is always in use."""

        def flush(self) -> None:
            """Do nothing: files are written at once."""

    return KernelCache


def kernel_name(function: Callable[..., Any]) -> str:
    """Return `module.function` of a kernel, without the packages."""
    return f"{function.__module__.rpartition('.')[2]}.{function.__qualname__}"


def seal(words: bytes) -> bytes:
    """Return bytes with their checksum before them."""
    return hashlib.sha256(words).digest() + words


def unseal(sealed: bytes) -> Any:
    """Unpickle what `seal` returned.

    Raises
    ------
    ValueError
        If the bytes are damaged; they are not unpickled.
    """
    checksum, words = sealed[:CHECKSUM_BYTES], sealed[CHECKSUM_BYTES:]
    if hashlib.sha256(words).digest() != checksum:
        raise ValueError("checksum of a cached kernel does not match")
    return pickle.loads(words)


def cache_folder() -> PrivateFolder | None:
    """Return the folder for the kernels of this source, None if there is no private one."""
    return private_folder(f"kernels-{source_key()}")


@cache
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
