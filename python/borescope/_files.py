"""Files that are written whole or not at all."""

from __future__ import annotations

import errno
import os
from pathlib import Path

from borescope._complaint import Complaint


def write(path: Path, content: str | bytes) -> None:
    """Writes a file in one piece; what is there before stays where that fails."""
    part = path.with_name(f"{path.name}.{os.getpid()}.part")
    try:
        try:
            part.write_bytes(content if isinstance(content, bytes) else content.encode())
            os.replace(part, path)
        except OSError:
            part.unlink(missing_ok=True)
            raise
    except OSError as error:
        raise unwritable(path, error) from error


def unwritable(path: Path, error: OSError) -> Complaint:
    """What is said of a file that cannot be written."""
    full = error.errno in (errno.ENOSPC, errno.EDQUOT)
    remedy = "make room on the disk, and call again" if full else "check the folder and the rights to it, or name another one"
    return Complaint(f"{path}: cannot be written: {error.strerror or error}", file=str(path), remedy=remedy)
