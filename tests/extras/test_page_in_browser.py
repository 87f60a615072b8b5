"""The page of a report in a real browser: it draws, asks for nothing, and reads well to all."""

import shutil

import numpy as np
import pytest
from command_line import msbsdf

webdriver = pytest.importorskip("selenium.webdriver")
axe = pytest.importorskip("axe_selenium_python")

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")
DRIVER = shutil.which("chromedriver")
pytestmark = pytest.mark.skipif(not (CHROMIUM and DRIVER), reason="Chromium is not installed")

FLAGS = (
    *("--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run"),
    *("--disable-background-networking", "--disable-component-update", "--disable-sync"),
)

PAGES = {
    "compare": "compare --samples 5000 --cells 4 --extent 6 --realisations 3",
    "own surface": "compare --surface {here}/heights.npy --step 1 --samples 2000",
    "methods": "compare {here}/simulate --method single,exact",
    "simulate": "simulate --samples 2000 --cells 4 --extent 6 --realisations 3",
    "walk": "walk --samples 2000",
    "memory": "walk --memory 1 --samples 2000",
    "merge": "merge {here}/walk-1 {here}/walk-2",
    "evaluate": "evaluate --method single --theta 1",
    "validate": "validate --quick",
    "furnace": "furnace --method single,solve --theta 1",
    "stability": "stability --method single",
    "tradeoff": "tradeoff --method single --theta 1 --no-surfaces --samples 256 --replicates 4",
    "render": "render plate --method single,energy-compensated --samples 2 --width 48",
    "recommend": "recommend {here}/scene.toml",
    "export": "export --alpha 0.5",
    "figures": "figures heitz-10 wang-2 wang-16 --quick",
    "sweep": "sweep walk --alpha 0.3:0.9:3 --theta 0:80deg:4 --samples 1000",
}
"""A page of each kind, and the command that makes it."""

GIVEN = {
    "simulate": "simulate --samples 5000 --cells 4 --extent 6 --realisations 3",
    "walk-1": "walk --samples 2000 --seed 1",
    "walk-2": "walk --samples 2000 --seed 2",
}
"""Reports that commands read."""

SCENE = """
[[surface]]
name = "tap"
material = "conductor"
alpha = 0.3
"""


@pytest.fixture(scope="module")
def here(tmp_path_factory):
    """A folder for reports, with what some of them are made of."""
    place = tmp_path_factory.mktemp("pages")
    x = np.arange(64) * 2 * np.pi / 64
    np.save(place / "heights.npy", np.sin(3 * x)[:, None] * np.cos(2 * x))
    (place / "scene.toml").write_text(SCENE)
    for name, command in GIVEN.items():
        _make(command, place / name)
    return place


def _make(command, out, **pictures):
    run = msbsdf(*command.split(), "--out", out, **pictures)
    assert run.returncode == 0, run.stderr


def _report(here, page):
    """Where a page stands, which is made if it is not there."""
    out = here / f"page-{page}"
    if not out.exists():
        _make(PAGES[page].format(here=here), out, pictures=True)
    return out


@pytest.fixture(scope="module")
def browser(tmp_path_factory):
    options = webdriver.ChromeOptions()
    options.binary_location = CHROMIUM
    for flag in (*FLAGS, f"--user-data-dir={tmp_path_factory.mktemp('chromium')}"):
        options.add_argument(flag)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL", "performance": "ALL"})
    driver = webdriver.Chrome(options, webdriver.ChromeService(DRIVER))
    yield driver
    driver.quit()


@pytest.mark.parametrize("page", PAGES)
@pytest.mark.parametrize("dark", [False, True], ids=["light", "dark"])
def test_a_page_draws_without_errors_or_requests(page, dark, browser, here):
    out = _report(here, page)
    features = [{"name": "prefers-color-scheme", "value": "dark" if dark else "light"}]
    browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": features})
    browser.get_log("performance")
    browser.get((out / "index.html").as_uri())
    assert browser.get_log("browser") == []
    messages = [entry["message"] for entry in browser.get_log("performance")]
    assert not [m for m in messages if "requestWillBeSent" in m and '"url":"http' in m]
    sizes = browser.execute_script("return [...document.images].map(i => i.naturalWidth)")
    assert bool(sizes) == any(out.rglob("*.png"))
    assert all(size > 0 for size in sizes)
    checker = axe.Axe(browser)
    checker.inject()
    found = checker.run()["violations"]
    assert [v["id"] for v in found if v["impact"] in ("serious", "critical")] == []


def test_tables_sort_and_the_slider_turns(browser, here):
    out = _report(here, "compare")
    browser.get((out / "index.html").as_uri())
    script = """
    const table = document.querySelector("table.sorts");
    const head = [...table.tHead.rows[0].cells].find(c => c.textContent === "simulated");
    head.firstElementChild.click();
    return [...table.tBodies[0].rows].map(r => Number(r.cells[head.cellIndex].textContent));
    """
    numbers = browser.execute_script(script)
    assert numbers == sorted(numbers)
    script = """
    const slider = document.getElementById("angle");
    slider.value = slider.max;
    slider.dispatchEvent(new Event("input"));
    return [...document.querySelectorAll(".slide")].map(s => s.hidden);
    """
    assert browser.execute_script(script) == [True, True, True, False]
