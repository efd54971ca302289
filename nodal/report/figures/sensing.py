"""Figures of sensing: how much, how good, how it judged itself, and what it cost."""

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from nodal.report.figures.model import Chapter, Figure, Group, durations, extent, figures, spread
from nodal.report.findings import Findings
from nodal.report.statistics import least, mean, percentile
from nodal.report.summary import estimate_rate_hz

Array = NDArray[np.float64]


def sensing(findings: Findings) -> tuple[Chapter, ...]:
    """What was estimated, its quality, its errors where there is a truth, and the time of each stage."""
    run = findings.run
    usable = run.usable
    refused = len(run.shapes) - len(usable)
    flagged = sum(bool(shape.flags) for shape in usable)
    estimates = Group(
        "estimates",
        figures(
            frame_sets=("complete frame sets", run.frames.complete()),
            estimates=("estimates", len(usable)),
            rate_hz=("rate of estimates", estimate_rate_hz(run)),
            flagged=("flagged", flagged),
            refused=("refused", refused),
            trusted_percent=("good", 100 * (len(usable) - flagged) / len(run.shapes) if run.shapes else None),
        ),
    )
    chapters = [Chapter("sensing", "Sensing", (estimates,))]
    if usable:
        chapters += [_quality(findings), _cameras(findings)]
    if findings.node_errors_mm:
        chapters.append(_errors(findings))
    if usable:
        chapters.append(_stages(findings))
    return tuple(chapters)


def _quality(findings: Findings) -> Chapter:
    """What estimates say of themselves."""
    usable = findings.run.usable
    off_mm = [shape.length_mm - shape.known_length_mm for shape in usable if shape.known_length_mm]
    sigma_mm = np.concatenate([np.zeros(0), *findings.sigmas_mm])
    return Chapter(
        "quality",
        "Quality as sensing judges it",
        (
            Group("reprojection residual", extent([s.residual_px for s in usable], "px")),
            Group("gap between paired rays", extent([s.ray_gap_mm for s in usable], "mm")),
            Group("bias of the ray gap", extent([s.ray_bias_mm for s in usable], "mm")),
            Group("measured length", extent([s.length_mm for s in usable], "mm")),
            Group("measured length less the known one", extent(off_mm, "mm")),
            Group("standard deviation of nodal points", extent(sigma_mm, "mm")),
            Group("smallest epipolar angle", extent(findings.epipolar_deg, "deg")),
        ),
    )


def _cameras(findings: Findings) -> Chapter:
    """What each camera told; a camera that carried no estimate is not among them."""
    residual_px = findings.by_camera(lambda shape: shape.camera_residual_px)
    visible_mm = findings.by_camera(lambda shape: shape.visible_mm)
    return Chapter(
        "cameras",
        "What each camera tells",
        tuple(
            Group(
                f"camera {name}",
                figures(
                    estimates=("estimates that it carried", np.count_nonzero(np.isfinite(visible_mm[name]))),
                    residual_mean_px=("residual, mean", mean(_known(residual_px[name]))),
                    residual_p95_px=("residual, 95 % below", percentile(_known(residual_px[name]), 95)),
                    visible_mean_mm=("visible length, mean", mean(_known(visible_mm[name]))),
                    visible_min_mm=("visible length, least", least(_known(visible_mm[name]))),
                ),
            )
            for name in findings.cameras
        ),
    )


def _known(values: Array) -> Array:
    return values[np.isfinite(values)]


def _coverage(inside: Iterable[bool]) -> tuple[Figure, ...]:
    """A promise of sensing: 90 to 99 % of nodal points lie within their 95 % ellipsoids."""
    return figures(inside_percent=("within the 95 % ellipsoid", mean(100.0 * np.array(list(inside)))))


def _errors(findings: Findings) -> Chapter:
    """Distances from the truth at each estimate's capture, flagged ones too."""
    by_node: dict[str, list[tuple[float, bool]]] = {}
    for shape, errors, inside in zip(findings.covered, findings.node_errors_mm, findings.inside, strict=True):
        for name, *told in zip(shape.node_names, errors.tolist(), inside.tolist(), strict=True):
            by_node.setdefault(name, []).append((told[0], told[1]))
    return Chapter(
        "truth",
        "Errors against the truth",
        (
            Group(
                "all nodal points",
                (
                    *spread(np.concatenate(findings.node_errors_mm), "mm"),
                    *_coverage(np.concatenate(findings.inside)),
                ),
            ),
            *(
                Group(
                    f"nodal point {name}",
                    (*spread([error for error, _ in told], "mm"), *_coverage(within for _, within in told)),
                )
                for name, told in by_node.items()
            ),
            Group("end of the centreline", spread(findings.tip_errors_mm, "mm")),
        ),
    )


def _stages(findings: Findings) -> Chapter:
    """What each stage of an estimate took."""
    by_stage: dict[str, list[float]] = {}
    for shape in findings.run.usable:
        for name, seconds in zip(shape.stage_names, shape.stage_s.tolist(), strict=True):
            by_stage.setdefault(name, []).append(1e3 * seconds)
    total = [1e3 * float(shape.stage_s.sum()) for shape in findings.run.usable]
    return Chapter(
        "stages",
        "Time of each stage",
        (
            *(Group(name, durations(times)) for name, times in by_stage.items()),
            Group("all stages", durations(total)),
        ),
        minor=True,
    )
