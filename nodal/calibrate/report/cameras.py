"""The cameras in figures, and how good each is."""

from nodal.calibrate.cameras.verdict import judgements
from nodal.calibrate.cameras.words import camera_rows, places, value_of
from nodal.calibrate.report.levels import LEVELS
from nodal.calibrate.report.material import Material
from nodal.report.page.markup import Content, element, table

TITLE = "Cameras"
NO_BREAK = "\u00a0"


def content(known: Material) -> Content:
    """Parameters with their standard deviations, then one judgement a row."""
    header, *rows = camera_rows(known.cameras)
    return [
        table("Cameras", header, rows, class_="figures"),
        [element("p", text) for text in places(known.cameras)],
        element("h3", "Judged"),
        table(
            "Judgements",
            ["what", "value", "verdict", "good up to", "fair up to", "because"],
            (
                (
                    one.what,
                    value_of(one).replace(" ", NO_BREAK),
                    element("strong", str(one.grade), class_=f"level {LEVELS[one.grade]}"),
                    f"{one.limits[0]:g}{NO_BREAK}{one.unit}",
                    f"{one.limits[1]:g}{NO_BREAK}{one.unit}",
                    one.why,
                )
                for one in judgements(known.cameras)
            ),
        ),
    ]
