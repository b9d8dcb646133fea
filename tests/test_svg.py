"""Pictures as elements of a page: what is drawn stays, what is not needed goes."""

from __future__ import annotations

import re
from xml.etree import ElementTree

import numpy as np
import pytest

from drysim.plots import svg


def figure(points=50, title="a < b & xᵣ, $5 or $6"):
    from matplotlib.figure import Figure

    made = Figure()
    axes = made.add_subplot()
    axes.plot(np.arange(points), np.sin(np.arange(points)), ".", clip_on=False)
    made.text(0.1, 0.9, title)
    return made


def test_picture_is_one_element_with_a_role_a_title_and_a_description():
    root = ElementTree.fromstring(svg.inline_svg(figure, "a-", "One <picture>", 10**6))
    assert root.tag == "svg"
    assert root.attrib["role"] == "img"
    label, description = root[0], root[1]
    assert root.attrib["aria-labelledby"] == f"{label.attrib['id']} {description.attrib['id']}"
    assert (label.tag, label.text) == ("title", "One <picture>")
    assert (description.tag, description.text) == ("desc", "a < b & xᵣ, $5 or $6")


def test_ids_are_those_that_are_used_and_begin_with_the_prefix():
    text = svg.inline_svg(figure, "a-", "Title", 10**6)
    ids = re.findall(r' id="([^"]*)"', text)
    used = re.findall(r"#([\w-]+)", re.sub(r"(fill|stroke):#\w+", "", text))
    assert all(name.startswith("a-") for name in ids)
    assert {*used} <= {*ids}
    assert {*ids} <= {*used, "a-title", "a-desc"}


def test_nothing_in_a_picture_is_loaded_or_affects_the_rest_of_a_page():
    text = svg.inline_svg(figure, "a-", "Title", 10**6)
    assert not re.search(r"<(style|image|script|metadata)|xmlns|https?:|data:", text)


def test_same_figure_gives_the_same_text():
    one, other = (svg.inline_svg(figure, "a-", "Title", 10**6) for _ in range(2))
    assert one == other


def test_colour_map_is_drawn_as_cells():
    def drawn():
        from matplotlib.figure import Figure

        made = Figure()
        axes = made.add_subplot()
        mesh = axes.pcolormesh([[0, 0, 1, 2], [2, 1, 1, 0]], rasterized=True)
        made.colorbar(mesh)
        return made

    text = svg.inline_svg(drawn, "a-", "Title", 10**6)
    assert "<image" not in text
    found = re.findall(r'<g shape-rendering="crispEdges">(.*?)</g>', text)
    cells = [re.findall(r'<path [^>]*d="([^"]*)"', group) for group in found]
    assert [sum(path.count("M") for path in paths) for paths in cells] == [6, 32]
    assert [len(paths) for paths in cells] == [3, 32]


def test_many_markers_are_thinned_until_the_picture_is_small_enough():
    full = svg.inline_svg(lambda: figure(20_000), "a-", "Title", 10**8)
    small = svg.inline_svg(lambda: figure(20_000), "a-", "Title", 100_000)
    assert len(small) <= 100_000 < len(full)
    assert small.count("v0") > 4000


def test_character_that_xml_does_not_allow_is_replaced():
    text = svg.inline_svg(lambda: figure(title="bell \a"), "a-", "Title \a", 10**6)
    assert "bell \ufffd" in ElementTree.fromstring(text)[1].text


def test_no_figure_is_no_picture():
    assert svg.inline_svg(lambda: None, "a-", "Title", 1000) is None


@pytest.mark.parametrize("decimals", [0, 1, 2])
def test_path_is_that_of_the_file_to_its_decimals(decimals):
    points = np.random.default_rng(1).uniform(-50, 600, (200, 2))
    path = "M" + "L".join(f" {x} {y} " for x, y in points) + "z M 1 2 L 3.5 4 L 3.501 4.001"
    short = svg.short_path(path, decimals)
    found = []
    for command, numbers in re.findall(r"([Mlhvz])([^Mlhvz]*)", short):
        values = [float(one) for one in re.findall(r"-?(?:\d*\.\d+|\d+)", numbers)]
        if command in "hv":
            values = np.outer(values, [command == "h", command == "v"]).ravel()
        for at in range(0, len(values), 2):
            step = np.array(values[at : at + 2])
            found.append(step if command == "M" else found[-1] + step)
    wanted = [*points, (1.0, 2.0), (3.5, 4.0)]
    assert len(found) == len(wanted)
    assert np.abs(np.array(found) - wanted).max() <= 0.5000001 * 10**-decimals


@pytest.mark.parametrize(
    ("value", "text"), [(0.0, "0"), (-0.001, "0"), (0.5, ".5"), (-0.25, "-.25"), (100.0, "100")]
)
def test_number_has_no_needless_characters(value, text):
    assert svg.short_number(value, 2) == text
