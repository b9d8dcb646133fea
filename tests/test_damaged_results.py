"""Damaged, newer and replaced results: what `summarise` and `report` make of them."""

from __future__ import annotations

import json
import re
import shutil
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest
from seat import SEAT

from drysim import output
from drysim.cli import main
from drysim.output.folder import add_report, read_stored_fields
from drysim.results.fields import is_intact
from drysim.study.gallery import find

SWEEP = "\nsweep: {excitation.frequency: {from: 1, to: 3, count: 3}}\n"
NOISE = "excitation={kind: psd, points: [[1, 1], [4, 1]], duration: 9, seeds: 2}"
KINDS = {
    "run": ("run", "seat.yaml"),
    "ensemble": ("run", "seat.yaml", "--set", NOISE, "--set", "measure=null"),
    "sweep": ("sweep", "swept.yaml"),
    "comparison": ("compare", "swept.yaml", "signum", "vs", "stick-slip", "-s"),
    "fit": ("fit", find("fit-decay").file),
    "map": (
        "map", find("regime-map").file, "--set", "sweep.friction.kinetic.count=5",
        "--set", "sweep.excitation.frequency.count=5",
    ),
}  # fmt: skip
"""Kinds of results, and a command that writes a small one."""


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    """Return the folder of a result of each kind, computed when it is first asked for."""
    place, made = tmp_path_factory.mktemp("results"), {}
    (place / "seat.yaml").write_text(SEAT)
    (place / "swept.yaml").write_text(SEAT + SWEEP)

    def folder(kind):
        if kind not in made:
            command, scenario, *options = KINDS[kind]
            words = [command, *options, place / scenario]
            words += ["--no-plots", "--quiet", "--out", place / kind]
            assert main([str(word) for word in words]) in (0, 1)
            made[kind] = place / kind
        return made[kind]

    return folder


STRANGE = [
    None, True, -1, 0, 10**400, 1e308, -0.0, "", "x", "\x1b[2J", "9" * 5000, [], {}, [[]],
    {"": None}, [{}], ["ok"], {"value": "high", "where": 3}, {"least": None},
]  # fmt: skip
"""Values in place of others; each is JSON."""


@contextmanager
def restored(folder):
    """Give the text of drysim.json, and the folder as it was behind the block."""
    file = folder / "drysim.json"
    whole = file.read_text(encoding="utf-8")
    try:
        yield whole
    finally:
        file.write_text(whole, encoding="utf-8")
        (folder / "report.html").unlink(missing_ok=True)


def parent_of(fields, path):
    """Return the block or list that a path of a tree of JSON ends in."""
    for key in path[:-1]:
        fields = fields[key]
    return fields


def places(value, path=()):
    """Yield the path of every value in a tree of JSON."""
    if path:
        yield path
    for key, below in value.items() if isinstance(value, dict) else ():
        yield from places(below, (*path, key))
    for index, below in enumerate(value) if isinstance(value, list) else ():
        yield from places(below, (*path, index))


def damaged(text, rng):
    """Return the text of a drysim.json with one or two faults."""
    fields = json.loads(text)
    for _ in range(rng.integers(1, 3)):
        spots = list(places(fields))
        # A path is drawn by its depth, so that the few at the top come as often as all below.
        depth = rng.integers(1, 1 + max(map(len, spots)))
        spots = [spot for spot in spots if len(spot) <= depth]
        path = spots[rng.integers(len(spots))]
        parent, last = parent_of(fields, path), path[-1]
        match rng.integers(3):
            case 0:
                del parent[last]
            case 1:
                parent[last] = STRANGE[rng.integers(len(STRANGE))]
            case _:
                other = spots[rng.integers(len(spots))]
                value = fields
                for key in other:
                    value = value[key] if not isinstance(value, int | float | str) else value
                parent[last] = json.loads(json.dumps(value))
    words = json.dumps(fields)
    return words[: rng.integers(len(words))] if rng.random() < 0.1 else words


CHANGED = "Changed since drysim wrote them: drysim.json."
NOTICED = re.compile(r"Changed since drysim wrote them: .*drysim\.json\.")
WORDS_OF_PYTHON = re.compile(
    r"\w(Error|Exception)\b|[Ii]nput should|(?<!software\.)pydantic|object has no|NoneType"
)


