"""The table of a sweep as a data frame of pandas, and pictures of results."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from seat import EM6_SEAT

import drysim
from drysim.metrics.table import METRICS
from drysim.results.frames import texts_of
from drysim.results.tables import key_column
from drysim.scenario.axes import FILE_KEY

BLOCKS = {
    "excitation.duration": 4, "stroke": None, "reference": "viscous", "checks": ["SEAT < 0.9"],
    "sweep": {"friction.kinetic": [0, 10, 20], "oscillator.damping": [150, 400]},
}  # fmt: skip


@pytest.fixture
def table(scenario):
    return drysim.sweep(scenario(EM6_SEAT, BLOCKS))


def test_frame_has_one_row_per_case_with_keys_forces_metrics_and_status(table):
    frame = table.to_frame()
    assert len(frame) == len(table) > 6
    keys = ["friction.kinetic", "oscillator.damping"]
    names = [metric.name for metric in METRICS]
    assert list(frame)[:5] == ["approach", *keys, "F_fk", "F_fs"]
    assert {*frame} == {"approach", *keys, "F_fk", "F_fs", *names, "status"}
    assert frame.attrs["units"].keys() == {*frame} - {"approach", "status"}
    for (_, line), row in zip(frame.iterrows(), table, strict=True):
        assert line["approach"] == row.approach
        assert line["status"] == row.status
        for key in keys:
            assert line[key] == row.point[key] if key in row.point else np.isnan(line[key])
        for name in names:
            value = row.metrics[name]
            assert np.isnan(line[name]) if value is None else line[name] == value


def test_frame_of_means_over_seeds_has_their_half_widths(scenario):
    table = drysim.sweep(scenario(EM6_SEAT, BLOCKS | {"excitation.seeds": 3}))
    frame = table.to_frame()
    widths = [row.half_widths["T_a"] for row in table]
    assert frame["T_a_half_width"].tolist() == widths


def test_texts_of_cells_are_those_that_were_written():
    names = ['a, "b".csv', "", "plain.csv", "two words.csv"]
    column = key_column(FILE_KEY, "")
    batch = SimpleNamespace(points={FILE_KEY: names})
    assert texts_of([column.values(batch)]) == names


def test_results_are_plotted_as_the_commands_draw_them(table, tmp_path):
    outcome = drysim.run(drysim.load(tmp_path / "seat.yaml", BLOCKS))
    for result in (table, outcome, drysim.compare(table.scenario, "signum vs stick-slip")):
        figure = drysim.plot(result)
        assert figure.texts[0].get_text() == "seat"
        figure.savefig(tmp_path / "picture.png")
        assert (tmp_path / "picture.png").read_bytes().startswith(b"\x89PNG")
    assert len(table.plot().axes) == len(drysim.plot(table).axes)
    assert len(outcome.plot().axes) == len(drysim.plot(outcome).axes)
