"""The report: one page that needs nothing else, says what drysim knows, and trusts no file."""

from __future__ import annotations

import base64
import json
import os
import re
import shutil
from html.parser import HTMLParser
from pathlib import Path

import pytest
from browser import browse, needs_browser
from seat import SEAT, write_records

import drysim as package
from drysim.errors import UsageError
from drysim.manual.words import DESIGN, FIT, entries, explain
from drysim.metrics.table import METRICS_BY_NAME
from drysim.output import report
from drysim.output.folder import save_file
from drysim.results.fields import DIGEST, digest_of
from drysim.study.summary import BAD, Row
from drysim.system import file_sha256
from drysim.wording import format_number

POLICY = "default-src 'none'; img-src data:; style-src 'unsafe-inline'"
VOID = {"meta", "br", "img"}

SWEPT = SEAT.replace("measure", "sweep: {excitation.frequency: [1, 1.5, 3]}\nmeasure")
NOISY = SEAT.replace(
    "{kind: harmonic, frequency: 1.6, rms: 1.0}",
    "{kind: psd, points: [[0.8, 1], [20, 1]], duration: 10 s, seed: 1}",
).replace("measure: {steady: false, settle: 0, duration: 2}", "measure: {spectra: true}")
SEEDS = NOISY.replace("seed: 1}", "seed: 1, seeds: 3}")
HOSTILE = "</title><script>alert(1)</script>'\"&{{ 7*7 }}\u202e\u0007"
ESCAPED = "&lt;/title&gt;&lt;script&gt;alert(1)&lt;/script&gt;&#39;&#34;&amp;{{ 7*7 }}"


