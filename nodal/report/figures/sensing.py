"""Figures of sensing: how much, how good, how it judged itself, and what it cost."""

import numpy as np

from nodal.report.figures.model import Chapter, Group, durations, extent, figures, spread
from nodal.report.findings import Findings
from nodal.report.summary import estimate_rate_hz


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
        sigma_mm = np.concatenate([np.zeros(0), *findings.sigmas_mm])
        chapters.append(
            Chapter(
                "quality",
                "Quality as sensing judges it",
                (
                    Group("reprojection residual", extent([s.residual_px for s in usable], "px")),
                    Group("gap between paired rays", extent([s.ray_gap_mm for s in usable], "mm")),
                    Group("measured length", extent([s.length_mm for s in usable], "mm")),
                    Group("standard deviation of nodal points", extent(sigma_mm, "mm")),
                ),
            )
        )
    if findings.node_errors_mm:
        chapters.append(_errors(findings))
    if usable:
        chapters.append(_stages(findings))
    return tuple(chapters)


def _errors(findings: Findings) -> Chapter:
    """Distances from the truth at each estimate's capture, flagged ones too."""
    run = findings.run
    covered = run.covered(run.truth) if run.truth else []
    by_node: dict[str, list[float]] = {}
    for shape, errors in zip(covered, findings.node_errors_mm, strict=True):
        for name, error in zip(shape.node_names, errors.tolist(), strict=True):
            by_node.setdefault(name, []).append(error)
    return Chapter(
        "truth",
        "Errors against the truth",
        (
            Group("all nodal points", spread(np.concatenate(findings.node_errors_mm), "mm")),
            *(Group(f"nodal point {name}", spread(errors, "mm")) for name, errors in by_node.items()),
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
