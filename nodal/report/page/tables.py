"""Groups of figures as tables: of one run, and of several side by side."""

from collections.abc import Mapping
from itertools import groupby
from xml.etree.ElementTree import Element

from nodal.report.figures.model import Chapter, Figure, Group
from nodal.report.page.markup import Content, element, table
from nodal.report.page.numbers import NOTHING, difference, shown


def figure_tables(chapter: Chapter) -> Element:
    """One table for each run of groups that hold the same figures: a row a group; a single group stands upright."""
    return element(
        "div", (_table(chapter, list(alike)) for _, alike in groupby(chapter.groups, _keys)), class_="tables"
    )


def side_by_side(chapter_of: Mapping[str, Chapter | None]) -> Element:
    """One chapter of several runs by their names, as far as they have it; differences are against the first run that has the figure."""
    names = list(chapter_of)
    places: dict[tuple[str, str], dict[str, Figure]] = {}
    for name, chapter in chapter_of.items():
        for group in chapter.groups if chapter else ():
            for figure in group.figures:
                places.setdefault((group.title, figure.key), {})[name] = figure
    return table(
        "",
        ["figure", *names],
        ([_label(group, values), *_cells(names, values)] for (group, _), values in places.items()),
        class_="figures",
    )


def _table(chapter: Chapter, groups: list[Group]) -> Element:
    if len(groups) == 1:
        return table(
            groups[0].title,
            [groups[0].title, "value"],
            ((f.label, shown(f)) for f in groups[0].figures),
            class_="figures",
        )
    return table(
        chapter.title,
        [chapter.title, *(figure.label for figure in groups[0].figures)],
        ((group.title, *(shown(figure) for figure in group.figures)) for group in groups),
        class_="figures",
    )


def _keys(group: Group) -> tuple[str, ...]:
    return tuple(figure.label for figure in group.figures)


def _label(group: str, values: Mapping[str, Figure]) -> str:
    return f"{group}: {next(iter(values.values())).label}"


def _cells(names: list[str], values: Mapping[str, Figure]) -> list[Content]:
    base = next(iter(values.values()))
    cells: list[Content] = []
    for name in names:
        figure = values.get(name)
        if figure is None:
            cells.append(NOTHING)
        elif changed := difference(figure.value, base.value, base.unit):
            cells.append([shown(figure), " ", element("small", changed)])
        else:
            cells.append(shown(figure))
    return cells
