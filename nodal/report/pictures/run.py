"""A whole run: where the tip was asked to go and went, and how the errors went over time."""

from pathlib import Path

from nodal.report.findings import Findings
from nodal.report.pictures.chart import draw
from nodal.report.pictures.style import INK, MEASURED, WITHOUT_FEEDBACK, picture
from nodal.report.run_charts import run_charts
from nodal.report.tracking import Tracking

PLANES = (("Seen from above", 0, 1), ("Seen from the front", 0, 2))


def draw_run(
    folder: Path, findings: Findings, circle: Tracking, without_feedback: Tracking | None
) -> list[Path]:
    """Both pictures; returns the files."""
    files = [_errors(folder / "error.png", findings)]
    if len(circle.time_ns):
        files.append(_paths(folder / "path.png", circle, without_feedback))
    return files


def _paths(path: Path, circle: Tracking, without_feedback: Tracking | None) -> Path:
    """Target and true tip, from above and from the front, and the same circle without feedback."""
    with picture(path, 9.4, 4.8) as figure:
        for axes, (title, across, up) in zip(figure.subplots(1, 2), PLANES, strict=True):
            if without_feedback is not None:
                axes.plot(
                    *without_feedback.reached_mm[:, 0, [across, up]].T,
                    color=WITHOUT_FEEDBACK,
                    label=f"without feedback, {without_feedback.rms_mm():.2f} mm RMS",
                )
            axes.plot(
                *circle.reached_mm[:, 0, [across, up]].T,
                color=MEASURED,
                label=f"closed loop, {circle.rms_mm():.2f} mm RMS",
            )
            axes.plot(*circle.desired_mm[:, 0, [across, up]].T, "--", color=INK, linewidth=1, label="target")
            axes.set(title=title, xlabel=f"{'xyz'[across]}, mm", ylabel=f"{'xyz'[up]}, mm")
            axes.set_aspect("equal", adjustable="datalim")
        figure.legend(*axes.get_legend_handles_labels(), loc="outside lower center", ncols=3)
    return path


def _errors(path: Path, findings: Findings) -> Path:
    """Tracking and estimation error over time, on logarithmic scales, over what the controller was doing."""
    charts = run_charts(findings)
    chosen = [chart for chapter in ("tracking", "truth") for chart in charts[chapter] if chart.wide]
    with picture(path, 9.4, 2.7 * len(chosen)) as figure:
        for axes, chart in zip(
            figure.subplots(len(chosen), 1, sharex=True, squeeze=False)[:, 0], chosen, strict=True
        ):
            draw(axes, chart)
    return path
