"""`msbsdf sweep` and `msbsdf merge` as a user meets them."""

import errno
import json
import signal
import subprocess
import sys
import time

import numpy as np
import pytest
from command_line import RUN, msbsdf, refused, table

from msbsdf_cli import HeightField
from msbsdf_cli.plots.sweep import draw_sweep, read_grid
from msbsdf_cli.results import npz
from msbsdf_cli.results.place import locked

WALK = ("sweep", "walk", "--alpha", "0.3:0.9:3", "--theta", "0,60deg", "--samples", "2000")
SCAN = "a file of heights"
SURFACES = ("--cells", "4", "--extent", "6", "--realisations", "4", "--samples", "400")


@pytest.fixture(scope="module")
def scan(tmp_path_factory):
    """A file of heights, by which `SCAN` is replaced in words."""
    path = tmp_path_factory.mktemp("scan") / "scan.npy"
    np.save(path, HeightField.random(0.6, extent=6, cells=6).heights)
    return lambda words: [path if word == SCAN else word for word in words]


def content(directory):
    return (directory / "sweep.csv").read_bytes()


def test_the_table_is_long_and_has_every_option_that_varies(tmp_path):
    words = (*WALK, "--material", "conductor,diffuse", "--out", tmp_path / "a")
    assert msbsdf(*words).returncode == 0
    rows = table(tmp_path / "a" / "sweep.csv")
    assert len(rows) == 3 * 2 * 2 * 7
    assert list(rows[0])[:4] == ["material", "alpha", "theta", "theta_i_rad"]
    assert {row["alpha"] for row in rows} == {"0.3", "0.6", "0.9"}
    assert {row["material"] for row in rows} == {"conductor", "diffuse"}
    assert all(row["theta"] == row["theta_i_rad"] and not row["failure"] for row in rows)
    one = [
        r for r in rows if (r["material"], r["alpha"], float(r["theta"])) == ("diffuse", "0.9", 0)
    ]
    energies = [float(row["energy"]) for row in one]
    assert abs(sum(energies) - 1) < 1e-9
    record = json.loads((tmp_path / "a" / "run.json").read_text())
    assert record["command"] == "sweep"
    assert record["seed"] == [0]
    assert record["rows"] == len(rows)


@pytest.mark.parametrize(
    "words",
    [
        WALK[1:],
        ("simulate", *SURFACES, "--alpha", "0.5", "--alpha", "1,0.5", "--theta", "0,1"),
        ("compare", *SURFACES, "--alpha", "0.5", "--alpha", "1", "--theta", "0,1"),
        ("compare", *SURFACES, "--theta", "0,1", "--method", "solve,walk"),
        ("simulate", "--surface", SCAN, "--step", "0.3,0.5", "--theta", "0,1", "--samples", "160"),
        ("evaluate", "--method", "walk,single", "--theta", "0,1", "--samples", "200"),
        ("furnace", "--method", "walk,single", "--theta", "0,1", "--samples", "32"),
    ],
    ids=["walk", "simulate", "compare", "methods", "file", "evaluate", "furnace"],
)
def test_the_same_bytes_from_one_process_two_and_shares(words, scan, tmp_path, monkeypatch):
    monkeypatch.setattr("msbsdf_cli.experiments.furnace.FIRST", 256)
    words = scan(words)
    runs = {"one": ("--threads", "1"), "two": ("--threads", "2")}
    runs |= {f"share-{k}": ("--shard", f"{k}/2") for k in (1, 2)}
    for name, how in runs.items():
        done = msbsdf("sweep", *words, *how, "--out", tmp_path / name)
        assert done.returncode == 0, done.stderr
    shares = [tmp_path / f"share-{k}" for k in (2, 1)]
    assert msbsdf("merge", *shares, "--out", tmp_path / "merged").returncode == 0
    assert content(tmp_path / "one") == content(tmp_path / "two") == content(tmp_path / "merged")
    assert not list(tmp_path.glob("*.pieces"))


