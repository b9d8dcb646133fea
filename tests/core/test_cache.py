"""Compiled kernels on disk: written beside no package, shared by processes, never stale."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

import drysim

ARCTAN = 1
PROGRAM = (
    "from drysim.core.fixed_step import sliding_share as share\n"
    f"print(share({ARCTAN}, 1.0, 1.0), len(share.stats.cache_hits))\n"
)
HALF = 0.5
"""2/π atan(1)."""


@pytest.fixture
def site(tmp_path: Path) -> Iterator[Path]:
    """Give a folder of packages with a drysim that nobody can write to."""
    site = tmp_path / "site"
    shutil.copytree(
        Path(drysim.__file__).parent,
        site / "drysim",
        ignore=shutil.ignore_patterns("__pycache__"),
    )
    for path in (site, *site.rglob("*")):
        path.chmod(0o555 if path.is_dir() else 0o444)
    yield site
    for path in (site, *site.rglob("*")):
        path.chmod(0o755)


def start(site: Path) -> subprocess.Popen[str]:
    """Begin a process that compiles one kernel of a drysim and calls it."""
    environment = {
        **os.environ,
        "PYTHONPATH": str(site),
        "PYTHONDONTWRITEBYTECODE": "1",
        "XDG_CACHE_HOME": str(site.parent / "cache"),
        "DRYSIM_ENGINE": "compiled",
    }
    return subprocess.Popen(
        [sys.executable, "-c", PROGRAM],
        env=environment,
        cwd=site.parent,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


def answer(process: subprocess.Popen[str]) -> tuple[float, bool]:
    """Give what the kernel gave, and whether it came from the disk."""
    out, err = process.communicate()
    assert process.returncode == 0, err
    value, hits = out.split()
    return float(value), hits != "0"


@pytest.mark.slow
def test_kernels_are_kept_although_the_package_can_only_be_read(site: Path) -> None:
    before = sorted(site.rglob("*"))
    assert answer(start(site)) == (HALF, False)
    assert answer(start(site)) == (HALF, True)
    assert sorted(site.rglob("*")) == before


@pytest.mark.slow
def test_processes_that_compile_at_once_do_not_disturb_each_other(site: Path) -> None:
    answers = [answer(process) for process in [start(site) for _ in range(3)]]
    assert [value for value, _ in answers] == [HALF] * 3
    assert answer(start(site)) == (HALF, True)


@pytest.mark.slow
def test_upgrade_of_the_same_size_and_time_is_compiled_anew(site: Path) -> None:
    assert answer(start(site))[0] == HALF
    source = site / "drysim" / "core" / "fixed_step.py"
    written, text = source.stat(), source.read_text()
    changed = text.replace("2.0 / math.pi", "4.0 / math.pi")
    assert changed != text
    source.chmod(0o644)
    source.write_text(changed)
    os.utime(source, ns=(written.st_atime_ns, written.st_mtime_ns))
    assert source.stat().st_size == written.st_size
    assert answer(start(site)) == (2 * HALF, False)


@pytest.mark.slow
@pytest.mark.parametrize("ending", [".nbi", ".nbc"])
@pytest.mark.parametrize("zeros", [0, 64], ids=["cut short", "ending in zeros"])
def test_kernels_that_a_power_loss_cut_short_are_compiled_anew(
    site: Path, ending: str, zeros: int
) -> None:
    assert answer(start(site)) == (HALF, False)
    kept = list((site.parent / "cache").rglob(f"*{ending}"))
    assert kept
    for file in kept:
        whole = file.read_bytes()
        file.write_bytes(whole[: -len(whole) // 3] + bytes(zeros))
    assert answer(start(site)) == (HALF, False)
    assert answer(start(site)) == (HALF, True)


@pytest.mark.slow
def test_kernel_with_a_changed_byte_is_not_run(site: Path) -> None:
    assert answer(start(site)) == (HALF, False)
    (kept,) = (site.parent / "cache").rglob("*.nbc")
    whole = bytearray(kept.read_bytes())
    whole[len(whole) // 2] ^= 255
    kept.write_bytes(whole)
    assert answer(start(site)) == (HALF, False)
    assert answer(start(site)) == (HALF, True)
