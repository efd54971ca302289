"""One device as `nodal cameras list` says it. Pure."""

from collections.abc import Iterator

from drivers.cameras.v4l2.listing import DeviceControl, DeviceDescription


def described(device: DeviceDescription) -> str:
    """Its lasting path, and below it who it is, its sizes with their fastest rates, its controls with their ranges."""
    return "\n".join(_lines(device))


def _lines(device: DeviceDescription) -> Iterator[str]:
    yield str(device.path)
    if device.problem:
        yield f"  {device.problem}"
        return
    yield f"  {device.card} ({device.driver}, {device.bus}), now {device.node}"
    for other in device.lasting_paths:
        if other != device.path:
            yield f"  also {other}"
    for kind in dict.fromkeys(known.pixel_format for known in device.formats):
        sizes = (
            f"{known.width_px}x{known.height_px}" + (f" {max(known.rates_hz):g} Hz" if known.rates_hz else "")
            for known in device.formats
            if known.pixel_format == kind
        )
        yield f"  {kind:<5} {', '.join(sizes)}"
    for control in sorted(device.controls, key=lambda control: control.setting is None):
        yield f"    {_control(control)}"


def _control(control: DeviceControl) -> str:
    """In the unit of its key in the bench file where it has one, in the camera's own numbers otherwise."""
    name = control.setting or control.name
    if name != control.name:
        name += f" ({control.name})"
    value, default = (f"{control.in_setting(number):g}" for number in (control.value, control.default))
    if control.menu:
        allowed = ", ".join(
            f"{control.in_setting(number):g} = {word}" for number, word in control.menu.items()
        )
    else:
        least, most, step = map(control.in_setting, (control.minimum, control.maximum, control.step))
        allowed = f"{least:g} to {most:g}" + (f" in steps of {step:g}" if control.step > 1 else "")
    return f"{name:<46} {value:>7}   {allowed}; default {default}"
