"""What every kind of result can do in Python: pictures, tables, files, reports, notebooks."""

from __future__ import annotations

import copy
import csv
import dataclasses
import html
import json
import math
import pickle
import sys
from pathlib import Path
from types import ModuleType

import numpy as np
import pandas
import pytest
from every_kind import WAYS, result_of
from seat import SEAT
from shown import leave_pictures_empty

import drysim
from drysim.errors import OutputError, UsageError
from drysim.plots.style import panel_grid
from drysim.results import KINDS, kind_named
from drysim.results.fields import header_fields
from drysim.results.kind import File, Kind, Picture
from drysim.results.notebook import table_html
from drysim.results.stored import metric_tables
from drysim.results.tables import COLUMN_UNITS
from drysim.study.outcome import Result
from drysim.study.summary import Summary

every_kind = pytest.mark.parametrize("kind", KINDS)


@pytest.fixture(scope="module")
def saved(tmp_path_factory):
    """Return a function that saves a result of a kind once, and returns the folder."""
    folders = {}

    def folder(kind):
        if kind not in folders:
            out = tmp_path_factory.mktemp("saved") / kind
            with pytest.MonkeyPatch.context() as patch:
                leave_pictures_empty(patch)
                folders[kind] = result_of(kind).save(out, report=True)
        return folders[kind]

    return folder


@pytest.mark.parametrize("kind", [name for name in KINDS if name != "hard"])
def test_units_of_all_metrics_are_in_drysim_json(saved, kind):
    fields = json.loads((saved(kind) / "drysim.json").read_text())
    names = [name for _, table in metric_tables(fields["metrics"]) for name in table]
    assert fields["units"] == {name: COLUMN_UNITS[name] for name in names}
    for check in fields["checks"]:
        assert check["unit"] == COLUMN_UNITS[check["metric"]]
        assert check["check"].startswith(f"{check['metric']} {check['operator']}")


def tables_of(kind):
    """Return the names of the tables of a kind."""
    return [Path(f.name).stem for f in kind_named(kind).files if f.name.endswith(".csv")]


@every_kind
def test_saved_result_is_a_folder_of_the_commands(saved, kind, drysim):
    folder = saved(kind)
    fields = json.loads((folder / "drysim.json").read_text())
    assert (fields["kind"], fields["complete"]) == (kind, True)
    assert fields["files"].keys() == {file.name for file in folder.iterdir()} - {"drysim.json"}
    assert f"{tables_of(kind)[0]}.csv" in fields["files"]
    shown = drysim("summarise", folder)
    assert (shown.code, "none: written from Python" in shown.out) == (0, True)


@every_kind
def test_saved_result_has_the_pictures_and_the_report_that_were_asked_for(
    saved, kind, tmp_path
):
    names = {file.name for file in saved(kind).iterdir()}
    assert "report.html" in names
    pictures = [f"{one.name}.png" for one in kind_named(kind).pictures]
    assert {*pictures[:1]} <= names
    bare = {
        file.name for file in result_of(kind).save(tmp_path / "bare", plots=False).iterdir()
    }
    assert bare == names - {"report.html", *pictures}


def test_saved_result_replaces_nothing_but_a_result(tmp_path):
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine/notes.txt").write_text("mine")
    with pytest.raises(OutputError, match="it stays as it is"):
        result_of("run").save(tmp_path / "mine")
    assert [file.name for file in (tmp_path / "mine").iterdir()] == ["notes.txt"]
    out = result_of("run").save(tmp_path / "out", plots=False)
    assert result_of("run").save(str(out), plots=False) == out


def number(cell):
    """Return a cell of a column of numbers, NaN if it is empty."""
    return float(cell or "nan")


@every_kind
def test_frames_hold_what_the_csv_files_hold(saved, kind):
    for name in tables_of(kind):
        file = saved(kind) / f"{name}.csv"
        if not file.exists():
            with pytest.raises(UsageError, match=f"there is nothing for the table `{name}`"):
                result_of(kind).to_frame(name)
            continue
        with file.open(encoding="utf-8", newline="") as lines:
            headers, *rows = csv.reader(lines)
        frame = result_of(kind).to_frame(name)
        units = frame.attrs["units"]
        assert len(frame) == len(rows)
        for i, header in enumerate(headers):  # a sweep has further metrics behind
            column = frame.columns[i]
            assert header == (f"{column} [{units[column]}]" if column in units else column)
            cells, values = [row[i] for row in rows], frame[column].tolist()
            if pandas.api.types.is_numeric_dtype(frame[column]):
                assert np.array_equal(values, [*map(number, cells)], equal_nan=True)
            else:
                assert values == cells


