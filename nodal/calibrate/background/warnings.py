"""What speaks against a background, in words, each with what to do about it. Pure."""

from collections.abc import Iterator

from nodal.calibrate.background.judging import CameraBackground
from nodal.calibrate.background.spots import STANDS_OUT, Spot

DARK, BRIGHT = 50.0, 225.0
CLIPPED_SHARE = 0.001
UNEVEN = 0.5
FLICKER = 0.01
NOISY, NOISIER = 6.0, 2.5
"""Levels; and by which factor a part of the picture is noisier than the rest."""
LARGE_SPOT_MM2 = 150.0


def warnings(found: CameraBackground) -> Iterator[str]:
    """Each of them."""
    yield from _of_light(found)
    yield from _of_noise(found)
    yield from _of_things(found)


def _of_light(found: CameraBackground) -> Iterator[str]:
    level, brightest = sum(found.level) / 3, max(found.level)
    if level < DARK:
        yield f"the backdrop is dark (level {level:.0f} of 255): more light, or a longer exposure"
    if brightest > BRIGHT:
        yield f"the backdrop is nearly too bright (level {brightest:.0f} of 255): a shorter exposure"
    if found.clipped_share > CLIPPED_SHARE:
        yield (
            f"{found.clipped_share:.1%} of what the robot can be seen before is too bright to be told (glare): move the lamp, or a "
            "shorter exposure"
        )
    if found.unevenness > UNEVEN:
        yield (
            f"the light is uneven: brightness differs by {found.unevenness:.0%} within the robot's reach; lamps from both sides "
            "even it out"
        )
    if found.flicker > FLICKER:
        yield (
            f"the light flickers by {found.flicker:.1%} from picture to picture: set the power-line frequency, or take lamps on direct "
            "current"
        )


def _of_noise(found: CameraBackground) -> Iterator[str]:
    if max(found.noise) > NOISY:
        yield f"the pictures are noisy (sigma {max(found.noise):.1f} levels): more light and less gain"
    if found.noisiest > NOISIER * found.tile_noise + 0.5:
        x, y = found.noisiest_px
        yield (
            f"about {x}, {y} px the pictures are {found.noisiest / found.tile_noise:.1f} times as noisy as elsewhere: a screen, a "
            "moving shadow?"
        )


def _of_things(found: CameraBackground) -> Iterator[str]:
    if found.ends_in_reach:
        yield (
            "the backdrop ends within the robot's reach, and beyond its edge the robot is not looked for: take a larger backdrop, or "
            "move it"
        )
    large = [spot for spot in found.spots if spot.area_mm2 > LARGE_SPOT_MM2]
    if large:
        yield (
            f"{_count(len(large), 'thing')} on the backdrop within the robot's reach, the largest about {_centre(large[0])} px: take it "
            "away, or smooth the fold"
        )
    bright = [spot for spot in found.spots if spot.levels > 2 * STANDS_OUT and spot not in large]
    if bright:
        yield f"{_count(len(bright), 'bright spot')} (glare?), the largest about {_centre(bright[0])} px: move the lamp"


def _count(number: int, what: str) -> str:
    return f"{number} {what}" if number == 1 else f"{number} {what}s"


def _centre(spot: Spot) -> str:
    x, y, width, height = spot.box_px
    return f"{x + width // 2}, {y + height // 2}"
