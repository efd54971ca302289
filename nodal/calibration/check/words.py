"""A finding of `nodal calibration check` as people read it."""

from collections.abc import Iterator

from nodal.calibration.check.verdict import CameraFinding, Finding


def words(finding: Finding) -> Iterator[str]:
    """One line after the other."""
    for one in finding.cameras:
        yield f"camera {one.camera}: {_camera(one)}"
    sensing = finding.sensing
    if sensing.shapes:
        residuals = ", ".join(f"{name} {residual:.2f} px" for name, residual in sensing.residual_px.items())
        yield (
            f"sensing: {sensing.shapes} shapes, {sensing.share_off:.0%} of them say that the calibration is off; a picture seems to lie "
            f"{sensing.ray_bias_mm:.3f} mm elsewhere; residuals {residuals}"
        )
    else:
        yield "sensing: no shape in any of the looks"
    yield finding.verdict
    if finding.advice:
        yield f"what to do: {finding.advice}"


def _camera(one: CameraFinding) -> str:
    if one.moved is None:
        return one.reason
    x, y = one.shift_px
    size = (x**2 + y**2) ** 0.5
    lies = f"its scenery lies {x:+.2f} px to the right, {y:+.2f} px down of where it lay (known to {one.sigma_px:.2f} px)"
    if not one.moved:
        return f"{lies}: where it was"
    since = (
        "since before the first look"
        if one.since_s is None
        else f"since {one.since_s:.1f} s after the first look"
    )
    turned = f" and {one.turn_mrad:+.1f} mrad about its line of sight" if abs(one.turn_mrad) > 1.5 else ""
    return f"{lies}: moved by {size:.2f} px, {one.robot_mm:.2f} mm at the robot, as if turned by {one.angle_deg:.3f} degrees{turned}, {since}"
