"""What is fuzzed: each reader with sound input, and the way input is handed to it."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import NamedTuple

import numpy as np
from seat import SEAT

from drysim.errors import UsageError
from drysim.excitation.recorded import Record
from drysim.metrics.checks import Check
from drysim.metrics.table import METRICS
from drysim.scenario.load import load
from drysim.units import QUANTITY_NAMES, convert
from test_record_formats import at2, conversion, conversions, mat, mdf, rpc, tdms, uff, wav

HERE = Path(__file__).parents[1]
GALLERY = HERE.parent / "scenarios"
VALUES = np.random.default_rng(1).normal(size=60)
TWO = {"acc": VALUES, "b": VALUES}
FREQUENCY = {"excitation.frequency": "Hz", "oscillator.mass": "kg"}


class Target(NamedTuple):
    """A reader: sound input, the file it stands in, how it is read, its share of a campaign."""

    seeds: list[bytes]
    file: str
    read: Callable[[Path, bytes], object]
    share: int


def texts(*words: str) -> list[bytes]:
    """Return words as the bytes of UTF-8."""
    return [word.encode() for word in words]


def scenario(file: Path, given: bytes) -> None:
    """Read a scenario."""
    load(file)


def override(file: Path, given: bytes) -> None:
    """Lay words over a sound scenario, as a shell would hand them on."""
    load(file.with_name("sound.yaml"), given.decode(errors="surrogateescape").split("\0"))


def check(file: Path, given: bytes) -> None:
    """Read a check; what it raises becomes a located problem elsewhere."""
    try:
        Check.parse(given.decode(errors="replace"), FREQUENCY)
    except ValueError as fault:
        raise UsageError(str(fault)) from None


def quantity(file: Path, given: bytes) -> None:
    """Read a number with a unit, as every unit there is."""
    text = given.decode(errors="replace")
    unit = [*QUANTITY_NAMES][len(given) % len(QUANTITY_NAMES)]
    try:
        convert(text, unit)
    except ValueError as fault:
        raise UsageError(str(fault)) from None


def record(**words: object) -> Callable[[Path, bytes], object]:
    """Return the reader of a record."""

    def read(file: Path, given: bytes) -> None:
        block = {"kind": "record", "file": file.name, **words}
        motion = Record.model_validate(block, context={"folder": file.parent}).motion()
        assert np.isfinite(motion.u_dd).all(), "a motion that is not finite"

    return read


def written(folder: Path, name: str, write: Callable[[Path], object]) -> list[bytes]:
    """Return the bytes that a writer puts into a file."""
    write(folder / name)
    return [(folder / name).read_bytes()]


def converted(folder: Path) -> list[bytes]:
    """Return MDF files with each kind of conversion, formulas included."""
    kinds = [given for given, _ in conversions().values()] + [conversion(3, formula="2 * X")]
    files = []
    for given in kinds:
        write = partial(mdf, given=TWO, samples=given)
        files += written(folder, "c.mf4", write)
    return [*files, *written(folder, "c.mf4", lambda path: mdf(path, TWO, times=kinds[0]))]


def targets(folder: Path) -> dict[str, Target]:
    """Return what is fuzzed by name; sound input is made in a folder."""
    (folder / "sound.yaml").write_text(SEAT)
    whole = (VALUES * 99).astype(np.int16)
    rows = [f"{k / 50},{v}" for k, v in enumerate(VALUES)]
    csv = ["t [s],a [g]", *rows]
    tables = texts(
        "\n".join(csv), "\r\n".join(csv), "\ufeff" + "\n".join(["# remark", *csv, "", ""]),
        "\n".join(csv).replace(",", ";").replace(".", ","), "\n".join(csv).replace(",", "\t"),
        "\n".join(rows).replace(",", "  "),
    )  # fmt: skip
    files = [*(HERE / "problems").glob("*.yaml"), *GALLERY.rglob("*.yaml")]
    matlab = record(column="acc", rate=1, unit="g")
    numbered = record(time=1, column=2, unit="g")
    named = record(time="t", column="a")
    metrics = [f"{metric.name} <= 1.5 {metric.unit}" for metric in METRICS]
    near = ["T_a < 0.6 at excitation.frequency >= 8 Hz and oscillator.mass == 75 kg", "SEAT<1"]
    numbers = [f"25.4e-1 {unit}" for unit in QUANTITY_NAMES] + [
        "-3",
        "0.05 g",
        "20 mm",
        "1/60 s",
        "9 %",
    ]
    words = [
        "friction.kinetic=30", "stroke.limit=25 mm", "checks=[T_a < 1]", "friction=null",
        "sweep.excitation.frequency={from: 1, to: 5, step: 0.5}", "solver.smooth.sharpness=1e3",
        "excitation={kind: sines, components: [{frequency: 1, rms: 1}]}", "measure.settle=1",
        "sweep.friction.kinetic=[1, 2]\0sweep.friction.kinetic.0=3", "start.x_r=1\0start=null",
    ]  # fmt: skip
    five = written(folder, "5.mat", lambda path: mat(path, TWO))
    packed = written(folder, "p.mat", lambda path: mat(path, TWO, do_compression=True))
    four = written(folder, "4.mat", lambda path: mat(path, TWO, format="4"))
    channel = record(channel="acc", gravity="keep")
    return {
        "scenario": Target([file.read_bytes() for file in files], "f.yaml", scenario, 20),
        "--set": Target(texts(*words), "f.yaml", override, 10),
        "check": Target(texts(*metrics, *near), "f.txt", check, 15),
        "quantity": Target(texts(*numbers), "f.txt", quantity, 15),
        "csv": Target(tables, "f.csv", named, 8),
        "csv by number": Target(tables, "f.csv", numbered, 8),
        "wav": Target(
            written(folder, "i.wav", lambda path: wav(path, 50, whole)),
            "f.wav", record(full_scale="1 g"), 5,
        ),
        "wav of floats": Target(
            written(folder, "r.wav", lambda path: wav(path, 50, VALUES)),
            "f.wav", record(unit="g"), 5,
        ),
        "mat": Target(five, "f.mat", matlab, 5),
        "packed mat": Target(packed, "f.mat", matlab, 2),
        "mat of version 4": Target(four, "f.mat", matlab, 2),
        "at2": Target(
            written(folder, "a.at2", lambda path: at2(path, VALUES, ".01")),
            "f.at2", record(), 5,
        ),
        "mdf": Target(
            [
                *written(folder, "m.mf4", lambda path: mdf(path, TWO)),
                *written(folder, "z.mf4", lambda path: mdf(path, TWO, compression=2)),
                *converted(folder),
            ],
            "f.mf4", channel, 1,
        ),
        "tdms": Target(
            written(folder, "t.tdms", lambda path: tdms(path, TWO)), "f.tdms", channel, 2
        ),
        "uff": Target(
            [
                *written(folder, "b.uff", lambda path: uff(path, TWO)),
                *written(folder, "t.uff", lambda path: uff(path, TWO, binary=0)),
            ],
            "f.uff", channel, 2,
        ),
        "rpc": Target(
            written(folder, "r.rpc", lambda path: rpc(path, TWO)),
            "f.rpc", channel, 2,
        ),
    }  # fmt: skip
