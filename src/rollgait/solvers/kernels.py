"""Stage functions compiled to machine code: once, by whatever compiler is there, kept on disk.

Everything that a kernel depends on is in its C text (mass, inertia, limits and the interval are
parameters), so the text, the compiler and the flags are the key under which it is kept. Without a
compiler, or without a place to write to, the uncompiled functions serve: slower, never wrong.
"""

from __future__ import annotations

import hashlib
import logging
import os
import platform
import shutil
import subprocess
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import casadi as ca

log = logging.getLogger("rollgait")

CACHE_VARIABLE = "ROLLGAIT_CACHE"
"""Environment variable that names the folder of the cache, or `off`."""
COMPILERS = ("cc", "gcc", "clang")
FLAGS = ("-O1", "-fPIC", "-shared")
"""-O2 takes twice as long to compile and gains nothing that shows."""
FOR_THIS_PROCESSOR = "-march=native"
COMPILE_TIMEOUT = 300.0
"""s after which the compiler is given up."""


@dataclass(frozen=True)
class CachedKernel:
    """A compiled kernel on disk: its file, its size in bytes, when it was built (s since 1970)."""

    path: Path
    size: int
    built: float


def cache_folder() -> Path | None:
    """Where kernels are kept; None if the cache is switched off."""
    asked = os.environ.get(CACHE_VARIABLE)
    if asked == "off":
        return None
    if asked:
        return Path(asked)
    base = os.environ.get("XDG_CACHE_HOME")
    return (Path(base) if base else Path.home() / ".cache") / "rollgait"


def cached_kernels() -> list[CachedKernel]:
    """The kernels on disk, newest first."""
    folder = cache_folder()
    if folder is None or not folder.is_dir():
        return []
    found = [(path, path.stat()) for path in folder.glob("*.so")]
    kernels = [CachedKernel(path, stat.st_size, stat.st_mtime) for path, stat in found]
    return sorted(kernels, key=lambda kernel: -kernel.built)


def clear_cache() -> int:
    """Removes all kernels; returns how many there were."""
    kernels = cached_kernels()
    for kernel in kernels:
        kernel.path.unlink(missing_ok=True)
        _digest_file(kernel.path).unlink(missing_ok=True)
    return len(kernels)


def compiled(functions: Sequence[ca.Function]) -> list[ca.Function] | None:
    """The same functions as machine code, or None where that cannot be had (which is logged once)."""
    generator = ca.CodeGenerator("kernel.c")
    for function in functions:
        generator.add(function)
    library = machine_code(generator.dump(), FLAGS)
    if library is None:
        return None
    try:
        return [ca.external(function.name(), str(library)) for function in functions]
    except RuntimeError as error:
        _say_once(f"a compiled kernel cannot be loaded ({str(error).splitlines()[-1]}): planning without")
        return None


def machine_code(text: str, flags: Sequence[str]) -> Path | None:
    """A shared library made from C text, cached or built now; None where it cannot be had (logged)."""
    folder, compiler = cache_folder(), _compiler()
    if folder is None:
        return None
    if compiler is None:
        _say_once("no C compiler found: planning without compiled kernels")
        return None
    library = folder / f"{_key(text, compiler, flags)}.so"
    return library if _is_sound(library) or _build(text, compiler, flags, library) else None


@lru_cache
def _say_once(line: str) -> None:
    """Logs a line, but not again in this process: a plan may ask for several kernels."""
    log.info(line)


def _compiler() -> str | None:
    asked = os.environ.get("CC")
    return next((found for name in ([asked] if asked else COMPILERS) if (found := shutil.which(name))), None)


def _key(text: str, compiler: str, flags: Sequence[str]) -> str:
    stat = Path(compiler).resolve().stat()
    made_by = (compiler, str(stat.st_size), str(stat.st_mtime_ns), *flags, ca.CasadiMeta.version())
    made_for = (platform.machine(), _processor() if FOR_THIS_PROCESSOR in flags else "")
    return hashlib.sha256("\0".join((text, *made_by, *made_for)).encode()).hexdigest()[:32]


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
    try:
        return _digest_file(library).read_text(encoding="ascii").strip() == _digest(library)
    except (OSError, UnicodeDecodeError):
        return False


def _build(text: str, compiler: str, flags: Sequence[str], library: Path) -> bool:
    """Compiles and puts the library in its place; two processes may do so at once."""
    try:
        library.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(dir=library.parent, prefix=".build-") as folder:
            source, target = Path(folder) / "kernel.c", Path(folder) / "kernel.so"
            source.write_text(text, encoding="utf-8")
            _say_once("compiling kernels (once for this kind of problem)")
            subprocess.run(
                [compiler, *flags, str(source), "-o", str(target), "-lm"],
                check=True,
                capture_output=True,
                timeout=COMPILE_TIMEOUT,
            )
            digest = Path(folder) / "digest"
            digest.write_text(_digest(target), encoding="ascii")
            # the same text gives the same library, whoever comes last; a mismatch in between is rebuilt
            target.replace(library)
            digest.replace(_digest_file(library))
    except (OSError, subprocess.SubprocessError) as error:
        reason = error.strerror if isinstance(error, OSError) else "the compiler failed"
        _say_once(f"kernels cannot be compiled ({reason}): planning without")
        return False
    return _is_sound(library)
