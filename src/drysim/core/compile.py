"""Engine of the core: kernels compiled by numba or run as plain Python, and their cache.

The kernels have one source and two engines. A command has one job: its size chooses the engine
once (`auto`), before the first kernel is imported. A Python session, which may solve anything
next, is plain until its jobs have as much work as compiling costs, and compiled from then on.

Numba optimises and emits every function that a kernel calls, as a program of its own and again
in each caller, and gives each an interface to Python. Here a kernel that another one calls is
kept as unoptimised code, which is linked once into each kernel that Python calls.

These kernels are cached on disk in the user's cache folder, under a key made of the core's
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
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cache, update_wrapper
from pathlib import Path
from threading import Lock
from types import FunctionType
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
    return kernel_of(function, forceinline=False)


def inlined(function: Kernel) -> Kernel:
    """Compile a kernel like `compiled`, inlined into its callers: for hot loops."""
    return kernel_of(function, forceinline=True)


def merged(function: Kernel) -> Kernel:
    """Compile a kernel as part of the only kernel that calls it: for the outer loops."""
    return kernel_of(function, inline="always")


def summed(function: Kernel) -> Kernel:
    """Compile a kernel whose sums and maxima are formed in any order, several at a time.

    Nothing else in it may depend on the order: differences are formed in kernels it calls.
    """
    fastmath = {"nnan", "nsz", "reassoc"}
    return kernel_of(function, forceinline=False, fastmath=fastmath)


def by_engine(plain: Kernel, compiled: Kernel) -> Kernel:
    """Return the kernel that is one function in plain Python and another one compiled."""
    if is_session():
        return cast(Kernel, SessionKernel(compiled, {}, plain))
    return plain if is_plain() else compiled


def python_of(kernel: Any) -> Any:
    """Return a kernel as plain Python, for a few calls that are not worth to compile it."""
    if isinstance(kernel, SessionKernel):
        return kernel.plain
    return getattr(kernel, "py_func", kernel)


def kernel_of(function: Kernel, **options: Any) -> Kernel:
    """Return a function as a kernel that is compiled with some options of numba."""
    if is_session():
        return cast(Kernel, SessionKernel(function, options))
    return function if is_plain() else cast(Kernel, CompiledKernel(function, options))


class CompiledKernel:
    """Kernel that numba wraps when it is first called, from Python or by another kernel.

    A command calls few of the many: of those that only their code in the cache calls, numba
    needs to know nothing.
    """

    def __init__(self, function: Any, options: dict[str, Any]) -> None:
        update_wrapper(self, function)
        self.function, self.options = function, options
        self.dispatcher: Any = None
        self.lock = Lock()

    def __call__(self, *args: Any) -> Any:
        """Run the kernel."""
        return (self.dispatcher or self.compiled)(*args)

    @property
    def compiled(self) -> Any:
        """The kernel as numba calls it, one for all threads."""
        if self.dispatcher is None:
            with self.lock:
                self.dispatcher = self.dispatcher or jit(self.function, **self.options)
        return self.dispatcher

    @property
    def _numba_type_(self) -> Any:
        """What numba takes the kernel for, where another one calls it."""
        return self.compiled._numba_type_

    @property
    def py_func(self) -> Any:
        """Source of the kernel, for numba, which inlines it if `targetoptions` asks for it."""
        return self.function

    @property
    def targetoptions(self) -> Any:
        """Options with which numba compiles the kernel."""
        return self.compiled.targetoptions


class SessionKernel(CompiledKernel):
    """Kernel of a Python session, plain or compiled as `SESSION` says.

    A call whose arrays are lists is plain: it belongs to a result of an earlier, plain job.
    """

    def __init__(self, function: Any, options: dict[str, Any], plain: Any = None) -> None:
        super().__init__(function, options)
        self.python = plain or function
        self.bound: Any = None

    def __call__(self, *args: Any) -> Any:
        """Run the kernel."""
        is_plain_call = SESSION.engine == PLAIN or has_list(args)
        return self.plain(*args) if is_plain_call else self.compiled(*args)

    @property
    def plain(self) -> Any:
        """The kernel as a function that calls only plain kernels, and directly."""
        if self.bound is None:
            code, name = self.python.__code__, self.python.__name__
            names = plain_names(self.python.__globals__)
            self.bound = FunctionType(code, names, name, self.python.__defaults__)
        return self.bound

    @property
    def compiled(self) -> Any:
        """The kernel as compiled by numba, once for all threads."""
        if isinstance(self.function, SessionKernel):
            return self.function.compiled
        return super().compiled


PLAIN_NAMES: dict[int, dict[str, Any]] = {}
"""What `plain_names` returned, by the identity of the module's names."""


def plain_names(module: dict[str, Any]) -> dict[str, Any]:
    """Return the names of a module, those of its kernels for their plain functions."""
    if id(module) not in PLAIN_NAMES:
        names = PLAIN_NAMES[id(module)] = dict(module)
        for name, value in module.items():
            if isinstance(value, SessionKernel):
                names[name] = value.plain
    return PLAIN_NAMES[id(module)]


