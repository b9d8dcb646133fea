"""A real browser, where there is one: `needs_browser` skips a test without it."""

from __future__ import annotations

import os
import shutil
import subprocess
from pathlib import Path

import pytest

PROGRAM = next(filter(None, map(shutil.which, ("chromium", "chromium-browser"))), None)
FLAGS = (
    "--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run",
    "--disable-background-networking", "--disable-component-update", "--disable-sync",
    "--enable-logging=stderr", "--virtual-time-budget=5000",
)  # fmt: skip

needs_browser = pytest.mark.skipif(
    PROGRAM is None, reason="needs chromium; install it to test in a browser"
)


def browse(address: str, option: str, home: Path) -> subprocess.CompletedProcess[str]:
    """Open an address with one more option, such as `--dump-dom`; its files lie in `home`."""
    return subprocess.run(
        [str(PROGRAM), *FLAGS, f"--user-data-dir={home / 'profile'}", option, address],
        capture_output=True,
        text=True,
        encoding="utf-8",
        env={**os.environ, "HOME": str(home)},
        timeout=60,
    )
