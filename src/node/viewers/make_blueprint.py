"""Writes toile.rbl, the rerun blueprint of a toile recording (pip install rerun-sdk==0.41.*).

It is static: it names topics and fields, and holds no mesh, so one serves all recordings.
"""

import sys

import rerun as rr
import rerun.blueprint as rrb
from rerun.blueprint.encodings import ComponentSourceKind, VisualizerComponentMapping


def mapping(target, message, selector):
    return VisualizerComponentMapping(
        target=target,
        source_kind=ComponentSourceKind.SourceComponent,
        source_component=f"{message}:message",
        selector=selector,
    )


def plot(name, paths):
    """One view with a line per field of the step report."""
    report = "toile_msgs.msg.StepReport"
    lines = [
        rr.SeriesLines(names=path.split(".")[-1]).visualizer(
            mappings=[mapping("Scalars:scalars", report, path)]
        )
        for path in paths
    ]
    return rrb.TimeSeriesView(
        origin="/", contents=["/toile/report"], overrides={"/toile/report": lines}, name=name
    )


mesh = rr.Mesh3D.from_fields(albedo_factor=[219, 204, 173, 255]).visualizer(
    mappings=[
        mapping(
            "Mesh3D:vertex_positions",
            "visualization_msgs.msg.MarkerArray",
            ".markers[] | .points[] | pack(.x!, .y!, .z!)",
        )
    ]
)
cloth = rrb.Spatial3DView(
    origin="/",
    contents="$origin/**",
    overrides={
        "/toile/mesh": [rr.CoordinateFrame("world"), mesh],
        "/toile/state": rr.Points3D.from_fields(
            radii=0.0003, colors=[40, 60, 90]
        ).visualizer(),
    },
    spatial_information=rrb.SpatialInformation(target_frame="world"),
    name="cloth",
)
energies = ["kinetic", "stretch", "bend", "gravity", "contact", "damping", "friction"]
plots = rrb.Vertical(
    plot("energies [J]", [f".energies.{name}" for name in energies]),
    plot("residual / weight [-]", [".residual"]),
    plot("deepest penetration [m]", [".deepest_penetration"]),
)
out = sys.argv[1] if len(sys.argv) > 1 else "toile.rbl"
rrb.Blueprint(rrb.Horizontal(cloth, plots, column_shares=[2, 1]), collapse_panels=True).save(
    "toile", out
)