def test_a_case_is_the_same_whatever_else_is_swept(tmp_path):
    few = ("sweep", "walk", "--alpha", "0.6", "--theta", "60deg", "--samples", "2000")
    msbsdf(*WALK, "--out", tmp_path / "many")
    msbsdf(*few, "--out", tmp_path / "one")
    wanted = [float(r["energy"]) for r in table(tmp_path / "one" / "sweep.csv")]
    many = table(tmp_path / "many" / "sweep.csv")
    found = [r for r in many if r["alpha"] == "0.6" and float(r["theta"]) > 1]
    assert [float(r["energy"]) for r in found] == wanted


def test_a_file_says_the_same_as_the_command_line(tmp_path):
    study = tmp_path / "study.toml"
    study.write_text(
        'command = "walk"\nalpha = ["0.3:0.9:3"]\ntheta = [0, "60deg"]\nsamples = 2000\n'
    )
    msbsdf(*WALK, "--out", tmp_path / "a")
    assert msbsdf("sweep", study, "--out", tmp_path / "b").returncode == 0
    assert content(tmp_path / "a") == content(tmp_path / "b")
    pair = study.read_text().replace('"0.3:0.9:3"', "[1, 0.1], 0.5")
    study.write_text(pair)
    assert msbsdf("sweep", study, "--out", tmp_path / "c").returncode == 0
    assert {r["alpha"] for r in table(tmp_path / "c" / "sweep.csv")} == {"1,0.1", "0.5"}


@pytest.mark.parametrize(
    ("words", "part"),
    [
        (["validate"], "is not a command that can be swept"),
        (["walk", "--alphas", "0.1"], "'--alphas' is no such option"),
        (["walk", "0.1"], "'0.1' is not an option"),
        (["walk", "--alpha"], "--alpha needs a value"),
        (["walk", "--alpha", "0.1:1"], "is not a number"),
        (["walk", "--alpha", "1:0.1:4"], "LOW below HIGH"),
        (["walk", "--alpha", "0.1:1:1"], "N from 2"),
        (["walk", "--alpha", "log:0:1:3"], "above 0"),
        (["walk", "--alpha", "0:1:3"], "is not a roughness"),
        (["walk", "--theta", "0:90deg:3"], "is not an angle"),
        (["walk", "--theta", "5deg:1:3"], "belongs behind the second number too"),
        (["walk", "--theta", "0,0"], "is named twice"),
        (["walk", "--material", "conductor,wood"], "'wood'"),
        (["walk", "--slopes", "surface"], "go together"),
        (["walk", "--slopes", "surface,ggx", "--surface", SCAN], "go together"),
        (["simulate", "--surface", "missing.npy"], "does not exist"),
        (["simulate", "--surface", SCAN], "how far its points are apart"),
        (["simulate", "--surface", SCAN, "--alpha", "0.5"], "a file has its own"),
        (["simulate", "--surface", SCAN, "--seed", "0,1"], "no other realisation"),
        (["simulate", "--filter", "1,2"], "--filter without --surface"),
        (["compare", "--surface", SCAN, "--method", "exact"], "not for surfaces of files"),
        (["compare", "--slopes", "ggx"], "random surfaces are beckmann"),
        (["compare", "--heights-of", "ridges", "--gamma", "3"], "no other slopes have one"),
        (["compare", "--heights-of", "ridges", "--memory", "1"], "for Gaussian surfaces"),
        (["compare", "--method", "exact", "--memory", "1"], "the method walk-memory"),
        (["walk", "--shard", "3/2"], "K from 1 to N"),
        (["evaluate", "--method", "exact", "--material", "dielectric"], "exact"),
        (["missing.toml"], "cannot be read as TOML"),
    ],
)
def test_what_is_no_sweep_is_refused_in_a_sentence(words, part, scan, tmp_path):
    assert part in refused("sweep", *scan(words), "--out", tmp_path / "a")
    assert not (tmp_path / "a").exists()


def test_a_file_may_say_true_and_false_and_steps_that_differ(scan, tmp_path):
    path = scan([SCAN])[0]
    head = f'command = "simulate"\nsurface = "{path}"\nsamples = 160\nstep = [[0.3, 0.5]]\n'
    found = {}
    for said in ("true", "false", "2"):
        study = tmp_path / f"{said}.toml"
        study.write_text(f"{head}periodic = {said}\n")
        out = tmp_path / said
        if said == "2":
            assert "true or false is wanted" in refused("sweep", study, "--out", out)
            continue
        assert msbsdf("sweep", study, "--out", out).returncode == 0
        found[said] = content(out)
        assert "step" not in table(out / "sweep.csv")[0]
    assert found["true"] != found["false"]
    words = ("simulate", "--surface", path, "--step", "0.3,0.5", "--samples", "160")
    assert msbsdf("sweep", *words, "--out", tmp_path / "typed").returncode == 0
    assert content(tmp_path / "typed") == found["false"]


