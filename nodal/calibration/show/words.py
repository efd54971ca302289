"""A calibration's figures as people read them."""

from collections.abc import Iterator

from nodal.calibration.show.figures import MEASURED_PX, Figures, SeenCamera

SIGMA_WORDS = {
    "fx_px": "fx {:.2f} px",
    "fy_px": "fy {:.2f} px",
    "cx_px": "cx {:.2f} px",
    "cy_px": "cy {:.2f} px",
    "x_mm": "x {:.3f} mm",
    "y_mm": "y {:.3f} mm",
    "z_mm": "z {:.3f} mm",
}


def words(found: Figures) -> Iterator[str]:
    """One line after the other."""
    frame = (
        "the robot frame"
        if found.frame == "robot"
        else "the first camera's frame; the robot frame is not known"
    )
    made = f", made {found.made_at}" if found.made_at else ""
    yield f"{len(found.cameras)} cameras in {frame}{made}; lengths in mm"
    for camera in found.cameras:
        yield from _camera(camera, found.place)
    for pair in found.pairs:
        yield f"{pair.names[0]} and {pair.names[1]}"
        yield f"  stand {pair.baseline_mm:.1f} mm apart and see it at an angle of {pair.angle_deg:.1f} degrees"
        yield (
            f"  {MEASURED_PX:g} px in both pictures is {pair.across_mm:.3f} mm across and {pair.depth_mm:.3f} mm in depth, "
            f"{found.place}"
        )
    if found.board_error_mm is not None:
        yield f"the board's own squares came out to {found.board_error_mm:.3f} mm (RMS) in views that were held out"


def _camera(camera: SeenCamera, place: str) -> Iterator[str]:
    (width, height), (fx, fy), (across, down) = camera.size_px, camera.focal_px, camera.field_of_view_deg
    (cx, cy), (off_x, off_y) = camera.principal_point_px, camera.off_centre_px
    yield camera.name
    yield f"  {width}x{height} px, focal length {fx:.1f} and {fy:.1f} px: it sees {across:.1f} degrees across, {down:.1f} down"
    yield f"  principal point {cx:.1f}, {cy:.1f} px, {off_x:+.1f}, {off_y:+.1f} from the middle"
    yield f"  the lens moves the farthest corner by {camera.corner_distortion_px:.1f} px"
    yield f"  stands at {_three(camera.position_mm, '.1f')}, looks along {_three(camera.looks, '.3f')}"
    yield f"  {camera.distance_mm:.0f} mm away a pixel is {camera.mm_per_px:.3f} mm, {place}"
    if known := [form.format(camera.sigma[key]) for key, form in SIGMA_WORDS.items() if key in camera.sigma]:
        yield f"  known to (one standard deviation) {', '.join(known)}"
    if camera.rms_px is not None:
        held_out = (
            f", {camera.held_out_rms_px:.3f} px in views that were held out" if camera.held_out_rms_px else ""
        )
        yield f"  reprojection {camera.rms_px:.3f} px RMS in {camera.views} views{held_out}"


def _three(values: tuple[float, float, float], form: str) -> str:
    return ", ".join(format(value + 0.0, form) for value in values)
