"""The sliders in a real browser: by keyboard, at both widths, and on paper."""

import base64
import json

import pytest

from jaxbuffer.output.folder import Results
from jaxbuffer.output.tuned_records import tuned_record
from jaxbuffer.pages.review import review
from jaxbuffer.study.load import loads
from made_up import made_up_tuning
from pages.made_what_if import STUDY, made_what_if
from pages.test_report_browser import BROKEN_WORDS, CONTRAST, LARGE_CONTRAST, LEAST_CONTRAST

pytestmark = [pytest.mark.slow, pytest.mark.long]
CELLS = "[...document.querySelectorAll('.over-all tbody tr')].map(it => [...it.cells].map(cell => cell.textContent))"


@pytest.fixture(scope="module")
def page(tmp_path_factory):
    place, tuned = tmp_path_factory.mktemp("page"), made_up_tuning(loads(STUDY, "study.toml").problem())
    what_if = json.loads(json.dumps(made_what_if(failing=True).record()))
    results = Results(place, records={"tuned": tuned_record(tuned), "what_if": what_if}, design=tuned.design)
    (place / "page.html").write_text(review([results]).html(), encoding="utf-8")
    return place / "page.html"


@pytest.mark.parametrize("width", [1280, 420])
def test_it_is_quiet_fits_and_can_be_read(browser, page, width):
    browser.open(page, width)
    assert [it for it in browser.events if it[0] in ("Runtime.exceptionThrown", "Log.entryAdded")] == []
    assert browser.run("document.documentElement.scrollWidth") <= width
    weak = [it for it in browser.run(CONTRAST) if it[1] < (LARGE_CONTRAST if it[2] else LEAST_CONTRAST)]
    broken, _ = browser.run(BROKEN_WORDS)
    assert weak == [] and broken == []
    left = browser.run("document.querySelector('.slide input').getBoundingClientRect().right")
    assert left <= width, "a slider is seen without scrolling"


def test_a_slider_moves_by_keyboard_and_back(browser, page):
    browser.open(page)
    before = browser.run(CELLS)
    assert all(row[4] == "–" for row in before), "at the tuned design nothing has changed"
    browser.run("document.querySelectorAll('.slide input')[1].focus()")
    for _ in range(6):
        browser.press("ArrowRight")
    here = float(browser.run("document.querySelectorAll('.here')[1].textContent"))
    assert 300.0 < here <= 450.0
    after = browser.run(CELLS)
    assert after[1][1] != before[1][1] and after[1][4].startswith("-"), "a stiffer spring has a smaller stroke"
    assert browser.run("document.querySelectorAll('.slide input')[1].getAttribute('aria-valuetext')").endswith(" N/m")
    browser.run("document.querySelector('.reset').click()")
    assert browser.run(CELLS) == before


def test_where_the_nearest_run_ended_otherwise_no_number_is_shown(browser, page):
    browser.open(page)
    browser.run("document.querySelector('.what-if').whatIf.show([0.99, 0.5])")
    assert {row[1] for row in browser.run(CELLS)} == {"–"}
    words = browser.run("document.querySelector('.ends').textContent")
    assert words == "No number is shown here: not all runs around are captured in 0.3 m/s, 0°."
    assert "A number is shown only where all captures around" in browser.run("document.body.textContent")
    each = browser.run("[...document.querySelectorAll('.each tbody tr')].map(it => it.cells[1].textContent)")
    assert each[2] == "–" and "–" not in each[:2]


def test_paper_shows_the_tuned_design(browser, page):
    browser.open(page)
    before = browser.run(CELLS)
    browser.run("document.querySelector('.what-if').whatIf.show([0.2, 0.9])")
    assert browser.run(CELLS) != before
    seen = "window.printed = null; addEventListener('beforeprint', () => { window.printed = " + CELLS + "; })"
    browser.run(seen)
    browser.ask("Emulation.setEmulatedMedia", media="", features=[])
    assert base64.b64decode(browser.ask("Page.printToPDF")["data"]).startswith(b"%PDF")
    assert browser.run("window.printed") == before
    assert browser.run(CELLS) != before, "the screen shows again what it did"
    browser.ask("Emulation.setEmulatedMedia", media="print")
    assert browser.run("[...document.querySelectorAll('.slide')].some(it => it.checkVisibility())") is False
