"""The wheel outside the checkout: it carries the gallery and finds it."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

CHECKOUT = Path(__file__).parents[1]


def call(*words, **options):
    """Run Python and give its stdout; fail with what it says."""
    done = subprocess.run([sys.executable, *words], capture_output=True, text=True, **options)
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    """Build the wheel and unpack it into a folder of its own."""
    wheels, site = tmp_path_factory.mktemp("wheels"), tmp_path_factory.mktemp("site")
    call("-m", "pip", "wheel", "--quiet", "--no-deps", "-w", str(wheels), str(CHECKOUT))
    (wheel,) = wheels.glob("drysim-*.whl")
    call("-m", "pip", "install", "--quiet", "--no-deps", "--target", str(site), str(wheel))
    return site


@pytest.mark.slow
@pytest.mark.by_hand
def test_wheel_runs_a_scenario_of_its_own_gallery_outside_the_checkout(site, tmp_path):
    place = {"cwd": tmp_path, "env": {**os.environ, "PYTHONPATH": str(site)}}
    where = call("-c", "import drysim.study.gallery as g; print(g.folder())", **place)
    assert Path(where.strip()) == site / "drysim" / "scenarios"
    call("-m", "drysim", "init", "seat-on-em1", **place)
    call("-m", "drysim", "run", "seat-on-em1.yaml", **place)
    assert (tmp_path / "out" / "seat-on-em1" / "response.png").stat().st_size > 1000


@pytest.mark.slow
@pytest.mark.by_hand
def test_wheel_holds_the_whole_gallery_and_the_licence(site):
    gallery = {file.name for file in (CHECKOUT / "scenarios").iterdir() if file.is_file()}
    assert gallery - {file.name for file in (site / "drysim" / "scenarios").iterdir()} == set()
    assert list(site.glob("drysim-*.dist-info/licenses/**/LICENSE"))
    assert (site / "drysim" / "py.typed").exists()
    pictures = site / "drysim" / "scenarios" / "pictures"
    assert [path.name for path in pictures.iterdir()] == ["loops"]
    loops = {file.name for file in (CHECKOUT / "scenarios" / "pictures" / "loops").iterdir()}
    assert {file.name for file in (pictures / "loops").iterdir()} == loops
    hard = {file.name for file in (CHECKOUT / "scenarios" / "hard").iterdir()}
    assert hard == {file.name for file in (site / "drysim" / "scenarios" / "hard").iterdir()}
