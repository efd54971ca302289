"""Builds HTML out of elements; the standard library writes them, so that no text can be taken for markup."""

import re
from collections.abc import Iterable, Sequence
from typing import TypeAlias
from xml.etree.ElementTree import Element, fromstring, tostring

Content: TypeAlias = "str | Element | Iterable[Content] | None"

CONTROL = re.compile(r"[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")
"""What HTML cannot carry."""


def element(tag: str, /, *content: Content, **attributes: str | None) -> Element:
    """An element around texts, elements and sequences of them; `class_` is class, `aria_label` is aria-label."""
    made = Element(tag)
    for key, value in attributes.items():
        if value is not None:
            made.set(key.rstrip("_").replace("_", "-"), _text(value))
    _fill(made, content)
    return made


def section(anchor: str, title: str, *content: Content) -> Element:
    """A part of the page with its heading."""
    return element("section", element("h2", title), *content, id=anchor)


def table(
    caption: str,
    header: Sequence[str],
    rows: Iterable[Sequence[Content] | Element],
    class_: str | None = None,
) -> Element:
    """The first cell of each row, unless it is made already, is the row's header. The table scrolls by itself where it is too wide."""
    return element(
        "div",
        element(
            "table",
            element("caption", caption) if caption else None,
            element("thead", element("tr", (element("th", head, scope="col") for head in header))),
            element("tbody", (row if isinstance(row, Element) else _row(row) for row in rows)),
            class_=class_,
        ),
        class_="scroll",
        tabindex="0",
        role="region",
        aria_label=caption or "table",
    )


def figure(picture: Element, caption: Content, *, wide: bool = False) -> Element:
    """A picture with its caption below."""
    return element("figure", picture, element("figcaption", caption), class_="wide" if wide else None)


def folded(summary: str, *content: Content) -> Element:
    """What is worth keeping and rarely worth reading."""
    return element("details", element("summary", summary), *content)


def vector(svg: str, words: str) -> Element:
    """An SVG picture's text as an element that says what it shows."""
    picture = fromstring(svg)  # noqa: S314  we drew it ourselves
    picture.set("role", "img")
    picture.set("aria-label", _text(words))
    return picture


def document(title: str, style: str, *content: Content) -> str:
    """The whole page."""
    root = element(
        "html",
        element(
            "head",
            element("meta", charset="utf-8"),
            element("meta", name="viewport", content="width=device-width, initial-scale=1"),
            element("meta", name="color-scheme", content="light dark"),
            element("title", title),
            element("style", style),
        ),
        element("body", *content),
        lang="en",
    )
    return "<!doctype html>\n" + tostring(root, encoding="unicode", method="html") + "\n"


def _row(cells: Sequence[Content]) -> Element:
    first, *rest = cells
    return element("tr", element("th", first, scope="row"), (element("td", cell) for cell in rest))


def _fill(parent: Element, content: Iterable[Content]) -> None:
    for piece in content:
        if piece is None:
            continue
        if isinstance(piece, str):
            if len(parent):
                parent[-1].tail = (parent[-1].tail or "") + _text(piece)
            else:
                parent.text = (parent.text or "") + _text(piece)
        elif isinstance(piece, Element):
            parent.append(piece)
        else:
            _fill(parent, piece)


def _text(value: str) -> str:
    return CONTROL.sub("\ufffd", value)
