"""How the files of one work get into their folder: all of them, told by one sidecar."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Sequence
from contextlib import nullcontext
from pathlib import Path
from typing import Any, TypeVar

from drysim.errors import EXIT_INTERRUPTED
from drysim.report.claim import CASES, JOURNAL, MARKER
from drysim.report.folder import Claim, claim_partial, finish, leave, mark
from drysim.report.sidecar import text

Made = TypeVar("Made")


def put(
    made: Made,
    folder: Path | Claim,
    writers: Sequence[Callable[[Made, Path], None]],
    tell: Callable[[Made, str, int, dict[str, str]], dict[str, Any]],
    command: str,
    exit_code: int,
) -> dict[str, Any]:
    """Let all writers write, tell what made their files, and put the folder in its place."""
    with nullcontext(folder) if isinstance(folder, Claim) else claim_partial(folder) as claim:
        for writer in writers:
            writer(made, claim.partial)
        files = {
            path.relative_to(claim.partial).as_posix(): _sha256(path)
            for path in written(claim.partial)
        }
        told = tell(made, command, exit_code, files)
        mark(claim.partial, text(told))
        (leave if exit_code == EXIT_INTERRUPTED else finish)(claim)
    return told


def written(partial: Path) -> list[Path]:
    """Give every file of a result, those in folders of its own included."""
    inner = (path for path in partial.iterdir() if path.name not in (CASES, JOURNAL, MARKER))
    files = (path.rglob("*") if path.is_dir() else [path] for path in inner)
    return sorted(path for found in files for path in found if path.is_file())


def _sha256(file: Path) -> str:
    with file.open("rb") as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest()
