"""Files that a rig file names, such as tables: their names count from its folder, so they change when it is written elsewhere."""

from __future__ import annotations

import os
import tomllib
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any


def absolute(text: str, folder: Path) -> str:
    """A rig file of this folder as one that may lie anywhere."""
    return _renamed(text, lambda name: os.path.normpath(os.path.join(os.path.realpath(folder), name)))


def relative(text: str, folder: Path) -> str:
    """A rig file with absolute names as one that lies in this folder; what is on another drive keeps its name."""

    def name_from_there(name: str) -> str:
        try:
            return os.path.relpath(name, os.path.realpath(folder)).replace(os.sep, "/") if os.path.isabs(name) else name
        except ValueError:
            return name

    return _renamed(text, name_from_there)


def _renamed(text: str, rename: Callable[[str], str]) -> str:
    try:
        data = tomllib.loads(text)
    except (tomllib.TOMLDecodeError, RecursionError):
        # What is wrong with it, the command says.
        return text
    for name in dict.fromkeys(_names(data)):
        new = rename(name).replace("\\", "\\\\")
        # A name of a file stands between quotes, and nothing else of that text does.
        for quote in ('"', "'"):
            text = text.replace(f"{quote}{name}{quote}", f"{quote}{new}{quote}")
    return text


def _names(data: Mapping[str, Any]) -> Iterator[str]:
    """Names of the files: those that are included, and tables of components of its own."""
    include = data.get("include", [])
    yield from (name for name in ([include] if isinstance(include, str) else include) if isinstance(name, str))
    own = data.get("own_components", {})
    for kind in own.values() if isinstance(own, Mapping) else []:
        tables = kind.get("tables", {}) if isinstance(kind, Mapping) else {}
        for table in tables.values() if isinstance(tables, Mapping) else []:
            file = table.get("file") if isinstance(table, Mapping) else table
            if isinstance(file, str):
                yield file