@every_kind
def test_main_table_and_main_picture_are_the_first(kind):
    result = result_of(kind)
    first = result.to_frame(tables_of(kind)[0])
    pandas.testing.assert_frame_equal(result.to_frame()[[*first]], first)
    if kind_named(kind).pictures:
        main = result.plot(kind_named(kind).pictures[0].name)
        assert len(result.plot().axes) == len(drysim.plot(result).axes) == len(main.axes)


@every_kind
def test_every_picture_that_the_command_writes_is_drawn(saved, kind):
    names = [one.name for one in kind_named(kind).pictures]
    if not names:
        with pytest.raises(UsageError, match="there are no pictures of the hard cases"):
            result_of(kind).plot()
    for name in names:
        if (saved(kind) / f"{name}.png").exists():
            assert result_of(kind).plot(name).axes
        else:
            with pytest.raises(UsageError, match=f"there is nothing for the picture `{name}`"):
                result_of(kind).plot(name)


def new_figure():
    """Return an empty figure of matplotlib."""
    from matplotlib.figure import Figure

    return Figure()


@every_kind
def test_picture_of_one_panel_is_drawn_into_given_axes_and_others_leave_them_empty(saved, kind):
    for picture in kind_named(kind).pictures:
        if not (saved(kind) / f"{picture.name}.png").exists():
            continue
        result, figure = result_of(kind), new_figure()
        above, _ = figure.subplots(2)
        own = result.plot(picture.name)
        panels = [axes for axes in own.axes if axes.get_label() != "<colorbar>"]
        if len(panels) > 1:
            with pytest.raises(UsageError, match="panels, and `ax` can hold one"):
                result.plot(picture.name, ax=above)
            assert not above.has_data()
            assert above.get_title(loc="left") == ""
        else:
            assert result.plot(picture.name, ax=above) is figure
            assert len(above.lines) == len(panels[0].lines) > 0
            labels = above.get_xlabel(), above.get_ylabel(), above.get_title(loc="left")
            (other,) = panels
            assert labels == (
                other.get_xlabel(),
                other.get_ylabel(),
                other.get_title(loc="left"),
            )
            assert [text.get_text() for text in above.get_legend().get_texts()]
            assert len(figure.axes) == 1 + len(own.axes)


@pytest.mark.parametrize("value", [[], np.empty(2), "response", {}])
def test_only_axes_can_be_drawn_into(value):
    with pytest.raises(UsageError, match="expected axes of matplotlib, not"):
        result_of("design").plot(ax=value)


def test_unknown_picture_or_table_is_an_error_that_names_those_there_are():
    outcome = result_of("run")
    with pytest.raises(UsageError, match=r"no picture `responce` of one case; did you mean `r"):
        outcome.plot("responce")
    with pytest.raises(UsageError, match=r"`x` of a fit; use one of fit, residuals"):
        result_of("fit").to_frame("x")
    for value in ("seat.yaml", None, outcome.metrics):
        with pytest.raises(UsageError, match=r"expected a result, not") as fault:
            drysim.plot(value)
        assert "pass what drysim.run" in fault.value.hint


def test_table_without_rows_has_columns_of_numbers():
    frame = result_of("branches").to_frame("bifurcations")
    assert len(frame) == 0
    assert [*frame][:3] == ["bifurcation", "branch", "friction.kinetic"]
    assert frame["branch"].dtype == float


def test_missing_pandas_is_an_error_that_names_the_package(monkeypatch):
    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(UsageError, match="needs the package pandas") as fault:
        result_of("run").to_frame()
    assert "drysim[pandas]" in fault.value.hint


@every_kind
def test_report_is_returned_or_written(kind, tmp_path):
    result = result_of(kind)
    page = result.report()
    assert "<h1>" in page
    file = result.report(tmp_path / "a.html")
    assert file == tmp_path / "a.html"
    assert file.read_text(encoding="utf-8").startswith(page[:1000])


@every_kind
def test_notebooks_show_the_summary(kind):
    result = result_of(kind)
    assert "\n" not in repr(result)
    assert len(repr(result)) < 300
    page, summary = result._repr_html_(), kind_named(kind).summary(result)
    texts = [repr(result)]
    for each in (summary, *summary.parts):
        texts += [row.value for rows in each.groups for row in rows]
        texts += [
            text for column in (each.table.columns if each.table else ()) for text in column
        ]
        texts += [check.sentence for check in each.checks]
    assert [text for text in texts if html.escape(text) not in page] == []


