"""The page of a report: whole, small, and nothing from elsewhere."""

import json
import re
from html.parser import HTMLParser

import numpy as np
import pytest
from command_line import msbsdf
from PIL import Image

from msbsdf_cli.pages import page
from msbsdf_cli.pages.citations import papers
from msbsdf_cli.plots import FOR_PAGE, PAGE_OF
from msbsdf_cli.plots.style import panels, save

VOID = {"meta", "link", "img", "input", "br"}


class Checked(HTMLParser):
    """Every element is closed in its turn; attributes by element."""

    def __init__(self):
        super().__init__()
        self.open, self.found = [], []

    def handle_starttag(self, tag, attrs):
        self.found.append((tag, dict(attrs)))
        if tag not in VOID:
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag


def parsed(path):
    checked = Checked()
    checked.feed(path.read_text(encoding="utf-8"))
    assert not checked.open
    return checked.found


@pytest.fixture(scope="module")
def report(tmp_path_factory):
    out = tmp_path_factory.mktemp("page") / "r"
    words = ("--samples", "5000", "--cells", "4", "--extent", "6", "--realisations", "3")
    words += ("--free-path-theta", "1", "--free-path-height", "0")
    run = msbsdf("compare", *words, "--theta", "0,45deg", "--out", out, pictures=True)
    assert run.returncode == 0
    for name in ("agreement.png", "free_path.png", "lobes.png"):
        assert (out / name).stat().st_size > 10_000
    return out


def test_a_page_is_whole_and_takes_nothing_from_elsewhere(report):
    found = parsed(report / "index.html")
    sources = [a[k] for _, a in found for k in ("src", "href") if k in a]
    assert sources
    assert all(source.startswith("data:") for source in sources)
    assert (report / "index.html").stat().st_size < 2e6
    assert all(a.get("alt") for tag, a in found if tag == "img")


def test_a_page_says_the_sentence_first_then_how_to_repeat_and_to_cite(report):
    text = (report / "index.html").read_text()
    record = json.loads((report / "run.json").read_text())
    assert "index.html" in record["files"]
    first = re.search(r'<p class="first">(.*?)</p>', text, re.DOTALL).group(1)
    assert first == record["summary"]
    assert text.index(first) < text.index("<figure") < text.index("<table")
    for part in (record["command_line"], record["processor"], "HHdD16", "Heitz15"):
        assert part in text
    assert "theta_i [degrees]" in text
    assert "45" in text


def test_the_slider_turns_over_all_angles(report):
    found = parsed(report / "index.html")
    (slider,) = [a for tag, a in found if tag == "input"]
    slides = [a for tag, a in found if tag == "figure" and a.get("class") == "slide"]
    assert len(slides) == int(slider["max"]) + 1 == 2
    assert [("hidden" in a) for a in slides] == [False, True]


def test_lines_are_drawn_as_lines_and_maps_as_bitmaps(report):
    text = (report / "index.html").read_text()
    kind = r'<img src="data:image/([a-z+]+);[^>]*>\s*<figcaption>[^<]*<code>([a-z_]*)'
    kinds = {name: kind for kind, name in re.findall(kind, text)}
    assert kinds["agreement"] == kinds["free_path"] == "svg+xml"
    assert kinds["lobes"] in ("png", "webp")
    assert not list(report.rglob("*.svg"))


def test_equal_pictures_are_equal_files(tmp_path, monkeypatch):
    monkeypatch.setenv(PAGE_OF, str(tmp_path))

    def drawn():
        figure, axes = panels(1, [2.0], 1.5)
        axes[0, 0].plot([1, 2], clip_path=None, label="a")
        axes[0, 0].scatter([0, 1], [1, 2])
        save(figure, tmp_path / "a.png")
        return [path.read_bytes() for path in sorted(tmp_path.iterdir())]

    assert len(drawn()) == 2
    assert drawn() == drawn()


def test_of_many_pictures_of_lines_the_last_are_bitmaps(tmp_path):
    for name in ("agreement", "slice", "free_path"):
        Image.new("RGB", (8, 8)).save(tmp_path / f"{name}.png")
        (tmp_path / f"{name}{FOR_PAGE}.svg").write_text("<svg/>".ljust(page.SVG_BYTES // 2))
    made = {"command": "walk", "warnings": [], "options": {}, "versions": {}}
    (tmp_path / "run.json").write_text(json.dumps(made))
    page.write_page(tmp_path)
    text = (tmp_path / "index.html").read_text()
    assert re.findall("data:image/([a-z]+)", text) == ["svg", "svg", "png"]
    assert len(text) < 2e6
    assert not list(tmp_path.glob("*.svg"))


def test_large_pictures_are_packed_and_keep_their_colours(tmp_path):
    rng = np.random.Generator(np.random.PCG64(0))
    noise = np.repeat(np.repeat(rng.integers(0, 256, (250, 400, 3), np.uint8), 4, 0), 4, 1)
    for name in ("agreement", "lobes"):
        Image.fromarray(noise).save(tmp_path / f"{name}.png", compress_level=0)
    made = {"command": "walk", "warnings": ["so & so"], "options": {}, "versions": {}}
    (tmp_path / "run.json").write_text(json.dumps(made))
    page.write_page(tmp_path)
    text = (tmp_path / "index.html").read_text()
    assert len(text) < 2e6
    assert text.count("data:image/webp") == 2
    assert "so &amp; so" in text


def test_a_page_of_pictures_that_nothing_packs_has_smaller_ones(tmp_path):
    rng = np.random.Generator(np.random.PCG64(0))
    Image.fromarray(rng.integers(0, 256, (1500, 1500, 3), np.uint8)).save(tmp_path / "lobes.png")
    (tmp_path / "t.csv").write_text("x\n" + "1.5\n" * 700)
    made = {"command": "walk", "warnings": [], "options": {}, "versions": {}}
    (tmp_path / "run.json").write_text(json.dumps(made))
    page.write_page(tmp_path)
    assert len((tmp_path / "index.html").read_text()) < 2e6


def test_papers_are_those_behind_what_ran():
    keys = [entry.partition("{")[2].partition(",")[0] for entry in papers("walk", {})]
    assert keys == ["HHdD16"]
    options = {"slopes": "student-t", "method": ["exact", "turquin", "exact"]}
    keys = [e.partition("{")[2].partition(",")[0] for e in papers("evaluate", options)]
    assert keys == ["HHdD16", "RBSM17", "BdE22", "Tur19"]
