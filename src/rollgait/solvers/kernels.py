"""Functions compiled to machine code: once, by whatever compiler is there, kept on disk.

A kernel is kept under what it is known by (its C text, or the key of the stage code that it is made of: mass,
inertia, limits and the intervals are parameters), the compiler and the flags. Without a compiler, or without
a
place to write to, the uncompiled functions serve: slower, never wrong.
"""

from __future__ import annotations

import hashlib
import logging
import os
import platform
import shlex
import shutil
import subprocess
import tempfile
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import TypeVar

import casadi as ca

from rollgait.errors import FileError
from rollgait.solvers.cache_folder import OWNER_ONLY, cache_folder, is_private_file, private_folder

log = logging.getLogger("rollgait")

CODE_SUFFIX = ".code.npz"
"""Ending of the files of stage codes, which lie beside the kernels (`code_store.py`)."""
COMPILERS = ("cc", "gcc", "clang")
FOR_THIS_PROCESSOR = "-march=native"
"""Flag of the compiler on x86-64; elsewhere not every compiler knows it."""
SPECIFIC = (FOR_THIS_PROCESSOR,) if platform.machine() in ("x86_64", "AMD64") else ()
FLAGS = ("-O1", *SPECIFIC, "-fPIC", "-shared")
"""-O2 evaluates Hessians in four fifths of the time, and takes six times as long to compile."""
COMPILE_TIMEOUT = 300.0
"""s after which the compiler is given up."""
LOAD_ERRORS = (RuntimeError, OSError, AttributeError)
"""What CasADi and ctypes raise for a library that is none, or lacks a function."""

Loaded = TypeVar("Loaded")


@dataclass(frozen=True)
class CachedKernel:
    """A compiled kernel on disk: its file, its size in bytes, when it was built (s since 1970)."""

    path: Path
    size: int
    built: float


def cached_kernels() -> list[CachedKernel]:
    """The kernels on disk, newest first. Raises `FileError` if the folder cannot be trusted."""
    folder = cache_folder()
    place = None if folder is None else private_folder(folder)
    kernels = []
    for path in [] if place is None else place.glob("*.so"):
        with suppress(FileNotFoundError):  # another process clears the cache
            if is_private_file(path):
                found = path.lstat()
                kernels.append(CachedKernel(path, found.st_size, found.st_mtime))
    return sorted(kernels, key=lambda kernel: -kernel.built)


def clear_cache() -> int:
    """Removes all kernels; returns how many there were. Raises `FileError` if they cannot be removed."""
    kernels = cached_kernels()
    files = [file for kernel in kernels for file in (kernel.path, _digest_file(kernel.path))]
    folder = cache_folder()
    place = None if folder is None else private_folder(folder)
    files += [] if place is None else place.glob(f"*{CODE_SUFFIX}")
    for file in files:
        try:
            file.unlink(missing_ok=True)
        except OSError as error:
            raise FileError("kernel", str(file), f"cannot be removed: {error.strerror}") from None
    return len(kernels)


def compiled(
    functions: Callable[[], Sequence[ca.Function]], names: Sequence[str], known_by: str
) -> list[ca.Function] | None:
    """Functions as machine code, or None where that cannot be had (which is logged once).

    Args:
        functions: makes them, if they have to be compiled.
        names: of the functions.
        known_by: tells them from all others with the same names.
    """

    def text() -> str:
        generator = ca.CodeGenerator("kernel.c")
        for function in functions():
            generator.add(function)
        return str(generator.dump())

    def load(library: Path) -> list[ca.Function]:
        return [ca.external(name, str(library)) for name in names]

    return machine_code(text, known_by, FLAGS, load)


