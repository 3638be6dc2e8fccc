"""Kinds of bodies from libraries of one's own."""

from __future__ import annotations

import ctypes
import os

from . import _core


def load_plugin(path: str | os.PathLike[str]) -> None:
    """Loads a library with kinds of bodies written in C++ (docs/bodies/your_own.md); World.add and load know them from
    then on. It must have been built with the compiler and the version of brim of this module.
    @raises InputError"""
    # The plugin takes all of brim from this module, whose names Python keeps to itself until they are asked for.
    ctypes.CDLL(_core.__file__, mode=os.RTLD_NOW | os.RTLD_GLOBAL | os.RTLD_NOLOAD)
    try:
        _core.load_plugin(os.path.abspath(path))
    except _core.InputError as error:
        raise _core.InputError(f"load_plugin: {error}") from None
