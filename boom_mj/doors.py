"""A package's door: names that are imported where they are first asked for, so that the package itself is light."""

import sys
from collections.abc import Callable, Mapping, Sequence
from importlib import import_module
from types import ModuleType
from typing import Any


def door(
    package: str, homes: Mapping[str, Sequence[str]]
) -> tuple[Callable[[str], Any], Callable[[], list[str]], list[str]]:
    """`__getattr__`, `__dir__` and `__all__` of a package (PEP 562).

    A name may be that of a module, too: `boom_mj.replay` is the function, whoever has imported the module before.

    Args:
        package: its name.
        homes: names by the module that defines them.
    """
    home_of = {name: home for home, names in homes.items() for name in names}

    class Door(ModuleType):
        def __setattr__(self, name: str, value: Any) -> None:
            if name not in home_of or not isinstance(value, ModuleType):  # importing a module binds its name
                super().__setattr__(name, value)

    sys.modules[package].__class__ = Door

    def get(name: str) -> Any:
        if name not in home_of:
            raise AttributeError(f"{package} has no {name!r}; it has {', '.join(sorted(home_of))}")
        from boom_mj.engine import mujoco as _mujoco  # before anything else imports it  # noqa: F401

        value = getattr(import_module(home_of[name]), name)
        setattr(sys.modules[package], name, value)
        return value

    return get, lambda: sorted(home_of), sorted(home_of)