def machine_code(
    text: Callable[[], str], known_by: str, flags: Sequence[str], load: Callable[[Path], Loaded]
) -> Loaded | None:
    """What `load` makes of the shared library of a C text, which is cached or built now.

    A cached library that cannot be loaded is built again, once.

    Args:
        text: makes the C source, the whole of it, if it has to be compiled.
        known_by: tells it from all others.
        flags: of the compiler.
        load: loads the library; what it raises (`LOAD_ERRORS`) says that this cannot be done.

    Returns:
        None where it cannot be had, which is logged.
    """
    folder = cache_folder()
    if folder is None:
        return None
    compiler = _compiler()
    if compiler is None:
        say_once("no C compiler found: planning without compiled kernels")
        return None
    try:
        place = private_folder(folder, create=True)
    except FileError as error:
        say_once(f"{error}: planning without compiled kernels")
        return None
    assert place is not None
    library = place / f"{_key(known_by, compiler, flags)}.so"
    if _is_sound(library):
        with suppress(*LOAD_ERRORS):
            return load(library)
    if not _build(text(), compiler, flags, library):
        return None
    try:
        return load(library)
    except LOAD_ERRORS as error:
        say_once(f"a compiled kernel cannot be loaded ({str(error).splitlines()[-1]}): planning without")
        return None


@lru_cache
def say_once(line: str) -> None:
    """Logs a line, but not again in this process: a plan may ask for several kernels."""
    log.info(line)


def _compiler() -> list[str] | None:
    """The command that compiles: a path first, and what else CC says, as in `ccache gcc`."""
    asked = os.environ.get("CC")
    for name in [asked] if asked else COMPILERS:
        try:
            for command in ([name], shlex.split(name)):  # a path may have a space in it
                if command and (found := shutil.which(command[0])):
                    return [found, *command[1:]]
        except ValueError:  # a quote that does not end
            continue
    return None


def _key(known_by: str, compiler: Sequence[str], flags: Sequence[str]) -> str:
    programs = [Path(found).resolve().stat() for word in compiler if (found := shutil.which(word))]
    versions = [f"{stat.st_size} {stat.st_mtime_ns}" for stat in programs]
    made_by = (*compiler, *versions, *flags, ca.CasadiMeta.version())
    made_for = (platform.machine(), _processor() if FOR_THIS_PROCESSOR in flags else "")
    return hashlib.sha256("\0".join((known_by, *made_by, *made_for)).encode()).hexdigest()[:32]


def _processor() -> str:
    """What this processor can do: a home directory may be shared by machines that differ."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="ascii", errors="replace").splitlines()
    except OSError:
        return platform.processor()
    return next((line for line in lines if line.startswith(("flags", "Features"))), platform.processor())


def _digest_file(library: Path) -> Path:
    return library.with_suffix(".sha256")


def _digest(library: Path) -> str:
    return hashlib.sha256(library.read_bytes()).hexdigest()


def _is_sound(library: Path) -> bool:
    """Whether the file is the one that was built: loading a damaged library would crash the process."""
    digest = _digest_file(library)
    try:
        if not (is_private_file(library) and is_private_file(digest)):
            return False
        return digest.read_text(encoding="ascii").strip() == _digest(library)
    except (OSError, UnicodeDecodeError):
        return False


def _build(text: str, compiler: Sequence[str], flags: Sequence[str], library: Path) -> bool:
    """Compiles and puts the library in its place; two processes may do so at once."""
    try:
        with tempfile.TemporaryDirectory(dir=library.parent, prefix=".build-") as folder:
            source, target = Path(folder) / "kernel.c", Path(folder) / "kernel.so"
            source.write_text(text, encoding="utf-8")
            say_once("compiling kernels (once for this kind of problem)")
            subprocess.run(
                [*compiler, *flags, str(source), "-o", str(target), "-lm"],
                check=True,
                stdin=subprocess.DEVNULL,
                capture_output=True,
                timeout=COMPILE_TIMEOUT,
            )
            digest = Path(folder) / "digest"
            digest.write_text(_digest(target), encoding="ascii")
            for made in (target, digest):
                made.chmod(OWNER_ONLY)  # whatever the umask
            # the same text gives the same library, whoever comes last; a mismatch in between is rebuilt
            target.replace(library)
            digest.replace(_digest_file(library))
    except (OSError, subprocess.SubprocessError) as error:
        reason = error.strerror if isinstance(error, OSError) else "the compiler failed"
        say_once(f"kernels cannot be compiled ({reason}): planning without")
        return False
    return _is_sound(library)