def test_text_in_a_notebook_is_escaped():
    assert table_html([("<script>",)], ("a & b",)) == (
        "<table><tr><th>a &amp; b</th></tr><tr><td>&lt;script&gt;</td></tr></table>"
    )


TIMED = ("bench", "hard")
"""Kinds that hold computing times, which no second run repeats."""


@every_kind
def test_result_equals_its_copies_and_the_same_work_done_again(kind):
    result = result_of(kind)
    for again in (pickle.loads(pickle.dumps(result)), copy.copy(result), copy.deepcopy(result)):
        assert again == result
        assert hash(again) == hash(result)
    assert (WAYS[kind]() == result) == (kind not in TIMED)


@every_kind
def test_result_differs_from_one_of_another_scenario_or_with_other_numbers(kind):
    result = result_of(kind)
    names = [one.name for one in dataclasses.fields(result) if one.compare]
    given = [name for name in names if getattr(result, name) is not None]
    others = [dataclasses.replace(result, **{name: None}) for name in given]
    assert others
    assert result not in others
    assert result not in [result_of(other) for other in KINDS if other != kind]
    assert result != repr(result)


def test_outcomes_with_other_friction_differ():
    (first, second) = (
        drysim.run(drysim.scenario(SEAT, {"friction.kinetic": x})) for x in (15, 16)
    )
    assert first != second
    assert first == drysim.run(first.scenario)
    other = dataclasses.replace(first, metrics=first.metrics | {"T_a": math.nan})
    assert first != other
    assert other == copy.deepcopy(other)


WITHOUT_CHECKS = "bench", "hard", "fit"
"""Kinds that measure approaches, and one whose scenario states no checks here."""


@pytest.mark.parametrize("kind", [name for name in KINDS if name not in WITHOUT_CHECKS])
def test_checks_of_a_scenario_are_judged_or_said_to_be_skipped(saved, kind):
    result = result_of(kind)
    assert len(result.checks) >= len(result.scenario.checks) > 0
    skipped = [verdict for verdict in result.checks if verdict.passed is None]
    assert bool(skipped) == (kind in ("branches", "map"))
    assert result.exit_code() == 0
    assert result.exit_code(strict=True) == bool(skipped or result.warnings)
    page = (saved(kind) / "report.html").read_text(encoding="utf-8")
    assert "The scenario has no checks" not in page
    assert ("No verdict, and reservations: " in page) == bool(skipped)


@dataclasses.dataclass(frozen=True)
class Note(Result):
    """A result of a kind that drysim does not have."""

    text: str
    kind = "note"
    checks = warnings = ()


def test_kind_is_added_by_its_file_and_a_line(tmp_path, monkeypatch, drysim):
    note_kind = Kind(
        name="note",
        what="a note",
        files=(File("note.csv", lambda note, file: file.write_text(f"text\n{note.text}\n")),),
        pictures=(Picture("note", "note.draw", "An empty panel"),),
        fields=lambda note, provenance: {
            **header_fields("note", provenance),
            "scenario": {"name": "note"},
            "software": {},
            **{key: {} for key in ("numerics", "metrics")},
            **{key: [] for key in ("checks", "warnings")},
            "files": provenance.files,
        },
        summary=lambda note: Summary(name="note", scene=(("text", note.text),)),
        scenario=lambda note: None,
    )
    results_file, plots_file = ModuleType("drysim.results.note"), ModuleType("note")
    results_file.NOTE, plots_file.draw = note_kind, lambda note: panel_grid(1, 1)[0]
    monkeypatch.setitem(sys.modules, "drysim.results.note", results_file)
    monkeypatch.setitem(sys.modules, "drysim.plots.note", plots_file)
    monkeypatch.setitem(KINDS, "note", "note.NOTE")  # the line
    note = Note("all is well")
    folder = note.save(tmp_path / "note")
    names = ["drysim.json", "note.csv", "note.png"]
    assert sorted(file.name for file in folder.iterdir()) == names
    assert note.to_frame()["text"].tolist() == ["all is well"]
    assert note.plot().axes == []
    assert "all is well" in note._repr_html_()
    shown = drysim("summarise", folder)
    assert (shown.code, "all is well" in shown.out) == (0, True)
    assert note.save(folder, plots=False) == folder  # it is recognised as drysim's
    assert sorted(file.name for file in folder.iterdir()) == names[:2]
