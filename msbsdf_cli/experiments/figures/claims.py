"""Every number and claim of both papers, ours beside theirs."""

from collections.abc import Iterator
from dataclasses import fields, replace
from math import hypot

import numpy as np

from msbsdf_cli.experiments.compare import Row, agreement
from msbsdf_cli.experiments.figures.areas import wang_2
from msbsdf_cli.experiments.figures.free_paths import traced_and_modelled
from msbsdf_cli.experiments.figures.lobes import MODELS, atlas, position_free, traced_and_walked
from msbsdf_cli.experiments.figures.reciprocity import wang_16
from msbsdf_cli.experiments.figures.settings import Settings, Tables
from msbsdf_cli.experiments.figures.slab import wang_17
from msbsdf_cli.experiments.render.claims import Claim
from msbsdf_cli.experiments.render.claims import claims as claims_of_pictures
from msbsdf_cli.experiments.render.picture import Settings as Size
from msbsdf_cli.methods.solve import Solve
from msbsdf_cli.results.files import columns
from msbsdf_cli.results.lobes import Lobes
from msbsdf_cli.scene import Scene, direction, in_degrees
from msbsdf_cli.smith.slopes import Beckmann, Ggx
from msbsdf_cli.statistics.distances import Histogram, kolmogorov_smirnov
from surfaces.materials import Conductor, Dielectric, Diffuse

ACCURATE = 0.01
"""Of the light: what `accurately`, `very close` and `very similar` are taken to allow, since the
papers give no number; the default tolerance of `msbsdf recommend`."""

HOLDS, DOES_NOT, NOT_COMPARABLE = "holds", "does not hold", "not comparable"
HEITZ, WANG = "[HHdD16]", "[WJFYHY22 supp.]"


def claims(settings: Settings) -> Tables:
    """claims.csv: `published` is 0 where a paper says that two things agree."""
    found = [
        *_energy(),
        *_against_surfaces(settings),
        _free_paths(settings),
        *_of_pictures(settings),
        *_masking(settings),
        *_position_free(settings),
        *_reciprocity(settings),
        *_slab(settings),
    ]
    return {"claims": columns(found, (f.name for f in fields(Claim)))}


def _judged(measured: float, stderr: float, allowed: float) -> str:
    """Whether what ought to be 0 is within what is allowed; unknown where its error bar, two
    standard errors, reaches from one side of that to the other."""
    if abs(measured) - 2 * stderr > allowed:
        return DOES_NOT
    return HOLDS if abs(measured) + 2 * stderr <= allowed else NOT_COMPARABLE


UNCERTAIN = "the error bar is too wide to tell"


def _close(what: str, source: str, measured: float, stderr: float, note: str) -> Claim:
    verdict = _judged(measured, stderr, ACCURATE)
    said = f"{note}; within {ACCURATE:g} is taken as accurate"
    if verdict == NOT_COMPARABLE:
        said = f"{UNCERTAIN}: {said}"
    return Claim(what, source, 0.0, measured, stderr, verdict, said)


def _energy() -> Iterator[Claim]:
    """All the light leaves, of GGX slopes of roughness 1, by the integral equation."""
    for material in (Conductor(), Diffuse(), Dielectric(1.5)):
        energy = Solve(Ggx(1.0, 1.0), material, 2).energy(direction(1.0))
        total = float(energy.reflected[0].sum() + energy.transmitted[0].sum())
        error = float(energy.error[0].sum())
        apart = abs(total - 1) <= 2 * error
        yield Claim(
            *(f"energy that leaves, {material.name}", f"{HEITZ} Figures 1, 16", 1.0, total, error),
            *(HOLDS if apart else DOES_NOT, "GGX, alpha 1, from 57.3°, all orders by solve"),
        )