def test_judged_slopes_share_the_light_and_what_a_file_lacks_is_said(tmp_path):
    path, heights = tmp_path / "scan.npy", HeightField.random(0.6, extent=8, cells=8).heights
    heights[3, 3] = np.nan
    np.save(path, heights)
    words = ("--surface", path, "--step", "0.3", "--samples", "800", "--slopes", "beckmann,ggx")
    run = msbsdf("sweep", "compare", *words, "--theta", "1", "--out", tmp_path / "a")
    assert run.returncode == 0
    assert "scan.npy: 1 " in run.stderr
    assert "error bars are too short" in run.stderr
    rows = [r for r in table(tmp_path / "a" / "sweep.csv") if r["quantity"] == "part_correlation"]
    assert len({(r["slopes"], r["simulated"], r["difference"]) for r in rows}) == 2
    assert len({(r["simulated"], r["difference"]) for r in rows}) == 1


def test_a_surface_that_has_changed_is_another_sweep(tmp_path):
    path = tmp_path / "scan.npy"
    words = ("simulate", "--surface", path, "--step", "0.3", "--samples", "160")
    np.save(path, HeightField.random(0.6, extent=6, cells=6).heights)
    assert msbsdf("sweep", *words, "--out", tmp_path / "a").returncode == 0
    np.save(path, HeightField.random(0.6, 1, extent=6, cells=6).heights)
    assert "is of another sweep" in refused("sweep", *words, "--out", tmp_path / "a")


def test_comparisons_in_parts_stand_beside_others(tmp_path):
    few = ("--cells", "4", "--extent", "12", "--realisations", "16", "--samples", "800")
    few += ("--theta", "0.5", "--free-path-theta", "1", "--free-path-height", "0")
    words = (*few, "--heights-of", "gaussian,ridges:1", "--alpha", "0.5", "--out", tmp_path / "a")
    assert msbsdf("sweep", "compare", *words).returncode == 0
    found = {(row["heights_of"], row["quantity"]) for row in table(tmp_path / "a" / "sweep.csv")}
    assert {("gaussian", "total_variation"), ("ridges:1", "part_correlation")} <= found
    assert ("gaussian", "part_correlation") not in found


def test_cases_that_fail_are_rows_with_the_reason(tmp_path):
    words = ("evaluate", "--method", "exact", "--material", "conductor,dielectric")
    run = msbsdf("sweep", *words, "--theta", "0", "--samples", "64", "--out", tmp_path / "a")
    assert run.returncode == 0
    rows = table(tmp_path / "a" / "sweep.csv")
    failed = [row for row in rows if row["failure"]]
    assert [row["material"] for row in failed] == ["dielectric"]
    assert "exact" in failed[0]["failure"]
    assert "1 of 2 cases failed" in run.stderr


def test_a_sweep_goes_on_where_it_ended(tmp_path, monkeypatch):
    msbsdf(*WALK, "--out", tmp_path / "whole")
    write, left = npz.write, [4]

    def full_disk(path, *rest):
        if not left:
            raise OSError(errno.ENOSPC, "No space left on device", str(path))
        left.append(left.pop() - 1)
        if left[0] == 0:
            left.pop()
        write(path, *rest)

    words = (*WALK, "--threads", "1", "--out", tmp_path / "a")
    monkeypatch.setattr(npz, "write", full_disk)
    run = msbsdf(*words)
    assert run.returncode == 1
    assert "No space left on device" in run.stderr
    assert "4 of 6 pieces are done and kept in a.pieces" in run.stderr
    assert not (tmp_path / "a").exists()
    done = []
    monkeypatch.setattr(npz, "write", lambda *a: (done.append(a), write(*a)))
    assert msbsdf(*words).returncode == 0
    assert len(done) == 2
    assert content(tmp_path / "a") == content(tmp_path / "whole")
    before = (tmp_path / "a" / "run.json").read_bytes()
    said = json.loads(msbsdf(*words, "--json").stdout)
    assert said["rows"] == len(table(tmp_path / "a" / "sweep.csv"))
    again = msbsdf(*words)
    assert again.returncode == 0
    assert "it is whole" in again.stderr
    assert (tmp_path / "a" / "run.json").read_bytes() == before


