"""Groups of figures as tables: of one run, and of several side by side."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import groupby
from xml.etree.ElementTree import Element

from nodal.report.figures.model import Chapter, Figure, Group
from nodal.report.page.markup import Content, element, table
from nodal.report.page.numbers import NOTHING, difference, shown


def figure_tables(chapter: Chapter) -> Element:
    """One table for each run of groups that hold the same figures: a row a group; a single group stands upright."""
    return element(
        "div",
        (
            _table(chapter, list(alike))
            for _, alike in groupby(chapter.groups, lambda group: _labels([group]))
        ),
        class_="tables",
    )


def side_by_side(chapter_of: Mapping[str, Chapter]) -> list[Element]:
    """One chapter of several runs by their names; differences are against the first run that has a figure."""
    places: dict[str, dict[str, Group]] = {}
    for name, chapter in chapter_of.items():
        for group in chapter.groups:
            places.setdefault(group.title, {})[name] = group
    return [
        table(
            "",
            ["", "run", *labels],
            (row for title in titles for row in _rows(title, labels, places[title])),
            class_="figures compared",
        )
        for labels, titles in groupby(places, lambda title: _labels(places[title].values()))
    ]


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
        ["", *(figure.label for figure in groups[0].figures)],
        ((group.title, *(shown(figure) for figure in group.figures)) for group in groups),
        class_="figures",
    )


def _labels(groups: Iterable[Group]) -> tuple[str, ...]:
    """Of every figure, whichever run has it."""
    return tuple(dict.fromkeys(figure.label for group in groups for figure in group.figures))


def _rows(title: str, labels: Sequence[str], groups: Mapping[str, Group]) -> Iterator[Element]:
    """A row for each run, under one heading."""
    figures = {name: {figure.label: figure for figure in group.figures} for name, group in groups.items()}
    for number, (name, known) in enumerate(figures.items()):
        yield element(
            "tr",
            element("th", title, scope="rowgroup", rowspan=str(len(figures))) if number == 0 else None,
            element("th", name, scope="row"),
            (element("td", _compared(known.get(label), label, figures)) for label in labels),
        )


def _compared(figure: Figure | None, label: str, figures: Mapping[str, Mapping[str, Figure]]) -> Content:
    """The figure, and how it differs from that of the first run that has it."""
    if figure is None:
        return NOTHING
    base = next(known[label] for known in figures.values() if label in known)
    changed = difference(figure.value, base.value, base.unit)
    return [shown(figure), " ", element("small", changed)] if changed else shown(figure)
