"""Pictures as SVG elements for a page of HTML: small, readable, without anything to load.

Problem
    An SVG file of matplotlib stands alone: it is several megabytes for a response of many
    points, its style sheet and its ids would affect the rest of a page, and colour maps are
    PNG images within it, which a content security policy without images blocks.

Method
    matplotlib draws with text as text and colour maps as cells. The tree of the file is then
    reduced to what is visible: no namespaces, unused ids or metadata; coordinates rounded and
    relative, cells of one colour and markers on each other merged. If it is still above the
    size limit, coordinates are rounded further and markers are thinned on a coarser raster.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping
from io import StringIO
from itertools import groupby
from typing import TYPE_CHECKING, Any, NamedTuple
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

from drysim.plots.style import SAVE_OPTIONS, import_matplotlib, picture_style

if TYPE_CHECKING:
    from matplotlib.figure import Figure


class Detail(NamedTuple):
    """Decimals of coordinates, and size of the cells that have one marker at most [pt]."""

    decimals: int
    cell: float


DETAILS = (Detail(2, 0.25), Detail(1, 0.5), Detail(1, 1.0), Detail(1, 2.0), Detail(0, 4.0))
"""Levels of detail, the finest first; a point is 1.3 pixels of a page at full width."""

FONTS = "'DejaVu Sans',Verdana,sans-serif"
"""Fonts of all text; Verdana has nearly the widths for which the text was laid out."""

RC_PARAMS: Any = {"svg.fonttype": "none", "path.simplify_threshold": 0.25}
"""Settings of matplotlib in addition to those of drysim's style."""

COLORS = 32
"""Colours of a map: few, so that many neighbouring cells have the same one."""

MANY_DOTS = 200
"""Dots above which they become one path, which is several times shorter."""

CIRCLE = re.compile(r"M 0 (\d\S*) (?:C (?:\S+ ){6}){8}z")
DOT_STYLE = re.compile(r"fill:(#\w+)(;stroke:\1(?:;stroke-width:([\d.]+))?)?")
"""A circle as a marker, and the style of one whose edge has the colour of its face."""

NO_XML = re.compile("[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")
"""Characters that XML does not allow, such as one of control in the name of a file."""

FONT_FAMILY = re.compile(r"'DejaVu Sans'(?:, (?:'[^']*'|[\w-]+))*")
NUMBER = re.compile(r"-?\d+\.\d+")
PATH_STEP = re.compile(r"([MLCQz])([^MLCQz]*)")
REFERENCE = re.compile(r"#(\w+)")


def inline_svg(
    draw: Callable[[], Figure | None], prefix: str, title: str, limit: int
) -> str | None:
    """Draw a figure and return it as an SVG element for a page of HTML.

    Parameters
    ----------
    draw : callable
        Returns the figure, or None for no picture.
    prefix : str
        Begins all ids of the picture, which no other picture of the page may share.
    title : str
        The name of the picture for those who do not see it; its heading follows as description.
    limit : int
        Size above which detail is reduced [B].

    Returns
    -------
    str or None
        The element, None without a figure.
    """
    with picture_style(), import_matplotlib().rc_context(RC_PARAMS):
        if (figure := draw()) is None:
            return None
        meshes: list[Any] = figure.findobj(lambda artist: artist.get_rasterized())
        for mesh in meshes:
            mesh.set_rasterized(False)
            mesh.set_cmap(mesh.get_cmap().resampled(COLORS))
        file = StringIO()
        figure.savefig(file, format="svg", **SAVE_OPTIONS[".svg"])
        description = " ".join(words.get_text() for words in figure.texts)
    title, description = (NO_XML.sub("\ufffd", text) for text in (title, description))
    content = NO_XML.sub("\ufffd", file.getvalue())
    for detail in DETAILS:
        root = ElementTree.fromstring(content)
        page_element(root, prefix, title, description, detail)
        text = ElementTree.tostring(root, encoding="unicode")
        if len(text.encode()) <= limit:
            break
    return text


