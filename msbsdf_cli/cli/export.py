"""`msbsdf export`"""

from typing import Any

import click

from msbsdf_cli.cli.options import REPORT, use


@click.command("export")
@use(
    "material",
    "slopes",
    "gamma",
    "alpha",
    "ior",
    "metal",
    "rgb",
    "eta-k-channels",
    "albedo-channels",
)
@use("threads", *REPORT)
def command(**options: Any) -> None:
    """Tables that renderers load: the BSDF of all bounces, and albedos for energy compensation.

    bsdf.npz is read by the Mitsuba 3 plugin of `msbsdf_cli.renderers.mitsuba`. Of mirrors, metals
    and diffuse facets of one roughness.
    """
    import numpy as np

    from msbsdf_cli.cli import common
    from msbsdf_cli.cli.report import Report
    from msbsdf_cli.methods.protocol import UnsupportedError
    from msbsdf_cli.renderers import files, tables

    scene = common.scene_from(options | {"theta": (0.0,), "phi": (0.0,), "orders": 1})
    report = Report("export", scene.slug(), options)
    try:
        tables.check(scene.slopes, scene.material)
    except UnsupportedError as refusal:
        raise click.UsageError(f"{refusal}.") from None
    report.warn(common.scene_warnings(options))
    expected = tables.seconds(scene.slopes, scene.material) / options["threads"]
    if expected > common.LONG_S:
        text = f"this will take about {common.duration(expected)}, for the table's directions."
        report.warn([text])
    with report.draft() as draft:
        work = options["threads"], options["quiet"]
        table = tables.make_table(scene.slopes, scene.material, *work)
        errors = tables.interpolation_error(table)
        directional, mean = tables.albedos(scene.slopes)
        share = float(np.interp(scene.alpha[0], tables.nodes(len(mean)), mean))
        files.write_table(draft / "bsdf.npz", table, share, float(errors.max()))
        np.savez(draft / "albedo.npz", directional=directional, mean=mean)
        header = files.c_header(scene.slopes.name, directional, mean)
        (draft / "albedo.h").write_text(header, "utf-8")
        known = f"off by {errors.max():.1g} of the BSDF at most, in the mean by {errors.mean():.1g}"
        summary = f"Up to theta 1.4 the table is {known}."
        report.write(draft, {}, 0, more={"summary": summary})
    report.end(lambda: click.echo(summary))