def has_list(values: tuple[Any, ...]) -> bool:
    """Return whether a list is among these values and the named tuples among them."""
    for value in values:
        if isinstance(value, list) or (isinstance(value, tuple) and has_list(value)):
            return True
    return False


def jit(function: Kernel, **options: Any) -> Kernel:
    """Compile a kernel and keep it in the cache folder of this source."""
    numba = import_numba()
    make: Any = numba.njit
    # No kernel is called through a C function pointer: omitting that wrapper saves an eighth of
    # the time to compile.
    options |= {"nogil": True, "error_model": "numpy", "_nrt": False, "no_cfunc_wrapper": True}
    kernel = make(**options)(function)
    options |= {"no_cpython_wrapper": True, "pipeline_class": linked_compiler()}
    linked = make(**options)(function)
    # What a kernel asks of another one that it calls: the types and the code of its result.
    kernel.get_call_template = linked.get_call_template
    kernel.get_overload = linked.get_overload
    kernel._cache = kernel_cache_class()(function, cache_folder())
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


BEFORE_COMPILING: list[Callable[[], None]] = []
"""What is called before the first kernel is compiled, and then removed."""


def before_compiling(announce: Callable[[], None]) -> None:
    """Have a function called once, if a kernel has to be compiled because none is cached."""
    BEFORE_COMPILING[:] = [announce]


def is_compiling() -> bool:
    """Return whether a kernel is being compiled now, which must not be interrupted."""
    lock = sys.modules.get("numba.core.compiler_lock")
    return lock is not None and bool(lock.global_compiler_lock.is_locked())


def as_engine_array(values: Any) -> Any:
    """Return an array in the fastest form for the engine: plain Python indexes lists."""
    return values.tolist() if is_plain() and hasattr(values, "tolist") else values


# The engine.


@dataclass
class Session:
    """Engine of a Python session: plain until it has much to do, then compiled for good.

    The results of compiled jobs may be large, and are evaluated by compiled kernels.
    """

    engine: str = PLAIN
    steps: Counter[str] = field(default_factory=Counter)
    """Work of the plain jobs, by the kernels specific to them."""

    def choose(self, steps: int, kernels: str) -> None:
        """Choose the engine for a job; arguments as in `choose_engine`."""
        self.steps[kernels] += steps
        if self.engine == PLAIN and not is_plain_cheaper(self.steps[kernels], kernels):
            self.engine = PLAIN if is_disabled() else COMPILED


SESSION = Session()


@cache
def is_session() -> bool:
    """Return whether `SESSION` has the engine; the first call fixes the answer."""
    return ENGINE_VARIABLE not in os.environ


