"""`msbsdf export`"""

from typing import Any

import click

from msbsdf_cli.cli.help import Page
from msbsdf_cli.cli.options import REPORT, use


@click.command("export", cls=Page)
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
@click.option("--exr", is_flag=True, help="The albedos as OpenEXR too.")
@use("threads", *REPORT)
def command(**options: Any) -> None:
    """Tables that renderers load: the BSDF of all bounces, and albedos for energy compensation.

    bsdf.npz is read by the Mitsuba 3 plugin of `msbsdf_cli.renderers.mitsuba`: of mirrors, metals
    and diffuse facets, of one roughness or two, and of glass of one. Opaque surfaces of one
    roughness are in measured.bsdf too, which Mitsuba's own plugin `measured` reads. albedo.npz and
    albedo.h hold the directional albedo of mirrors by single scattering, for all roughness.
    """
    import numpy as np

    from msbsdf_cli.cli import common
    from msbsdf_cli.cli.report import Report
    from msbsdf_cli.methods.protocol import UnsupportedError
    from msbsdf_cli.renderers import albedos, files, measured, tables, tabulate
    from msbsdf_cli.renderers.exr import write_exr

    scene = common.scene_from(options | {"theta": (0.0,), "phi": (0.0,), "orders": 1})
    if options["exr"]:
        common.check_exr()
    report = Report("export", scene.slug(), options)
    try:
        tables.check(scene.slopes, scene.material)
    except UnsupportedError as refusal:
        raise click.UsageError(f"{refusal}.") from None
    report.warn(common.scene_warnings(options))
    expected = tabulate.seconds(scene.slopes, scene.material) / options["threads"]
    if expected > common.LONG_S:
        text = f"this will take about {common.duration(expected)}, for the table's directions."
        report.warn([text])
    with report.draft() as draft:
        work = options["threads"], options["quiet"]
        table = tabulate.make_table(scene.slopes, scene.material, *work)
        errors, known = tabulate.table_error(table, options["threads"])
        files.write_table(draft / "bsdf.npz", table, errors, known)
        summary = accuracy(errors, known)
        if not scene.material.transmits and table.nodes.incident == 1:
            fields = measured.measurements(table)
            measured.write_tensors(draft / "measured.bsdf", fields)
            worse = measured.measured_error(table, fields)
            summary += f" measured.bsdf is {off(worse)}, from that."
        directional, mean = albedos.albedos(scene.slopes)
        np.savez(draft / "albedo.npz", directional=directional, mean=mean)
        header = files.c_header(scene.slopes.name, directional, mean)
        (draft / "albedo.h").write_text(header, "utf-8")
        if options["exr"]:
            both = np.stack(np.broadcast_arrays(directional, mean[:, None]), axis=-1)
            write_exr(draft / "albedo.exr", both, ("directional", "mean"))
        report.write(draft, {}, 0, more={"summary": summary})
    report.end()


def off(errors: Any) -> str:
    """How large errors are, in words."""
    return f"off by {errors.max():.1g} of the BSDF at most, in the mean by {errors.mean():.1g}"


def accuracy(errors: Any, known: Any) -> str:
    """How far the table is off, and what it was made from where that is not better known."""
    text = f"Up to theta 1.4 the table is {off(errors)}."
    if known.mean() < errors.mean():
        return text
    doubt = f"to {known.max():.1g} at worst, {known.mean():.1g} in the mean"
    return f"{text} The solution itself is known {doubt}, by its own estimate."