def test_another_sweep_into_the_same_place_is_refused(tmp_path):
    msbsdf(*WALK, "--out", tmp_path / "a")
    said = refused(*WALK, "--ior", "1.4", "--out", tmp_path / "a")
    assert "is of another sweep: ior is not given there" in said
    pieces = tmp_path / "b.pieces"
    pieces.mkdir()
    lock = locked(pieces)
    run = msbsdf(*WALK, "--out", tmp_path / "b")
    assert run.returncode == 1
    assert "another sweep writes into" in run.stderr
    assert lock is not None


def test_a_dry_run_plans_every_piece_and_gives_way_to_the_sweep(tmp_path):
    assert msbsdf(*WALK, "--dry-run", "--out", tmp_path / "a").returncode == 0
    rows = table(tmp_path / "a" / "plan.csv")
    assert len(rows) == 6
    assert all(float(row["seconds"]) > 0 for row in rows)
    assert msbsdf(*WALK, "--out", tmp_path / "a").returncode == 0
    assert {p.name for p in (tmp_path / "a").iterdir()} >= {"sweep.csv", "pieces.zip"}
    assert not (tmp_path / "a" / "plan.csv").exists()


@pytest.mark.parametrize("threads", [1, 2])
def test_an_interrupted_sweep_keeps_its_pieces(threads, tmp_path):
    words = [*WALK[:-1], "400000", "--threads", str(threads), "--out", str(tmp_path / "a")]
    script = f"import signal; signal.signal(signal.SIGINT, signal.default_int_handler)\n{RUN}"
    run = subprocess.Popen(
        [sys.executable, "-c", script, *words], stderr=subprocess.PIPE, text=True
    )
    started = time.monotonic()
    while not list(tmp_path.glob("a.pieces/[0-9]*.npz")) and time.monotonic() < started + 60:
        time.sleep(0.01)
    run.send_signal(signal.SIGINT)
    _, said = run.communicate(timeout=60)
    assert run.returncode == 1
    assert "pieces are done and kept in a.pieces" in said
    assert "Traceback" not in said
    assert not (tmp_path / "a").exists()
    assert not list(tmp_path.glob("a.pieces/.*"))


def merged(tmp_path, *words):
    return msbsdf("merge", *words, "--out", tmp_path / "merged")


def test_seeds_merge_into_one_long_run(tmp_path):
    words = ("simulate", *SURFACES, "--theta", "0,1")
    places = [tmp_path / str(seed) for seed in range(3)]
    for seed, place in enumerate(places):
        assert msbsdf(*words, "--seed", seed, "--out", place).returncode == 0
    assert merged(tmp_path, *places).returncode == 0
    energy = {}
    for place in (*places, tmp_path / "merged"):
        for row in table(place / "energy.csv"):
            key = tuple(row[name] for name in ("theta_i_rad", "order", "side"))
            energy.setdefault(key, []).append((float(row["energy"]), float(row["stderr"])))
    first = energy["0.0", "1", "reflected"]
    # Near the mean of the three; with a third of the variance but for the mesh's error.
    assert abs(first[3][0] - np.mean([v for v, _ in first[:3]])) < 3 * first[3][1]
    record = json.loads((tmp_path / "merged" / "run.json").read_text())
    assert record["seed"] == [0, 1, 2]
    # A merged report is a report: it is compared, and refused where its seeds are in it already.
    said = msbsdf("merge", tmp_path / "merged", places[0], "--out", tmp_path / "more")
    assert said.returncode == 1
    assert "seed 0 is in two" in said.stderr
    assert msbsdf("compare", tmp_path / "merged", "--out", tmp_path / "c").returncode == 0


