"""What `msbsdf compare` says of a model and surfaces, and the table that it prints."""

from typing import Any

from msbsdf_cli.cli.compare_surface import named
from msbsdf_cli.cli.terminal import measured, show_table
from msbsdf_cli.scene import in_degrees
from msbsdf_cli.smith.slopes import OF_SURFACE


def whose_slopes(surface: Any, model: Any) -> str:
    """Of whose slopes the model is, where the surface has its own."""
    if model.slopes == surface.slopes:
        return "The model is of the slopes that were counted on the surface."
    whose = named(model.slopes)
    if model.slopes.name == OF_SURFACE:
        whose = "those of another surface, or of another step, filter or unit"
    return f"The slopes of the model are {whose}, and not those of the surface."


def in_one_sentence(rows: list[Any]) -> str:
    """What a reader would want to know first."""
    energies = [r for r in rows if r.quantity == "energy" and r.order != "all"]
    lobes = [r for r in rows if r.quantity == "total_variation" and r.order == "all"]
    escapes = [r for r in rows if r.quantity == "free_path_escape"]
    energy, lobe = max(energies, key=_own), max(lobes, key=_own)
    text = (
        f"Beyond noise, {energy.method} misses the energy of a single order by at most "
        f"{_size(energy)} (order {energy.order}, {energy.side}, theta "
        f"{in_degrees(energy.theta_i_rad)}: {energy.modelled:.4f} modelled, "
        f"{energy.simulated:.4f} simulated), "
        f"sends at most {_size(lobe)} of the light elsewhere (theta {in_degrees(lobe.theta_i_rad)})"
    )
    if escapes:
        escape = max(escapes, key=_own)
        text += (
            f", and misses the fraction of free paths that escape by up to {_size(escape)} "
            f"({escape.order}, theta_r {in_degrees(escape.theta_i_rad)})"
        )
    return text + "."


def _own(row: Any) -> float:
    return abs(float(row.own))


def _size(row: Any) -> str:
    return measured(_own(row), row.own_stderr)


def show_rows(rows: list[Any]) -> None:
    """Print what differs, light before free paths and the largest first: how much, how much of it
    noise explains, how much is the model's own.

    Lobes order by order, and free paths that all escape or none, are left to agreement.csv.
    """
    header = (
        *("quantity", "theta", "order", "side", "model's own", "z", "simulated", "modelled"),
        *("difference", "noise", "method"),
    )
    lines = []
    for r in sorted(rows, key=lambda r: (r.quantity.startswith("free_path"), -_own(r))):
        if r.quantity == "total_variation" and r.order != "all":
            continue
        paths = r.quantity.startswith("free_path")
        if paths and r.simulated == r.modelled and r.simulated in (0, 1):
            continue
        lines.append(
            (
                r.quantity,
                in_degrees(r.theta_i_rad),
                r.order,
                r.side,
                measured(r.own, r.own_stderr),
                f"{r.z:.1f}",
                measured(r.simulated, r.simulated_stderr),
                measured(r.modelled, r.modelled_stderr),
                f"{r.difference:.2g}",
                f"{r.noise:.1g}",
                r.method,
            )
        )
    if len({r.method for r in rows}) > 1:
        header, lines = (header[-1], *header[:-1]), [(line[-1], *line[:-1]) for line in lines]
    show_table(header, lines, "agreement.csv", len(rows))