def page_element(
    root: Element, prefix: str, title: str, description: str, detail: Detail
) -> None:
    """Turn the tree of an SVG file into an element of a page."""
    parents = {child: parent for parent in root.iter() for child in parent}
    for element in list(root.iter()):
        element.tag = element.tag.rpartition("}")[2]
        element.attrib = {
            name.rpartition("}")[2]: value for name, value in element.attrib.items()
        }
        element.tail = None
        if element.tag not in ("text", "tspan"):
            element.text = None
        if element.tag in ("metadata", "style"):
            parents[element].remove(element)
    names = f"{prefix}title", f"{prefix}desc"
    width, height = root.attrib["viewBox"].split()[2:]
    root.attrib = {
        "role": "img",
        "aria-labelledby": " ".join(names),
        "viewBox": f"0 0 {width} {height}",
        "font-family": FONTS,
        "stroke-linejoin": "round",
    }
    for group in list(root.iter("g")):
        merge_cells(group)
    used = dict.fromkeys(REFERENCE.findall(" ".join(references(root))))
    ids = {name: f"{prefix}{number}" for number, name in enumerate(used)}
    dots = {
        f"#{ids[name]}": 2 * float(circle[1])
        for name, path in paths_by_id(root)
        if name in ids and (circle := CIRCLE.match(" ".join(path.split())))
    }
    for element in root.iter():
        clean_attributes(element, ids, detail)
    for group in list(root.iter("g")):
        merge_markers(group, dots, detail)
    for at, (tag, text) in enumerate((("title", title), ("desc", description))):
        label = Element(tag, {"id": names[at]})
        label.text = text
        root.insert(at, label)


def paths_by_id(root: Element) -> Iterator[tuple[str, str]]:
    """Yield id and data of every path that has an id."""
    for path in root.iter("path"):
        if "id" in path.attrib:
            yield path.attrib["id"], path.attrib["d"]


def references(root: Element) -> Iterator[str]:
    """Yield the attributes that refer to ids."""
    for element in root.iter():
        yield from (element.attrib.get(name, "") for name in ("href", "clip-path"))


def clean_attributes(element: Element, ids: Mapping[str, str], detail: Detail) -> None:
    """Round numbers, replace ids by those of the page, and shorten the style of an element."""
    attributes = element.attrib
    if attributes.get("id") not in ids:
        attributes.pop("id", None)
    for name, value in attributes.items():
        if name == "id":
            attributes[name] = ids[value]
        elif name in ("href", "clip-path"):
            attributes[name] = REFERENCE.sub(lambda found: f"#{ids[found[1]]}", value)
        elif name == "d":
            # A marker is a small shape, drawn many times.
            attributes[name] = short_path(value, 2 if "id" in attributes else detail.decimals)
        elif name in ("x", "y", "width", "height"):
            # Matplotlib before 3.10 gives each letter of a formula its own place.
            places = map(float, value.split())
            attributes[name] = " ".join(short_number(one, detail.decimals) for one in places)
        elif name == "transform":
            attributes[name] = NUMBER.sub(lambda found: short_number(float(found[0]), 2), value)
        elif name == "style":
            style = FONT_FAMILY.sub(FONTS, value).replace(f"font-family: {FONTS}", "")
            attributes[name] = re.sub(r"[; ]*;[; ]*", ";", style.replace(": ", ":")).strip("; ")
    if not attributes.get("style", "-"):
        del attributes["style"]


CELL = re.compile(r"M (\S+) (\S+) L (\S+) \2 L \3 (\S+) L \1 \4 L \1 \2")
"""A rectangle, as the cell of a map is drawn."""


def merge_cells(group: Element) -> None:
    """Merge the cells of a map in a row that have one colour, then all of one colour."""
    children = list(group)
    found = [CELL.fullmatch(" ".join(one.attrib.get("d", "").split())) for one in children]
    if len(children) < 2 or not all(found):
        return
    rows: list[list[str]] = []
    for child, cell in zip(children, found, strict=True):
        assert cell is not None, "that was checked"
        x, y, right, upper = cell.groups()
        style = child.attrib["style"]
        if rows and rows[-1] == [rows[-1][0], y, x, upper, style]:
            rows[-1][2] = right
        else:
            rows.append([x, y, right, upper, style])
    colors: dict[str, list[str]] = {}
    for x, y, right, upper, style in rows:
        path = f"M {x} {y} L {right} {y} L {right} {upper} L {x} {upper} z"
        colors.setdefault(style, []).append(path)
    shared = children[0].attrib
    for child in children:
        group.remove(child)
    for style, paths in colors.items():
        group.append(Element("path", {**shared, "d": " ".join(paths), "style": style}))
    group.attrib["shape-rendering"] = "crispEdges"  # no seams between cells