def is_same(text, other):
    """Whether two texts are the same JSON, which may have another layout."""
    return json.loads(text) | {"created": ""} == json.loads(other) | {"created": ""}


@pytest.mark.parametrize("kind", KINDS)
def test_each_value_of_drysim_json_that_is_changed_is_noticed(results, kind):
    text = (results(kind) / "drysim.json").read_text(encoding="utf-8")
    assert is_intact(json.loads(text))
    for path in places(json.loads(text)):
        last = path[-1]
        if last == "created":  # in which two runs of the same scenario differ
            continue
        parent = parent_of(fields := json.loads(text), path)
        parent[last] = not parent[last] if isinstance(parent[last], bool) else [parent[last]]
        assert not is_intact(fields), path
        del parent[last]
        assert not is_intact(fields), path


def test_each_byte_of_drysim_json_that_is_changed_is_noticed(results, capsys):
    folder, rng = results("run"), np.random.Generator(np.random.PCG64(3))
    with restored(folder) as text:
        whole = text.encode()
        for place in rng.integers(len(whole), size=150):
            changed = bytearray(whole)
            changed[place] = rng.integers(256)
            (folder / "drysim.json").write_bytes(changed)
            code = main(["summarise", str(folder)])
            err = capsys.readouterr().err
            if code:
                assert (code, err.startswith("error: ")) == (2, True)
            else:
                near = changed[place - 20 :][:40]
                assert is_same(changed, whole) or NOTICED.search(err), near


def test_another_layout_of_drysim_json_is_no_change(results, drysim):
    folder = results("run")
    with restored(folder) as whole:
        reordered = json.dumps(dict(reversed(json.loads(whole).items())))
        (folder / "drysim.json").write_text(reordered, encoding="utf-8")
        assert drysim("summarise", folder).err == ""


def test_report_of_a_changed_result_claims_nothing_and_does_not_hide_it(seat, drysim):
    words = ("--no-plots", "--out", "out", "--set", "checks=[T_a < 9]")
    assert drysim("run", seat, *words).code == 0
    file = Path("out/drysim.json")
    file.write_text(file.read_text().replace('"passed": true', '"passed": false', 1))
    for _ in range(2):
        done = drysim("report", "out", "--no-plots", "--quiet")
        assert (done.code, done.err) == (0, f"warning: out: {CHANGED}\n")
        page = Path("out/report.html").read_text(encoding="utf-8")
        assert "Do not rely on this result" in page
        assert CHANGED in page
        assert "No warnings." not in page
        assert "meets the requirements" not in page
        assert f"warning: {CHANGED}" in drysim("summarise", "out").err


@pytest.mark.parametrize(
    ("path", "value", "sentence"),
    [
        (("metrics", "T_a"), "high", "metrics.T_a is `high`, which drysim does not write"),
        (("summary", "groups", 0, 0), 3, "summary.groups.0.0 is 3, which drysim does not"),
        (("summary", "checks"), [{}], "summary.checks.0"),  # or below it, by pydantic
        (("warnings",), 3, "warnings is 3, which drysim does not write there"),
    ],
)
def test_damaged_value_is_named_with_its_place(results, drysim, path, value, sentence):
    folder = results("run")
    with restored(folder) as whole:
        fields = json.loads(whole)
        parent_of(fields, path)[path[-1]] = value
        (folder / "drysim.json").write_text(json.dumps(fields), encoding="utf-8")
        done = drysim("report", folder, "--no-plots")
    assert (done.code, done.out) == (2, "")
    assert f"drysim.json is damaged: {sentence}" in " ".join(done.err.split())


def check_damaged(folder, number, pages, seed, capsys):
    """Summarise damaged copies, and report some: shown, or an error that names the file."""
    file, rng = folder / "drysim.json", np.random.Generator(np.random.PCG64(seed))
    seen = set()
    with restored(folder) as whole:
        for count in range(number):
            words = damaged(whole, rng)
            file.write_text(words, encoding="utf-8")
            commands = [["summarise"], ["report", "--no-plots", "--quiet"]]
            for command in commands[: 1 + (count < pages)]:
                code = main([*command, str(folder)])
                out, err = capsys.readouterr()
                seen.add((command[0], code))
                assert code in (0, 2), (err, words)
                assert "Traceback" not in err
                if code:
                    assert err.startswith("error: "), words
                    assert out == "", words
                    assert not WORDS_OF_PYTHON.search(err), err
                else:
                    assert is_same(words, whole) or NOTICED.search(err), words
            assert {path.name for path in folder.iterdir()} <= names_of(whole)
            (folder / "report.html").unlink(missing_ok=True)
    assert seen >= {("summarise", 0), ("summarise", 2)}


