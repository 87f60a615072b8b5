"""Help: options in groups, and examples."""

import click

GROUPS = {
    "Surface": (
        *("surface", "step", "height_unit", "periodic", "detrend", "filter", "wavelength"),
        *("autocorrelation", "heights_of", "accuracy", "cells", "extent", "realisations", "waves"),
        *("convergence", "save_mesh", "surfaces"),
    ),
    "Model": (
        *("method", "bidirectional", "material", "slopes", "gamma", "alpha", "ior", "metal", "rgb"),
        *("eta_k", "albedo", "heights", "memory", "texture"),
    ),
    "Light": ("theta", "phi", "phi_o", "points", "free_path_theta", "free_path_height", "strategy"),
    "Work": (
        *("orders", "samples", "rays", "replicates", "directions", "qmc", "max_order", "seed"),
        *("threads", "precision", "scheduler", "shard", "width"),
    ),
    "Report": ("out", "force", "format", "exr", "dry_run", "quiet", "as_json"),
}
"""Parameters by group; what is in none is the command's own, and comes first."""

EXAMPLES = {
    "figures": ("figures heitz-15 wang-2", "figures --quick"),
    "simulate": (
        "simulate --alpha 0.8 --theta 0,60deg",
        "simulate --material dielectric --theta 150deg --accuracy 0.005",
    ),
    "walk": (
        "walk --slopes ggx --alpha 1,0.1 --theta 60deg",
        "walk --material dielectric --ior 1.5 --theta 120deg,150deg",
    ),
    "compare": (
        "compare --alpha 1 --theta 30deg",
        "compare reports/simulate-conductor-beckmann-0.5 --method single,solve",
    ),
    "evaluate": (
        "evaluate --method single,solve --metal gold --rgb --slopes ggx --alpha 0.3",
        "evaluate --method walk,solve --theta 80deg --points 181 --format svg",
    ),
    "furnace": (
        "furnace --method single,solve --alpha 0.2 --alpha 0.8",
        "furnace --metal gold --rgb --slopes ggx",
    ),
    "validate": ("validate --quick", "validate --seed 1 --json"),
    "stability": ("stability --method single,solve", "stability --full"),
    "tradeoff": (
        "tradeoff --alpha 0.8 --theta 60deg",
        "tradeoff --slopes ggx --method walk,exact,solve",
    ),
    "render": (
        "render --method single,walk-low-variance --alpha 0.6",
        "render bottle --material dielectric --samples 256",
    ),
    "recommend": ("recommend plate", "recommend scene.toml --tolerance 0.02 --against surfaces"),
    "export": ("export --slopes ggx --alpha 0.4", "export --metal copper --rgb --alpha 0.3,0.1"),
    "sweep": (
        "sweep walk --alpha 0.1:1:10 --theta 0:85deg:10",
        "sweep compare --alpha 0.3 --alpha 1 --dry-run",
    ),
    "merge": ("merge reports/walk-seed-0 reports/walk-seed-1", "merge reports/map-*-of-8"),
}


class Page(click.Command):
    """A command whose help has its options in groups, and examples at its end."""

    def format_options(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """The options, group by group, each in the command's own order."""
        home = {name: title for title, names in GROUPS.items() for name in names}
        groups: dict[str, list[tuple[str, str]]] = {title: [] for title in ("Options", *GROUPS)}
        for parameter in self.get_params(ctx):
            record = parameter.get_help_record(ctx)
            if record is not None and isinstance(parameter, click.Option):
                groups[home.get(str(parameter.name), "Options")].append(record)
        for title, records in groups.items():
            if records:
                with formatter.section(title):
                    formatter.write_dl(records)

    def format_epilog(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """The examples."""
        with formatter.section("Examples"):
            for example in EXAMPLES[str(self.name)]:
                formatter.write(f"{'':{formatter.current_indent}}msbsdf {example}\n")
