from collections.abc import Callable, Sequence
from os import PathLike

__all__ = ["__version__", "call", "command"]

__version__: str

def call(
    arguments: Sequence[str],
    progress: Callable[[str, int, int | None], object] | None = None,
    threads: int | None = None,
    scratch: str | PathLike[str] | None = None,
) -> tuple[str, list[tuple[str, str | None, int | None, str | None, str]], list[str]]: ...
def command(arguments: Sequence[str]) -> int: ...