class Page(HTMLParser):
    """A page as a browser sees it: its elements, their attributes and the text."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.open: list[str] = []
        self.tags: list[str] = []
        self.attributes: list[tuple[str, str | None]] = []
        self.words: list[str] = []
        self.feed(text)
        self.close()
        self.text = " ".join("".join(self.words).split())

    def handle_starttag(self, tag, attributes):
        self.tags.append(tag)
        self.attributes += attributes
        if tag not in VOID:
            self.open.append(tag)
        self.separate(tag)

    def separate(self, tag):
        self.words.append("" if tag == "code" else " ")

    def handle_startendtag(self, tag, attributes):
        self.tags.append(tag)
        self.attributes += attributes

    def handle_endtag(self, tag):
        assert self.open.pop() == tag
        self.separate(tag)

    def handle_data(self, data):
        if self.open and self.open[-1] != "style":
            self.words.append(data)


def meaning(word, kind=""):
    """Return the meaning of a word as a page shows it."""
    return next(one.text for one in explain(word) if kind in ("", one.kind)).replace("`", "")


def values(page, name):
    return [value for key, value in page.attributes if key == name]


@pytest.fixture
def result(drysim, seat):
    """Return a function that runs a scenario with --report and returns folder and page."""

    def make(text=SEAT, command="run", *words):
        seat.write_text(text, encoding="utf-8")
        done = drysim(command, seat, "--report", "--quiet", "-o", "out", *words)
        assert done.code in (0, 1), done.err
        return seat.parent / "out", (seat.parent / "out/report.html").read_text("utf-8")

    return make


def test_page_needs_nothing_but_itself(result):
    page = Page(result(NOISY)[1])
    assert page.open == []
    assert not {*page.tags} & {"script", "link", "svg", "image", "iframe", "object", "base"}
    assert not [name for name, _ in page.attributes if name.startswith("on")]
    assert all(value.startswith("data:image/png;base64,") for value in values(page, "src"))
    assert values(page, "href") == []
    assert POLICY in values(page, "content")
    assert page.tags[0] == "html"


@pytest.mark.parametrize("form", ["png", "svg"])
def test_pictures_of_a_page_are_those_of_the_folder_with_alternative_text(result, form):
    folder, written = result(NOISY, "run", "--picture-format", form)
    page = Page(written)
    kinds = {"png": "image/png", "svg": "image/svg+xml"}
    sources = values(page, "src")
    for name, source in (("response", sources[0]), ("spectra", sources[2])):
        head, _, content = source.partition(",")
        assert head == f"data:{kinds[form]};base64"
        assert base64.b64decode(content) == (folder / f"{name}.{form}").read_bytes()
    assert len(sources) == 3  # and the sketch
    assert all(values(page, "alt"))
    assert len(values(page, "alt")) == 3


def test_page_names_the_pictures_that_no_page_can_show(result):
    folder, written = result(SEAT, "run", "--picture-format", "pdf")
    page = Page(written)
    assert "response.pdf in the folder of the result" in page.text
    assert values(page, "href") == []
    assert (folder / "response.pdf").is_file()


def test_page_says_what_was_computed_whether_it_suffices_and_why_to_believe_it(result):
    text = SEAT + "about: A seat of a test.\nstroke: {limit: 5 mm}\n"
    text += "checks: [T_a < 5, x_r_peak < 1 mm]\n"
    folder, written = result(text)
    page, fields = Page(written), json.loads((folder / "drysim.json").read_text())
    for words in (
        "A seat of a test.", "1 of 2 checks fails", "✗ fails", "✓ holds",
        "stroke-violated", meaning("stroke-violated"), "m 75 kg",
        "energy residual", METRICS_BY_NAME["T_a"].about, fields["version"],
        fields["scenario"]["sha256"], *fields["software"].values(), fields["numerics"]["why"],
        fields["command"], fields["warnings"][0]["sentence"], "stiffness: 7500.0",
    ):  # fmt: skip
        assert words in page.text, words
    names = [name for name in fields["files"] if name != "report.html"]
    assert all(fields["files"][name] in page.text for name in names)
    order = ["Verdict", "Checks", "Main results", "What was computed", "Why to believe it"]
    assert sorted(order, key=page.text.index) == order
    assert "`" not in written.partition("<h2>Scenario</h2>")[0]
    assert "<code>oscillator.mass</code>" in written


def test_report_is_a_file_of_the_result(result, drysim):
    folder, _ = result()
    files = json.loads((folder / "drysim.json").read_text())["files"]
    assert files["report.html"] == file_sha256(folder / "report.html")
    assert drysim("run", "seat.yaml", "--quiet", "-o", "out").code == 0
    assert not (folder / "report.html").exists()


@pytest.mark.parametrize(
    ("command", "text", "words"),
    [
        ("run", SEAT, ()),
        ("run", NOISY, ("--set", "excitation.seeds=3", "--set", "measure={settle: 1 s}")),
        ("sweep", SWEPT, ()),
    ],
    ids=["run", "ensemble", "sweep"],
)
def test_folder_gives_the_report_of_its_command(result, drysim, command, text, words):
    text = text.replace("kinetic: 15", "kinetic: 15, static: 18")  # else said to be not given
    folder, written = result(text, command, *words)
    done = drysim("report", "out", "-o", "again.html")
    assert (done.code, done.out) == (0, "again.html\n")
    again = (folder.parent / "again.html").read_text("utf-8")
    added = [line for line in again.splitlines() if line not in written.splitlines()]
    assert len(added) == 1
    assert re.search(r"All \d+ files of the result are as drysim wrote them", added[0])


def test_comparison_is_reported(drysim, seat):
    words = ("signum", "vs", "stick-slip", "-s", seat, "--report", "--quiet", "-o", "out")
    assert drysim("compare", *words).code == 0
    verdict = json.loads(Path("out/drysim.json").read_text())["verdict"][0]
    page = Page(Path("out/report.html").read_text("utf-8")).text
    assert verdict in page
    assert "Range and quantiles over the cases of each approach." in page
    assert drysim("report", "out").code == 0
    assert verdict in Page(Path("out/report.html").read_text("utf-8")).text


@pytest.mark.slow
def test_fit_is_reported(drysim, tmp_path):
    assert drysim("init", "fit-decay").code == 0
    assert drysim("fit", "fit-decay.yaml", "--report", "--quiet", "-o", "out").code == 0
    fitted = Page(Path("out/report.html").read_text("utf-8"))
    assert "Kinetic friction force F_fk" in fitted.text
    assert meaning("friction.kinetic") not in fitted.text
    assert meaning("95 %", FIT) in fitted.text
    assert meaning("at", FIT) not in fitted.text  # of fits to curves
    assert "starting points led to this solution" in fitted.text
    assert fitted.tags.count("img") == 2
    assert drysim("report", "out").code == 0


@pytest.mark.parametrize(
    ("key", "noun"),
    [
        ("oscillator.stiffness", "Spring stiffness k_x"),
        ("oscillator.damping.extension", "Damping of v_r > 0"),
        ("friction.static_ratio", "Static ratio F_fs/F_fk"),
        ("friction.exponent", "Exponent δ of the Stribeck curve"),
        ("fit.measured.delay", "Time by which the measured response lags the base motion"),
    ],
)
def test_a_fitted_key_is_what_its_help_text_begins_with(key, noun):
    assert report.noun_of_key(key) == noun


BARE_STUDY = """design:
  vary: {oscillator.damping: {from: 100, to: 1000, scale: log}}
  minimise: T_a
