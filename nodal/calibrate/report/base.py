"""Where the robot stands, each way it was found, and how far the two lie apart."""

import numpy as np

from calibration.base import Base, BasesFound, difference
from nodal.calibrate.base.keeping import BASE
from nodal.calibrate.report.material import Material
from nodal.report.page.markup import Content, element, table
from nodal.report.page.numbers import with_unit

TITLE = "Robot frame"


def content(known: Material) -> Content:
    """Of these very cameras; what was found for others says nothing any more."""
    found = known.found(BASE, BasesFound)
    if found is None:
        return None
    bases = [
        base for base in (found.board, found.robot) if base and base.cameras_made_at == known.cameras.made_at
    ]
    if not bases:
        return element(
            "p", "The cameras were calibrated since the robot frame was found: it must be found again."
        )
    return [
        element(
            "p",
            f"The calibration file has the robot frame by the {found.used}. Values with ± are standard deviations.",
        ),
        table(
            "Robot frames",
            [
                "by the",
                "origin in the first camera's frame",
                "origin",
                "axis",
                "roll",
                "residual",
                "found at",
            ],
            map(_row, bases),
        ),
        _apart(bases),
        element("div", known.drawn("base-{}.jpg"), class_="moments"),
    ]


def _row(base: Base) -> list[str]:
    x, y, z = base.matrix[:3, 3]
    residual = ", ".join(f"{name} {with_unit(px, 'px')}" for name, px in base.residual_px.items())
    return [
        base.way,
        f"{x:.2f}, {y:.2f}, {z:.2f} mm",
        f"± {with_unit(base.origin_sigma_mm, 'mm')}",
        f"± {np.degrees(base.axis_sigma_rad):.3f}°",
        f"± {np.degrees(base.roll_sigma_rad):.3f}°",
        f"{residual}; {with_unit(base.residual_mm, 'mm')}",
        base.made_at,
    ]


def _apart(bases: list[Base]) -> Content:
    if len(bases) < 2:
        return None
    apart = difference(*bases)
    return table(
        "Board and robot",
        ["board and robot apart", "is", "allowed"],
        (
            ("origin", with_unit(apart.origin_mm, "mm"), with_unit(apart.allowed_origin_mm, "mm")),
            *(
                (name, f"{np.degrees(abs(is_rad)):.3f}°", f"{np.degrees(allowed_rad):.3f}°")
                for name, is_rad, allowed_rad in (
                    ("axis", apart.axis_rad, apart.allowed_axis_rad),
                    ("roll", apart.roll_rad, apart.allowed_roll_rad),
                )
            ),
        ),
        class_="figures",
    )
