"""Packages whose names are imported when they are first asked for (PEP 562)."""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping
from importlib import import_module
from typing import Any


def lazy_names(
    package: str, homes: Mapping[str, str]
) -> tuple[Callable[[str], Any], Callable[[], list[str]]]:
    """The functions `__getattr__` and `__dir__` of a package whose names live in modules below it.

    A sub-package of the same name as one of them is imported now and its attribute removed: only its first
    import sets that, so from here on the attribute is what `homes` says, whatever is imported when.

    Args:
        package: its `__name__`.
        homes: the module of each name, relative to the package.
    """
    namespace = vars(sys.modules[package])
    for name in homes.keys() & {module.partition(".")[0] for module in homes.values()}:
        import_module(f"{package}.{name}")
        del namespace[name]

    def get(name: str) -> Any:
        if name not in homes:
            raise AttributeError(f"module {package!r} has no attribute {name!r}", name=name)
        value = namespace[name] = getattr(import_module(f"{package}.{homes[name]}"), name)
        return value

    def names() -> list[str]:
        return sorted({*namespace, *homes})

    return get, names