"""
STUDY = f"{BARE_STUDY}  over: {{oscillator.mass: [60, 80]}}\n"


def test_page_of_a_design_study_has_every_condition_and_names_that_of_the_metrics(
    result, drysim
):
    text = SEAT + STUDY + "stroke: {limit: 20 mm}\nchecks: [T_a < 2]\n"
    folder, written = result(text, "design")
    page, fields = Page(written), json.loads((folder / "drysim.json").read_text())
    both = fields["design"]["conditions"]
    assert [one["at"] for one in both] == [{"oscillator.mass": mass} for mass in (60.0, 80.0)]
    worst = max(both, key=lambda one: one["metrics"]["T_a"])
    assert worst["at"] == fields["design"]["metrics_at"]
    assert worst["metrics"]["T_a"] == fields["metrics"]["T_a"]
    at = f"mass {worst['at']['oscillator.mass']:g} kg"
    sentence = f"Values of the best design at {at}, the condition with the highest T_a."
    assert sentence in page.text
    assert f"{at} (highest T_a)" in page.text
    for one in both:
        assert all(check["passed"] for check in one["checks"])
        assert f"✓ {format_number(1e3 * one['metrics']['x_r_peak'])}" not in page.text
        assert f"{format_number(1e3 * one['metrics']['x_r_peak'])} mm" in page.text
    judged = page.text.partition("✓ holds")[2].partition("Main results")[0]
    assert judged.count(" at mass ") == judged.count(" kg") == 2
    assert drysim("report", "out", "--no-plots").code == 0
    again = Page((folder / "report.html").read_text("utf-8")).text
    assert f"{at} (highest T_a)" in again
    assert f"of the best design at {at}" in drysim("summarise", "out").out.replace("\n", " ")


def test_design_study_explains_its_words_and_draws_no_value_that_its_conditions_vary(result):
    written = result(SEAT + STUDY, "design")[1]
    page = Page(written)
    words = [one.word for one in entries() if one.kind == DESIGN]
    assert {"within 1 %", "as given", "friction ±10 %", "no dry friction"} <= {*words}
    for word in ("within 1 %", "as given", "friction ±10 %", "stiffness ±10 %"):
        assert f"{word} {meaning(word, DESIGN)}" in page.text
    assert meaning("95 %", DESIGN) not in page.text  # a single seed has no interval
    (model,) = re.findall(r'alt="(Model: [^"]*)"', written)
    assert "75 kg" not in model


SAFE = SEAT.replace("kinetic: 15", "kinetic: 15, static: 18")
HELD = "checks: [T_a < 5]\n"
VIOLATED = "stroke: {limit: 5 mm}\n"


@pytest.mark.parametrize(
    ("text", "state", "words"),
    [
        (SAFE + HELD, "good", "✓ The check holds: the result meets"),
        (
            SAFE + HELD + VIOLATED,
            "reserved",
            "! Passed, with reservations: 1 warning. "
            "The check holds: the result meets the requirements of its scenario. "
            "Warning: the stroke limit of 5 mm is exceeded",
        ),
        (
            SAFE + VIOLATED,
            "reserved",
            "! No verdict, and reservations: 1 warning. The scenario has no checks",
        ),
        (SAFE, "open", "· The scenario has no checks, so it states no requirement"),
        (SAFE + HELD.replace("5", "1"), "bad", "✗ 1 of 1 check fails"),
    ],
    ids=["good", "reserved", "reserved without checks", "open", "bad"],
)
@pytest.mark.parametrize("command", ["run", "sweep"])
def test_warnings_and_failed_checks_decide_the_state_of_the_verdict(
    result, command, text, state, words
):
    if command == "sweep":
        text = text.replace("measure", "sweep: {excitation.rms: [0.9, 1]}\nmeasure")
    written = result(text, command, "--no-plots")[1]
    assert f'<ul class="verdict {state}">' in written
    assert words in Page(written).text


def test_verdict_quotes_a_warning_of_each_kind_and_counts_the_others():
    texts = [("a", "first"), ("a", "second"), *((slug, slug * 2) for slug in "bcdef")]
    warnings = [{"slug": slug, "sentence": sentence} for slug, sentence in texts]
    lines = ["first", "bb", "cc", "dd"]
    assert [*report.quote_warnings(warnings)] == [
        *(f"Warning: {line}." for line in lines),
        "3 more warnings below.",
    ]


def test_top_of_a_page_shows_violations_and_no_residuals():
    rows = [Row(name, "1") for name in ("T_a", "SEAT", "a_w", "T_x", "peak |x_r|", "stuck")]
    limit = Row("limit", "exceeded for 2 of 3 seeds", tone=BAD)
    shown = report.key_rows([*rows, limit, Row("energy", "residual 1e-16")])
    assert shown == [*rows[:5], limit]


def test_figures_of_a_page_are_numbered_and_say_what_they_show(result):
    page = Page(result(NOISY, "run", "--set", "excitation.seeds=3")[1])
    assert re.findall(r"Figure \d", page.text) == [f"Figure {i}" for i in range(1, 5)]
    assert "over the number of seeds; 3 seeds." in page.text
    assert "the force of the contact over it; seed 1." in page.text
    assert (
        "Transmissibilities of the cases; over frequency."
        in Page(result(SWEPT, "sweep")[1]).text
    )


def test_design_with_a_limit_that_the_seeds_leave_open_passes_with_reservations(result):
    text = SEEDS.partition("measure")[0] + "stroke: {limit: 1 mm}\n" + BARE_STUDY
    text += "  within: [x_r_peak < 100 mm]\n"
    page = result(text, "design", "--no-plots")[1]
    assert '<ul class="verdict reserved">' in page
    assert "! Passed, with reservations: " in Page(page).text


def test_stroke_limit_that_every_seed_keeps_is_reported_and_summarised(result, drysim):
    text = SEEDS.partition("measure")[0] + "stroke: {limit: 30 mm}\n" + BARE_STUDY
    page = result(f"{text}  evaluations: 8\n", "design", "--no-plots")[1]
    sentence = "stroke_used < 1 with every seed"
    for words in (Page(page).text, drysim("summarise", "out").out):
        assert sentence in " ".join(words.split())
    assert drysim("report", "out", "--no-plots").code == 0


def test_numbers_over_seeds_are_told_from_those_of_the_shown_seed(result, drysim):
    noise = NOISY.replace("seed: 1}", "seed: 4, seeds: 3}")
    page = " ".join(Page(result(noise, "run", "--no-plots")[1]).text.split())
    about = "ean, its 95 % interval, range and quantiles over 3 seeds"
    assert f"M{about}. " in page
    assert re.search(r"\d+ events with seed 4 \(stops", page)
    assert f"m{about}" in " ".join(drysim("summarise", "out").out.split())


def test_reports_are_equal_byte_by_byte(result, monkeypatch):
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "1700000000")
    assert result(NOISY)[1] == result(NOISY)[1]


def test_text_of_scenario_and_record_is_escaped(result, tmp_path):
    (tmp_path / "rec").mkdir()
    (name,) = write_records(tmp_path / "rec" / "a", 1)
    column = "<b onload=x>"
    file = tmp_path / "<img src=x>.csv"
    text = (tmp_path / "rec" / name).read_text().replace("u_dd [m/s2]", column)
    file.write_text(text)
    record = {"kind": "record", "file": file.name, "column": column, "unit": "m/s2"}
    record["time"] = "t"
    quoted = json.dumps(HOSTILE)
    scenario = (
        SEAT.replace("name: seat", f"name: seat\nabout: {quoted}")
        .replace("{kind: harmonic, frequency: 1.6, rms: 1.0}", json.dumps(record))
        .replace("solver: {approach: stick-slip, step: 2.5e-3}\n", "")
        .replace("measure: {steady: false, settle: 0, duration: 2}\n", "")
    )
    page = result(scenario)[1]
    assert not re.findall(r"<(script|img src=x|b onload)", page)
    assert "&lt;script&gt;alert(1)" in page
    assert "&lt;img src=x&gt;.csv" in page
    assert "&lt;b onload=x&gt;" in page
    assert "49" not in Page(page).text.split()
    assert not re.search(r"[\x00-\x09\x0b-\x1f\x7f-\x9f\u202a-\u202e]", page)
    Page(page)


def change(folder, **fields):
    """Change fields of drysim.json as if drysim had written them so."""
    file = folder / "drysim.json"
    fields = {**json.loads(file.read_text()), **fields}
    file.write_text(json.dumps({**fields, DIGEST: digest_of(fields)}))


def test_text_of_a_stored_result_is_escaped(result, drysim):
    folder, _ = result()
    warning = {"slug": HOSTILE, "sentence": HOSTILE, "numbers": {}}
    software = {HOSTILE: HOSTILE}
    scenario = {"name": HOSTILE, "file": HOSTILE, "overrides": {HOSTILE: HOSTILE}}
    change(folder, warnings=[warning], command=HOSTILE, created=HOSTILE, version=HOSTILE,
           software=software, scenario=scenario)  # fmt: skip
    assert drysim("report", "out").code == 0
    page = (folder / "report.html").read_text("utf-8")
    assert "<script" not in page
    assert page.count(ESCAPED) >= 11
    assert not re.search(r"[\x00-\x09\x0b-\x1f\x7f-\x9f\u202a-\u202e]", page)


def test_changed_and_missing_files_are_named_on_the_console_as_well(result, drysim):
    folder, _ = result(SAFE + HELD)
    (folder / "response.csv").write_text("t [s]\n")
    (folder / "events.csv").unlink()
    os.mkfifo(folder / "pipe") if hasattr(os, "mkfifo") else None
    (folder / "pipe").replace(folder / "response.png")
    done = drysim("report", "out", "-o", "page.html", "--quiet")
    words = (
        "Changed since drysim wrote them: response.csv. "
        "Missing or unreadable: events.csv, response.png."
    )
    assert (done.code, done.out, done.err) == (0, "", f"warning: out: {words}\n")
    written = Path("page.html").read_text("utf-8")
    assert words in Page(written).text
    assert "✗ Do not rely on this result: its files differ from those" in written
    assert '<ul class="verdict bad">' in written


def test_fault_of_the_program_is_not_taken_for_a_damaged_file(result, drysim, monkeypatch):
    result()
    monkeypatch.setattr(report, "note_on_files", lambda *_: {}["a bug"])
    done = drysim("report", "out", "-o", "page.html")
    assert done.code == 70
    assert "damaged" not in done.err


def test_incomplete_result_is_called_so_first(result, drysim):
    folder, _ = result(SWEPT + "checks: [T_a < 5]\n", "sweep")
    fields = json.loads((folder / "drysim.json").read_text())
    row = {"label": "failed", "value": "1 case", "remark": "", "tone": "bad"}
    change(folder, complete=False, exit_code=3,
           numerics=fields["numerics"] | {"statuses": {"ok": 2, "failed": 1}},
           summary=fields["summary"] | {"groups": [[row]]})  # fmt: skip
    assert drysim("report", "out", "--no-plots").code == 0
    page = Page((folder / "report.html").read_text("utf-8"))
    sentence = "✗ The result is incomplete: the numerics failed in some cases (1 case failed)."
    assert sentence in page.text
    assert page.text.index(sentence) < page.text.index("The check holds")


@pytest.mark.parametrize("kind", ["run", "sweep"])
def test_report_of_a_folder_solves_nothing(result, drysim, monkeypatch, kind):
    folder, _ = result(SWEPT if kind == "sweep" else SEAT, kind)
    monkeypatch.setattr(
        "drysim.study.preparation.prepare", lambda *_, **__: pytest.fail("solved")
    )
    assert drysim("report", "out").code == 0
    assert drysim("report", "out", "--no-plots").code == 0
    page = Page((folder / "report.html").read_text("utf-8"))
    assert "img" not in page.tags
    assert METRICS_BY_NAME["T_a"].about in page.text


def test_report_needs_no_record(drysim, place):
    (name,) = write_records(place / "rec", 1)
    excitation = f"{{kind: record, file: {name}, column: u_dd, time: t}}"
    text = SEAT.replace("{kind: harmonic, frequency: 1.6, rms: 1.0}", excitation)
    text = text.replace("solver: {approach: stick-slip, step: 2.5e-3}\n", "")
    (place / "seat.yaml").write_text(text.replace("settle: 0, duration: 2", "settle: 0"))
    assert drysim("run", "seat.yaml", "--quiet", "-o", "out").code == 0
    (place / name).unlink()
    assert drysim("report", "out").code == 0
    page = Page((place / "out/report.html").read_text("utf-8"))
    assert page.tags.count("img") == 2  # response and sketch
    assert METRICS_BY_NAME["T_a"].about in page.text


def test_code_in_a_remark_is_shown_as_code(drysim, place):
    assert drysim("init", "seat-on-em1").code == 0
    assert drysim("run", "seat-on-em1.yaml", "--no-plots", "--report", "-o", "out").code == 0
    page = (place / "out/report.html").read_text("utf-8")
    assert "it needs a high-pass: <code>remove: {below: 0.3 Hz}</code>" in page


def test_report_needs_no_record_of_a_force(drysim, place):
    Path("force.csv").write_text("t [s],N [N]\n0,100\n1,120\n2,100\n3,100\n")
    force = "normal_record: {file: force.csv, column: N, time: t}"
    text = SEAT.replace("kinetic: 15", f"mu_kinetic: 0.15, {force}")
    (place / "seat.yaml").write_text(text)
    done = drysim("run", "seat.yaml", "--quiet", "-o", "out")
    assert done.code == 0, done.err
    Path("force.csv").unlink()
    assert drysim("report", "out").code == 0


def test_sweep_whose_best_design_keeps_the_checks_is_not_said_to_fail(result):
    swept = SEAT.replace("measure", "sweep: {friction.kinetic: [5, 60]}\nmeasure")
    page = result(swept + "checks: [T_a < 1.2]\n", "sweep")[1]
    assert '<ul class="verdict reserved">' in page
    assert "! An admissible case is known, with reservations: 1 of 1 check fails" in (
        Page(page).text
    )
    assert "keeps every check that applies to it" in Page(page).text


def test_page_shows_no_picture_that_is_not_of_the_result(result, drysim):
    folder, _ = result()
    shutil.copy(folder / "response.png", folder / "spectra.png")
    done = drysim("report", "out", "-o", "page.html")
    assert done.code == 0
    page = Page(Path("page.html").read_text("utf-8"))
    assert page.tags.count("img") == 2  # response and sketch


@pytest.mark.parametrize("name", ["response.png", "scenario.yaml"])
def test_file_that_cannot_be_read_is_no_fault_of_the_program(result, drysim, monkeypatch, name):
    folder, _ = result()
    whole = Path.open

    def refuse(self, *words, **named):
        if self.name == name and "out" in self.parts:
            raise PermissionError(13, "Permission denied", str(self))
        return whole(self, *words, **named)

    monkeypatch.setattr(Path, "open", refuse)
    done = drysim("report", folder, "-o", "page.html")
    assert done.code == (0 if name == "response.png" else 2), done.err
    assert "Traceback" not in done.err


def test_spaces_that_do_not_break_a_line_stay_in_the_text():
    assert report.visible("30\u00a0N,\u202f5 mm\u202e\u2028") == (
        "30\u00a0N,\u202f5 mm\\u202e\\u2028"
    )


def test_draft_of_a_killed_report_blocks_no_later_one(tmp_path):
    (tmp_path / "page.html.new").write_text("a draft")
    save_file(tmp_path / "page.html", "first")
    save_file(tmp_path / "page.html", "second")
    assert (tmp_path / "page.html").read_text() == "second"
    assert (tmp_path / "page.html.new").read_text() == "a draft"
    assert len([*tmp_path.iterdir()]) == 2


# What has no report: exit code 2, nothing written.


def spoil(folder, text):
    (folder / "drysim.json").write_text(text)


def replace_by_file(folder):
    shutil.rmtree(folder)
    folder.write_text("text")


def mark_by_folder(folder):
    (folder / "drysim.json").unlink()
    (folder / "drysim.json").mkdir()


FAULTS = {
    "absent": (shutil.rmtree, "no such file or directory"),
    "no folder": (shutil.rmtree, "`assess`, `design`, `branches`, `map` or `bench`"),
    "not a result": (
        lambda folder: (folder / "drysim.json").unlink(),
        "out is no result of drysim: it has no drysim.json",
    ),
    "a file": (replace_by_file, "out is a file, not a folder"),
    "marker is a folder": (mark_by_folder, "is not a plain file"),
    "no JSON": (
        lambda folder: spoil(folder, '{"format": 1, '),
        "is damaged: it is not valid JSON from line 1, column ",
    ),
    "nested": (lambda folder: spoil(folder, "[" * 100_000), "is damaged: it is not valid JSON"),
    "a list": (lambda folder: spoil(folder, "[]"), "has no finished result"),
    "begun": (
        lambda folder: spoil(folder, '{"format": 1, "complete": false}'),
        "has no finished result",
    ),
    "interrupted": (
        lambda folder: change(folder, exit_code=130, complete=False), "is not finished",
    ),
    "type": (
        lambda folder: change(folder, metrics=[1]),
        "is damaged: metrics is [1], which is not an object",
    ),
    "text for a number": (
        lambda folder: change(folder, metrics={"T_a": "high"}), "is damaged: ",
    ),
    "check": (
        lambda folder: change(folder, summary={"name": "", "checks": [{"passed": "?"}]}),
        "is damaged: ",
    ),
    "huge": (lambda folder: change(folder, metrics={"T_a": 10**400}), "is damaged: "),
    "numerics": (
        lambda folder: change(folder, numerics={"swept": 3}), "is damaged: ",
    ),
    "not a number": (
        lambda folder: change(folder, metrics={"T_a": float("nan")}),
        "is damaged: it is not valid JSON",
    ),
    "edited": (
        lambda folder: (folder / "scenario.yaml").write_text("name: other\n"),
        "scenario.yaml was edited since drysim wrote it",
    ),
    "no scenario": (lambda folder: (folder / "scenario.yaml").unlink(), "cannot read"),
}  # fmt: skip


@pytest.mark.parametrize("fault", FAULTS)
def test_folder_without_a_sound_result_has_no_report(drysim, seat, fault):
    assert drysim("run", seat, "--quiet", "--no-plots", "-o", "out").code == 0
    spoiled, words = FAULTS[fault]
    spoiled(Path("out"))
    before = {file: file.read_bytes() for file in Path().rglob("*") if file.is_file()}
    done = drysim("report", "out", "-o", "page.html")
    assert (done.code, done.out) == (2, "")
    assert words in done.err
    assert before == {file: file.read_bytes() for file in Path().rglob("*") if file.is_file()}


@pytest.mark.parametrize(
    ("file", "words"),
    [
        ("mine.html", "was not written by drysim; it stays as it is"),
        ("out/page.html", "would be a file in out that is not part of the result"),
        ("folder", "is a folder"),
        ("mine.html/page.html", "is not a folder"),
    ],
)
def test_report_replaces_nothing_but_a_report(drysim, seat, file, words):
    assert drysim("run", seat, "--quiet", "--no-plots", "-o", "out").code == 0
    Path("mine.html").write_text("<p>mine")
    Path("folder").mkdir()
    done = drysim("report", "out", "-o", file)
    assert done.code == 2
    assert words in done.err
    assert Path("mine.html").read_text() == "<p>mine"
    assert drysim("report", "out", "-o", "new.html", "--no-plots").code == 0
    assert drysim("report", "out", "-o", "new.html", "--no-plots").code == 0


def test_report_is_written_beside_files_of_the_user_and_never_over_them(drysim, seat):
    assert drysim("run", seat, "--quiet", "--no-plots", "-o", "out").code == 0
    Path("out/notes.txt").write_text("mine")
    Path("out/report.html").write_text("mine")
    done = drysim("report", "out")
    assert done.code == 2
    assert "out holds report.html, which drysim did not write" in done.err
    assert Path("out/report.html").read_text() == "mine"
    Path("out/report.html").unlink()
    assert drysim("report", "out").code == 0
    assert Path("out/report.html").is_file()
    assert Path("out/notes.txt").read_text() == "mine"


def test_removal_of_a_report_is_said(result, drysim):
    result(SAFE, "run", "--no-plots")
    for silence in ((), ("--quiet",)):
        done = drysim("run", "seat.yaml", "--no-plots", "-o", "out", *silence)
        removed = "the report of the earlier result in out will be removed with it; "
        assert done.err.startswith(removed)
        assert drysim("report", "out").code == 0
    assert drysim("run", "seat.yaml", "--no-plots", "--report", "-o", "out").err == ""


def test_removal_of_a_report_is_not_said_before_an_error(drysim):
    drysim("init", "assess-seat")
    words = ("assess", "assess-seat.yaml", "--no-plots", "-o", "out")
    assert drysim(*words, "--report").code == 0
    done = drysim(*words, "--set", "assess.measured.x_dd=sofa")
    assert done.code == 2
    assert "there is no column `sofa`" in done.err
    assert "removed" not in done.err
    assert Path("out/report.html").is_file()


# Size, Python, start-up.


def test_report_in_python_is_the_page_of_a_result(scenario):
    outcome = package.run(scenario(SEAT))
    page = Page(package.report(outcome))
    assert "none: written from Python" in page.text
    assert page.tags.count("img") == 2
    table = package.sweep(scenario(SWEPT))
    assert "Report of a sweep" in Page(package.report(table)).text
    with pytest.raises(UsageError, match="expected a result, not str"):
        package.report("out")


def test_templates_are_loaded_for_a_report_only(seat, process):
    answer = process("run", "seat.yaml", "--quiet", PYTHONPROFILEIMPORTTIME="1")
    assert "| jinja2" not in answer.err
    assert "drysim.output.report" not in answer.err


# In a browser.


@pytest.mark.slow
@pytest.mark.by_hand
@needs_browser
def test_browser_shows_the_page_without_complaint_and_prints_it(result, tmp_path):
    folder, _ = result(NOISY)
    page = (folder / "report.html").as_uri()
    shown = browse(page, "--dump-dom", tmp_path)
    assert shown.stdout.count("<img") == 3
    assert "CONSOLE" not in shown.stderr  # where a violated policy is reported
    pdf = tmp_path / "page.pdf"
    browse(page, f"--print-to-pdf={pdf}", tmp_path)
    content = pdf.read_bytes()
    assert content.startswith(b"%PDF")
    boxes = {*re.findall(rb"/MediaBox\s*\[([^\]]*)\]", content)}
    assert [[round(float(one)) for one in box.split()] for box in boxes] == [[0, 0, 595, 842]]