def merge_markers(group: Element, dots: Mapping[str, float], detail: Detail) -> None:
    """Merge markers of a group that lie on each other; draw many dots as one path.

    Parameters
    ----------
    group : Element
    dots : mapping
        Reference of every marker that is a circle to its diameter [pt].
    detail : Detail
    """
    children = list(group)
    for child in children:
        group.remove(child)
    for key, run in groupby(children, marker_key):
        markers = list(run)
        if not key or len(markers) == 1:
            group.extend(markers)
            continue
        cells: dict[tuple[int, int], tuple[float, float]] = {}
        for marker in markers:
            x, y = float(marker.attrib["x"]), float(marker.attrib["y"])
            cells.setdefault((round(x / detail.cell), round(y / detail.cell)), (x, y))
        href, style = key
        color = DOT_STYLE.fullmatch(style)
        if href in dots and color and len(cells) > MANY_DOTS:
            edge = float(color[3] or 1.0) if color[2] else 0.0
            width = short_number(dots[href] + edge, 2)
            style = f"fill:none;stroke:{color[1]};stroke-width:{width};stroke-linecap:round"
            path = dotted_path(list(cells.values()), detail.decimals)
            group.append(Element("path", {"d": path, "style": style}))
            continue
        marked = Element("g", {"style": style})
        for x, y in cells.values():
            place = (short_number(one, detail.decimals) for one in (x, y))
            marked.append(Element("use", {"href": href, **dict(zip("xy", place, strict=True))}))
        group.append(marked)


def dotted_path(points: list[tuple[float, float]], decimals: int) -> str:
    """Return the data of a path of points, which a round line cap makes visible."""
    scale, words, at = 10**decimals, [], (0, 0)
    for x, y in points:
        here = round(x * scale), round(y * scale)
        step = (short_number((a - b) / scale, decimals) for a, b in zip(here, at, strict=True))
        words.append(f"m{' '.join(step).replace(' -', '-')}v0")
        at = here
    return "".join(words)


def marker_key(element: Element) -> tuple[str, ...]:
    """Return shape and style of a marker; empty for anything else."""
    attributes = element.attrib
    if element.tag == "use" and attributes.keys() == {"href", "x", "y", "style"}:
        return attributes["href"], attributes["style"]
    return ()


def short_path(path: str, decimals: int) -> str:
    """Return the data of a path with rounded coordinates, relative to the previous point."""
    words: list[str] = []
    scale, last = 10**decimals, ""
    at, start = (0, 0), (0, 0)

    def add(letter: str, *steps: int) -> None:
        nonlocal last
        numbers = " ".join(short_number(step / scale, decimals) for step in steps)
        separator = "" if letter != last or numbers.startswith("-") else " "
        words.append((letter if letter != last else separator) + numbers.replace(" -", "-"))
        last = letter

    for command, numbers in PATH_STEP.findall(path):
        values = [round(float(number) * scale) for number in numbers.split()]
        points = list(zip(values[::2], values[1::2], strict=True))
        if command == "z":
            add("z")
            at = start
            continue
        if command == "M":
            add("M", *points[0])
            at = start = points[0]
            continue
        steps = [(x - at[0], y - at[1]) for x, y in points]
        at = points[-1]
        (dx, dy) = steps[-1]
        if command == "L" and not dx:
            if dy or last not in ("l", "h", "v"):
                add("v", dy)
        elif command == "L" and not dy:
            add("h", dx)
        else:
            add(command.lower(), *(number for step in steps for number in step))
    return "".join(words)


def short_number(value: float, decimals: int) -> str:
    """Return a number without needless zeros, such as `.5` for 0.50."""
    text = f"{value:.{decimals}f}"
    if "." in text:
        text = text.rstrip("0").rstrip(".")
    if text in ("-0", ""):
        return "0"
    return text.replace("0.", ".", 1) if text.startswith(("0.", "-0.")) else text
