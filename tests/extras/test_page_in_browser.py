"""The page of a report in a real browser: it draws, asks for nothing, and reads well to all."""

import shutil

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

COMMANDS = {
    "compare": ("--samples", "5000", "--cells", "4", "--extent", "6", "--realisations", "3"),
    "evaluate": ("--method", "single", "--theta", "1"),
    "figures": ("heitz-10", "wang-2", "wang-16", "--quick"),
    "sweep": ("walk", "--alpha", "0.3:0.9:3", "--theta", "0:80deg:4", "--samples", "1000"),
}


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


@pytest.mark.parametrize("command", COMMANDS)
@pytest.mark.parametrize("dark", [False, True], ids=["light", "dark"])
def test_a_page_draws_without_errors_or_requests(command, dark, browser, tmp_path_factory):
    out = tmp_path_factory.getbasetemp() / f"page-{command}"
    if not out.exists():
        run = msbsdf(command, *COMMANDS[command], "--out", out, pictures=True)
        assert run.returncode == 0, run.stderr
    features = [{"name": "prefers-color-scheme", "value": "dark" if dark else "light"}]
    browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": features})
    browser.get_log("performance")
    browser.get((out / "index.html").as_uri())
    assert browser.get_log("browser") == []
    messages = [entry["message"] for entry in browser.get_log("performance")]
    assert not [m for m in messages if "requestWillBeSent" in m and '"url":"http' in m]
    sizes = browser.execute_script("return [...document.images].map(i => i.naturalWidth)")
    assert sizes
    assert min(sizes) > 0
    checker = axe.Axe(browser)
    checker.inject()
    found = checker.run()["violations"]
    assert [v["id"] for v in found if v["impact"] in ("serious", "critical")] == []


def test_tables_sort_and_the_slider_turns(browser, tmp_path_factory):
    out = tmp_path_factory.getbasetemp() / "page-compare"
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