def _against_surfaces(settings: Settings) -> Iterator[Claim]:
    """Albedo and angular distribution of the scenes of Figure 15, and of rougher ones."""
    scenes = [
        Scene(material, Beckmann(*alpha), (theta,), orders=3)
        for material in (Conductor(), Diffuse(), Dielectric(1.5))
        for alpha, theta in (((0.1, 1.0), 1.5), ((1.0, 1.0), 1.0))
    ]
    for number, scene in enumerate(scenes):
        alpha = ",".join(f"{a:g}" for a in dict.fromkeys(scene.alpha))
        where = f"{scene.material.name}, alpha {alpha}, from {in_degrees(scene.theta[0])}"
        pair = traced_and_walked(scene, settings.of_scene(number))
        rows = agreement(*pair)
        worst = max((r for r in rows if r.quantity == "energy"), key=_size)
        for row, what in ((worst, "energy of one order"), (_lobe(rows), "angular distribution")):
            order = f"order {row.order}, {row.side}; z = {row.z:.1f}"
            source = f"{HEITZ} Section 10, Figure 15"
            name = f"accurately predicts the simulation: {what}, {where}"
            yield _close(name, source, row.own, row.own_stderr, f"model less simulation, {order}")
        if scene.material.transmits:
            name = f"accurately predicts the simulation: albedo, {where}"
            yield _close(name, source, *_albedo(*pair), "model less simulation, reflected")


def _albedo(simulated: Lobes, modelled: Lobes) -> tuple[float, float]:
    """Of what is reflected, the model's less the simulation's; its error bar as if the orders of
    either went together, which is an upper bound."""
    (a, error_a), (b, error_b) = (
        (float(e.value[0, :, 0].sum()), float(e.stderr[0, :, 0].sum()))
        for e in (simulated.energy, modelled.energy)
    )
    return b - a, hypot(error_a, error_b)


def _lobe(rows: list[Row]) -> Row:
    """Of the side on which more light goes elsewhere."""
    totals = [r for r in rows if r.quantity == "total_variation" and r.order == "all"]
    return max(totals, key=lambda r: r.own)


def _free_paths(settings: Settings) -> Claim:
    simulated, model = (paths.rows() for paths in traced_and_modelled(settings))
    found = {
        place: kolmogorov_smirnov(
            *(Histogram(e.value, e.stderr) for e in (model[place], simulated[place]))
        )
        for place in simulated
    }
    (theta, start), worst = max(found.items(), key=lambda item: item[1].own)
    note = (
        f"largest distance of two distributions, from height {start:g} towards {in_degrees(theta)}"
    )
    name = "good agreement of free paths, alpha 1"
    return _close(name, f"{HEITZ} Figure 14", worst.own, worst.own_stderr, note)


def _of_pictures(settings: Settings) -> Iterator[Claim]:
    """What `msbsdf render --claims` measures, in the three words of this table."""
    size, repeats = settings.pick((Size(64, 48, 32), 3), (Size(96, 64, 64), 6))
    around = settings.seed, settings.workers, settings.quiet
    for claim in claims_of_pictures(*around, size, repeats):
        verdict, note = claim.verdict, claim.note
        if verdict == "undecided":
            verdict, note = NOT_COMPARABLE, f"{UNCERTAIN}: {note}"
        elif verdict != HOLDS:
            # Times are another machine's and program's; `in some cases` is said of no material.
            told = claim.claim.startswith("additional variance")
            note = f"{verdict}: {note}"
            verdict = DOES_NOT if told else NOT_COMPARABLE
        yield replace(claim, verdict=verdict, note=note)


def _masking(settings: Settings) -> Iterator[Claim]:
    table = wang_2(settings)["wang_2"]
    closed, integral, error = (
        np.array(table[name]) for name in ("closed_form", "quadrature", "stderr")
    )
    apart = np.abs(integral / closed - 1)
    k = int(apart.argmax())
    note = f"largest relative difference, {table['slopes'][k]}, {in_degrees(table['theta_rad'][k])}"
    measured, stderr = float(apart[k]), float(error[k] / integral[k])
    name = "distant masking: closed form and integral match very well"
    yield _close(name, f"{WANG} Figure 2", measured, stderr, note)
    below = closed[np.array(table["theta_rad"]) > np.pi / 2]
    name, told = "distant masking may exceed 1 from below", HOLDS if below.max() > 1 else DOES_NOT
    yield Claim(name, f"{WANG} Section 1.1", 1.0, float(below.max()), 0.0, told, "largest value")