def test_sweeps_of_several_seeds_merge(tmp_path):
    for seed in (0, 1):
        msbsdf(*WALK, "--seed", seed, "--out", tmp_path / str(seed))
    msbsdf(*WALK, "--seed", "0,1", "--out", tmp_path / "both")
    assert merged(tmp_path, tmp_path / "0", tmp_path / "1").returncode == 0
    again = msbsdf("merge", tmp_path / "both", "--out", tmp_path / "again")
    assert again.returncode == 0
    assert content(tmp_path / "merged") == content(tmp_path / "again")
    rows, both = (table(tmp_path / name / "sweep.csv") for name in ("merged", "both"))
    assert len(both) == 2 * len(rows)
    pair = [float(r["energy"]) for r in both if r["alpha"] == "0.9" and r["order"] == "1"][:2]
    (mean,) = [
        float(r["energy"])
        for r in rows
        if r["alpha"] == "0.9" and r["order"] == "1" and float(r["theta"]) == 0
    ]
    assert mean == pytest.approx(sum(pair) / 2, rel=1e-12)


def test_what_does_not_add_up_is_refused_by_name(tmp_path, monkeypatch):
    walk = ("walk", "--samples", "1000", "--theta", "0")
    for name, more in {
        "a": (),
        "same": (),
        "ior": ("--alpha", "0.6"),
        "b": ("--seed", "1"),
    }.items():
        msbsdf(*walk, *more, "--out", tmp_path / name)
    with monkeypatch.context() as patch:
        patch.setattr("msbsdf_cli.results.manifest.__version__", "0.0.1")
        msbsdf(*walk, "--seed", "2", "--out", tmp_path / "old")
    furnace = ("furnace", "--method", "single", "--theta", "0", "--alpha", "1")
    msbsdf(*furnace, "--out", tmp_path / "furnace")
    msbsdf(*WALK, "--shard", "1/2", "--out", tmp_path / "s")
    share = tmp_path / "s"
    for other, part in {
        "same": "the seed 0 is in two",
        "ior": "ior has --alpha (0.6, 0.6)".replace("(0.6, 0.6)", "[0.6, 0.6]"),
        "old": "is of version 0.0.1",
        "furnace": "is a report of `furnace`",
        "s": "is no report of a sweep",
        "a": "named twice",
        "nowhere": "is not a report",
    }.items():
        run = merged(tmp_path, tmp_path / "a", tmp_path / other)
        assert run.returncode == 1, other
        assert part in run.stderr, other
    assert "pieces of the sweep are in none" in merged(tmp_path, share).stderr
    assert not (tmp_path / "merged").exists()


def test_the_picture_comes_from_the_table_alone(tmp_path):
    words = ("--alpha", "0.3:0.9:3", "--theta", "0:80deg:4", "--seed", "0,1")
    run = ("sweep", "walk", *words, "--samples", "1000", "--material", "conductor,diffuse")
    msbsdf(*run, "--out", tmp_path / "a", pictures=True)
    rows = table(tmp_path / "a" / "sweep.csv")
    grid = read_grid(tmp_path / "a" / "sweep.csv")
    assert grid.names == ["material", "alpha", "theta"]
    both = [
        (float(r["energy"]), float(r["stderr"]))
        for r in rows
        if (r["material"], r["alpha"], r["order"]) == ("diffuse", "0.9", "2")
        and float(r["theta"]) == 0
    ]
    place = grid.series.index("2 reflected"), 1, 2, 0
    assert grid.value[place] == pytest.approx((both[0][0] + both[1][0]) / 2)
    assert grid.stderr[place] == pytest.approx(np.hypot(both[0][1], both[1][1]) / 2)
    first = (tmp_path / "a" / "sweep.png").read_bytes()
    draw_sweep(tmp_path / "a" / "sweep.csv", tmp_path / "again.png")
    assert (tmp_path / "again.png").read_bytes() == first


def test_what_is_missing_for_a_cluster_is_named(tmp_path, monkeypatch):
    monkeypatch.setattr("msbsdf_cli.cli.sweeping.has_dask", lambda: False)
    said = refused(*WALK, "--scheduler", "tcp://127.0.0.1:9", "--out", tmp_path / "a")
    assert "msbsdf[cluster]" in said