def names_of(text):
    """Return the files of a folder with a report."""
    return {"drysim.json", "report.html", *json.loads(text)["files"]}


MANY = pytest.param(1000, 200, 8, marks=pytest.mark.slow)


@pytest.mark.parametrize(("number", "pages", "seed"), [(25, 2, 7), MANY])
@pytest.mark.parametrize("kind", KINDS)
def test_damaged_result_is_shown_or_refused_with_its_place(
    results, kind, number, pages, seed, capsys
):
    check_damaged(results(kind), number, pages, seed, capsys)


@pytest.mark.parametrize("kind", KINDS)
def test_result_with_an_empty_part_is_shown_or_refused(results, kind, capsys):
    folder = results(kind)
    with restored(folder) as whole:
        for path in places(json.loads(whole)):
            parent, last = parent_of(fields := json.loads(whole), path), path[-1]
            if len(path) > 2 or not isinstance(parent[last], dict | list) or not parent[last]:
                continue
            parent[last] = type(parent[last])()
            (folder / "drysim.json").write_text(json.dumps(fields), encoding="utf-8")
            commands = [["summarise"], ["report", "--no-plots", "--quiet"]]
            for command in commands[: 1 + ("metrics" in path)]:
                code = main([*command, str(folder)])
                assert code in (0, 2), (path, capsys.readouterr().err)


@pytest.mark.parametrize("state", ["Changed since drysim wrote them", "Missing or unreadable"])
def test_file_that_is_not_as_it_was_written_is_named(results, state, tmp_path, capsys):
    folder = tmp_path / "copy"
    shutil.copytree(results("run"), folder)
    table = folder / "response.csv"
    if state.startswith("Missing"):
        table.unlink()
    else:
        table.write_bytes(table.read_bytes()[:-2] + b"9\n")
    for words in ([], ["--json"]):
        assert main(["summarise", str(folder), *words]) == 0
        assert f"warning: {state}: response.csv." in " ".join(capsys.readouterr().err.split())


@pytest.mark.parametrize("command", ["summarise", "report"])
def test_result_of_a_later_version_is_refused_by_its_format(results, drysim, command):
    folder = results("run")
    with restored(folder) as whole:
        (folder / "drysim.json").write_text(whole.replace('"format": 2', '"format": 7'))
        done = drysim(command, folder)
    assert (done.code, done.out) == (2, "")
    assert "was written by a later version of drysim: it has format 7" in done.err
    assert "update drysim" in done.err


# A report beside a new run of the same folder.


def test_report_of_a_result_that_was_replaced_meanwhile_changes_nothing(
    seat, drysim, monkeypatch
):
    assert drysim("run", seat, "--no-plots", "--out", "out").code == 0
    from drysim.output import report

    whole = report.report_folder

    def slow(*words, **options):
        made = whole(*words, **options)
        again = ("--set", "oscillator.mass=70", "--no-plots", "--quiet", "--out", "out")
        assert main(["run", str(seat), *again]) == 0
        return made

    monkeypatch.setattr(report, "report_folder", slow)
    done = drysim("report", "out", "--no-plots")
    assert done.code == 2
    assert "out was replaced by another result while its report was written" in done.err
    assert not Path("out/report.html").exists()
    assert read_stored_fields(Path("out"))["scenario"]["overrides"]
    assert drysim("run", seat, "--no-plots", "--out", "out").code == 0


def test_report_of_the_result_that_is_there_is_added(seat, drysim):
    assert drysim("run", seat, "--no-plots", "--out", "out").code == 0
    fields = read_stored_fields(Path("out"))
    add_report(Path("out"), "page", fields)
    assert Path("out/report.html").read_text() == "page"
    output.check_writable(Path("out"))