def _position_free(settings: Settings) -> Iterator[Claim]:
    """Both models against the walk, on the roughest mirrors and glass of the atlas."""
    for number, scene in atlas():
        if number not in (10, 14):
            continue
        for model in _models(scene, settings):
            rows = {theta: _energy_at(model[1], theta) for theta in scene.theta}
            worst = max(rows.values(), key=_size)
            where = f"{scene.material.name}, alpha {scene.alpha[0]:g}"
            source = f"{WANG} Section 3, Figure {number}"
            if model[0] == MODELS[1]:
                name = f"height-correlated is very similar to the walk, {where}"
                at = in_degrees(worst.theta_i_rad)
                note = f"energy of order {worst.order}, {worst.side}, from {at}"
                yield _close(name, source, worst.own, worst.own_stderr, note)
                continue
            steep, grazing = rows[scene.theta[0]], rows[scene.theta[-1]]
            more = _size(grazing) - _size(steep)
            error = hypot(grazing.own_stderr, steep.own_stderr)
            told = NOT_COMPARABLE if abs(more) < 2 * error else (HOLDS if more > 0 else DOES_NOT)
            name = f"height-uncorrelated differs from the walk mostly at grazing angles, {where}"
            sizes = f"{_size(grazing):.3f} from 85.94° and {_size(steep):.3f} from 0°"
            note = f"energy of the order that is off most: {sizes}"
            yield Claim(name, source, 0.0, more, error, told, note)


def _energy_at(rows: list[Row], theta: float) -> Row:
    """The order and side of which most, or least, energy leaves, against the walk."""
    return max((r for r in rows if r.quantity == "energy" and r.theta_i_rad == theta), key=_size)


def _size(row: Row) -> float:
    return abs(row.own)


def _models(scene: Scene, settings: Settings) -> list[tuple[str, list[Row]]]:
    _, walked = traced_and_walked(scene, settings)
    return [(m.label, agreement(walked, m)) for m in position_free(scene, settings)]


def _reciprocity(settings: Settings) -> Iterator[Claim]:
    table = wang_16(settings)["wang_16"]
    for method in MODELS:
        mine = np.array(table["method"]) == method
        apart, error = (np.array(table[name])[mine] for name in ("difference", "stderr"))
        mean, stderr = float(apart.mean()), float(np.sqrt((error**2).sum()) / apart.size)
        scatter = float(((apart / error) ** 2).mean())
        note = f"mean over a sphere; the pixels' squared z is {scatter:.2f} in the mean"
        correlated = method == MODELS[1]
        differs = abs(mean) > 3 * stderr
        name = f"{method} is {'not ' if correlated else ''}reciprocal"
        source = f"{WANG} Section 2.{1 + correlated}" + ("" if correlated else ", Figure 16")
        told = HOLDS if differs == correlated else DOES_NOT
        yield Claim(name, source, 0.0, mean, stderr, told, note)


def _slab(settings: Settings) -> Iterator[Claim]:
    table = wang_17(settings)["wang_17"]
    rows = [dict(zip(table, cells, strict=True)) for cells in zip(*table.values(), strict=True)]
    source, name = f"{WANG} Section 4, Figure 17", "position-free-correlated-bidirectional"
    for row in (r for r in rows if r["method"] == name and r["samples"] == 2):
        error, alpha = float(np.sqrt(row["relative_mse"])), f"alpha {row['alpha_x']:g}"
        stderr = float(row["relative_mse_stderr"]) / (2 * error) if error else 0.0
        what = f"two samples a pixel come very close to the truth, {alpha}"
        note = "root mean square error over the image, relative; its light and view are ours"
        yield _close(what, source, error, stderr, note)
        gain, doubt = float(row["gain_over_walk"]), float(row["gain_stderr"])
        if np.isfinite(gain):
            told = HOLDS if gain - 2 * doubt > 1 else NOT_COMPARABLE
            note = "time of the walk over that of ours at one error: times are those of NumPy"
            what = f"position-free is consistently better than the walk, {alpha}"
            yield Claim(what, source, 1.0, gain, doubt, told, note)
