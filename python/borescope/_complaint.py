"""What is wrong with what was given, and the one call that everything goes through."""

from __future__ import annotations

import sys
import warnings
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from borescope import _borescope
from borescope._words import in_python

#: Called with the stage, how many pieces of it are done, and of how many (or None).
Listener = Callable[[str, int, "int | None"], object]


class Complaint(ValueError):
    """Something that was given is wrong, and how it would be right.

    ``what`` says what is wrong, ``file`` and ``line`` where (or None), ``remedy`` what would be right (or None);
    ``others`` are further complaints of the same call.
    """

    def __init__(
        self,
        what: str,
        file: str | None = None,
        line: int | None = None,
        remedy: str | None = None,
        text: str | None = None,
    ) -> None:
        super().__init__(text or (f"{what}\n  help: {remedy}" if remedy else what))
        self.what = what
        self.file = file
        self.line = line
        self.remedy = remedy
        self.others: tuple[Complaint, ...] = ()

    def __reduce__(self) -> tuple[Any, ...]:
        return (Complaint, (self.what, self.file, self.line, self.remedy, str(self)))


class Note(UserWarning):
    """What is to be known beside a result: how a record was read, which of its samples were left out, where a diagnosis is kept.

    ``warnings.simplefilter("ignore", borescope.Note)`` leaves notes away.
    """


def call(
    arguments: Sequence[str],
    progress: bool | Listener | None = None,
    threads: int | None = None,
    plain: Callable[[str], str] = in_python,
    scratch: Path | None = None,
) -> str:
    """Run a command line without the name of the program, and give what it writes to standard output.

    Its notes, changed by ``plain``, are warnings at the line outside of this package that asked. Results name files in the folder
    ``scratch``, which were written for this call alone, without it.
    """
    out, wrong = call_all(arguments, progress, threads, plain, scratch)
    if wrong:
        wrong[0].others = tuple(wrong[1:])
        raise wrong[0]
    return out


def call_all(
    arguments: Sequence[str],
    progress: bool | Listener | None = None,
    threads: int | None = None,
    plain: Callable[[str], str] = in_python,
    scratch: Path | None = None,
) -> tuple[str, list[Complaint]]:
    """The same, and what went wrong with some of several records beside what went well."""
    with _Bar(progress) as listener:
        out, wrong, notes = _borescope.call(list(arguments), listener, threads, scratch)
    for note in notes:
        warnings.warn(plain(note).removeprefix("note: "), Note, stacklevel=_outside())
    return out, [_complaint(*one) for one in wrong]


def _complaint(what: str, file: str | None, line: int | None, remedy: str | None, text: str) -> Complaint:
    return Complaint(in_python(what), file, line, remedy and in_python(remedy), in_python(text))


def _outside() -> int:
    """How many frames above the caller stands the first one outside of this package."""
    package = str(Path(__file__).parent)
    level, frame = 1, sys._getframe(1)
    while frame.f_back is not None and frame.f_code.co_filename.startswith(package):
        level, frame = level + 1, frame.f_back
    return level


class _Bar:
    """A bar of tqdm, or whatever the user calls with the progress."""

    def __init__(self, progress: bool | Listener | None) -> None:
        self.listener: Listener | None = None
        self.bar: Any = None
        if callable(progress):
            self.listener = progress
        elif progress:
            try:
                from tqdm.auto import tqdm
            except ImportError:
                warnings.warn("there is no bar without tqdm: `pip install tqdm`, or give a function", Note, stacklevel=_outside())
                return
            self.bar = tqdm(bar_format="{desc} {n_fmt}/{total_fmt} {elapsed}")
            self.listener = self.show

    def show(self, stage: str, done: int, of: int | None) -> None:
        self.bar.set_description_str(stage, refresh=False)
        self.bar.total, self.bar.n = of, done
        self.bar.refresh()

    def __enter__(self) -> Listener | None:
        return self.listener

    def __exit__(self, *_: object) -> None:
        if self.bar is not None:
            self.bar.close()