def engine() -> str:
    """Return the engine in use: `plain` or `compiled`; plain where numba is disabled.

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
    if is_session():
        return SESSION.engine
    disabled = getattr(sys.modules.get("numba.core.config"), "DISABLE_JIT", 0)
    return PLAIN if word == PLAIN or disabled else COMPILED


def is_disabled() -> bool:
    """Return whether the user has switched numba off."""
    return bool(import_numba().config.DISABLE_JIT)


def is_plain() -> bool:
    """Return whether kernels are plain: for good, unless in a Python session."""
    return SESSION.engine == PLAIN if is_session() else is_always_plain()


@cache
def is_always_plain() -> bool:
    """Return whether the kernels are plain; the first call fixes the answer."""
    if engine() == COMPILED:
        import_numba()  # whose settings decide
    return engine() == PLAIN


def choose_engine(steps: int, kernels: str = "") -> None:
    """Choose the engine for a job by its size, in a Python session and for `auto`.

    Only a command sets `auto`: it has one job. The choice has no effect once it has loaded
    kernels.

    Parameters
    ----------
    steps : int
        Work in steps of sampled motion with Coulomb friction.
    kernels : str
        Kernels specific to the job as `module.function`, separated by blanks; one of them
        suffices.
    """
    if is_session():
        SESSION.choose(steps, kernels)
        return
    loaded = "drysim.core.oscillator" in sys.modules
    if loaded or os.environ.get(ENGINE_VARIABLE) != AUTO:
        return
    plain = is_plain_cheaper(steps, kernels)
    os.environ[ENGINE_VARIABLE] = PLAIN if plain else COMPILED


def is_plain_cheaper(steps: int, kernels: str) -> bool:
    """Return whether to solve steps in plain Python costs less than to load the compiler."""
    return steps <= MAX_PLAIN_STEPS or (
        steps <= COLD_CACHE_FACTOR * MAX_PLAIN_STEPS and not is_cached(kernels)
    )


def is_cached(kernels: str) -> bool:
    """Return whether one of these kernels, named as in `choose_engine`, is on disk."""
    folder = cache_folder()
    return not kernels or any(
        folder is not None and any(folder.path.glob(f"{name}-*.nbc"))
        for name in kernels.split()
    )


# Kernels that other kernels call.


@cache
def linked_compiler() -> Any:
    """Return a numba compiler of functions that are only linked into others."""
    from numba.core.codegen import JITCodeLibrary
    from numba.core.compiler import Compiler
    from numba.core.compiler_machinery import AnalysisPass, register_pass
    from numba.core.typed_passes import IRLegalization

    class LinkedLibrary(JITCodeLibrary):
        """Code of a function and, to be linked with it, of all functions that it calls."""

        def __init__(self, codegen: Any, name: str) -> None:
            super().__init__(codegen, name)
            self.callees: dict[Any, None] = {}
            self.program: Any = None

        def add_linking_library(self, library: Any) -> None:
            """Add the code of a function that this one calls."""
            library._ensure_finalized()
            # A linker keeps a function only if one that came before it calls it.
            self.callees |= dict.fromkeys((library, *getattr(library, "callees", ())))

        def _optimize_functions(self, ll_module: Any) -> None:
            """Leave the code as it is, for the processor."""
            ll_module.data_layout = self._codegen._data_layout

        def finalize(self) -> None:
            """Neither optimise nor emit the code."""
            self._finalized = True

        def own_code(self) -> Any:
            """Return the code of this function alone."""
            return super()._get_module_for_linking()

        def _get_module_for_linking(self) -> Any:
            """Return the code of this function and of all that it calls."""
            if self.program is None:
                self.program = self.own_code().clone()
                for callee in self.callees:
                    linked = isinstance(callee, LinkedLibrary)
                    code = callee.own_code() if linked else callee._get_module_for_linking()
                    self.program.link_in(code, preserve=True)
            return self.program

        @property
        def codegen(self) -> LinkedLibrary:
            """Where numba sets the environment of a function that it has emitted."""
            return self

        def set_env(self, name: str, environment: Any) -> None:
            """Do nothing: the environment is set with the one of the caller."""

    @register_pass(mutates_CFG=False, analysis_only=True)
    class UseLinkedLibrary(AnalysisPass):
        """Choose the library that the next pass, lowering, writes to."""

        _name = "use_linked_library"

        def __init__(self) -> None:
            super().__init__()

        def run_pass(self, state: Any) -> bool:
            codegen = state.targetctx.codegen()
            state.library = LinkedLibrary(codegen, state.func_id.func_qualname)
            return True

    class LinkedCompiler(Compiler):
        """The usual passes, into a linked library."""

        def define_pipelines(self) -> Any:
            (passes,) = super().define_pipelines()
            passes.add_pass_after(UseLinkedLibrary, IRLegalization)
            passes.finalize()
            return [passes]

    return LinkedCompiler


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
        """Compiled versions of one function in a private folder, if there is one."""

        def __init__(self, function: Any, folder: PrivateFolder | None) -> None:
            self._function = function
            self._folder = folder

        @property
        def cache_path(self) -> str:
            """Path of the folder."""
            return str(self._folder.path) if self._folder is not None else ""

        def load_overload(self, sig: Any, target_context: Any) -> Any:
            """Return a kernel; None, whereupon numba compiles it, if there is no sound one."""
            kernel = self._read(sig, target_context)
            while kernel is None and BEFORE_COMPILING:
                BEFORE_COMPILING.pop()()
            return kernel

        def _read(self, sig: Any, target_context: Any) -> Any:
            """Return a kernel, or None if there is no undamaged one.

            numba's own cache refreshes the context first: half a second for what only the
            compiler needs, which refreshes it anyway.
            """
            if self._folder is None:
                return None
            try:
                sealed = self._folder.read(self._file(sig, target_context.codegen()))
                return CompileResult._rebuild(target_context, *unseal(sealed))
            except Exception:  # a file of another machine may raise anything
                return None

        def save_overload(self, sig: Any, data: Any) -> None:
            """Complete a kernel that was just compiled; save it if the disk has room for it."""
            for environment in data._find_referenced_environments():
                data.codegen.set_env(environment.env_name, environment)
            if self._folder is None or data.library.has_dynamic_globals:  # addresses
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


def seal(content: bytes) -> bytes:
    """Return bytes with their checksum before them."""
    return hashlib.sha256(content).digest() + content


def unseal(sealed: bytes) -> Any:
    """Unpickle what `seal` returned.

    Raises
    ------
    ValueError
        If the bytes are damaged; they are not unpickled.
    """
    checksum, content = sealed[:CHECKSUM_BYTES], sealed[CHECKSUM_BYTES:]
    if hashlib.sha256(content).digest() != checksum:
        raise ValueError("checksum of a cached kernel does not match")
    return pickle.loads(content)


def cache_folder() -> PrivateFolder | None:
    """Return the folder for the kernels of this source, None if there is no private one."""
    return private_folder(f"kernels-{source_key()}")


@cache
def source_key() -> str:
    """Return a short key that changes with the core's source, Python and numba."""
    numba = import_numba()
    versions = f"{sys.version}{numba.__version__}{source_digest()}"
    return hashlib.sha256(versions.encode()).hexdigest()[:16]


def source_digest(folder: Path = Path(__file__).parent) -> str:
    """Return the SHA-256 of the source in a folder (hex), which identifies what it computes."""
    digest = hashlib.sha256()
    for file in sorted(folder.rglob("*.py")):
        digest.update(file.read_bytes())
    return digest.hexdigest()
