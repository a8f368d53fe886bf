"""The page in a real browser: quiet, alone, readable and usable by keyboard, wide and narrow, light and dark."""

import itertools
import json

import numpy as np
import pytest

import jaxbuffer as jb
from jaxbuffer.output.folder import load
from jaxbuffer.output.page_data import FORCE, chart
from jaxbuffer.pages.compare import comparison
from jaxbuffer.pages.page import Page, PageSection
from jaxbuffer.pages.review import review
from made_up_choice import made_up_choice
from made_up_fit import made_up_fit
from pages.report_folders import every_kind

pytestmark = [pytest.mark.slow, pytest.mark.long]
WIDTHS = (1280, 420)
LEAST_CONTRAST, LARGE_CONTRAST = 4.5, 3.0  # WCAG 2.2, 1.4.3 (AA), of text and of large text

# every text with its colour on the nearest background that is not transparent; drawn figures are pictures
CONTRAST = """
(() => {
  const numbers = text => text.match(/[\\d.]+/g).map(Number);
  const light = c => { c /= 255; return c <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4; };
  const luminance = ([r, g, b]) => 0.2126 * light(r) + 0.7152 * light(g) + 0.0722 * light(b);
  const behind = element => {
    for (let at = element; at; at = at.parentElement) {
      const colour = numbers(getComputedStyle(at).backgroundColor);
      if (colour.length < 4 || colour[3] > 0) return colour;
    }
    return [255, 255, 255];
  };
  const found = [];
  const walker = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  for (let node = walker.nextNode(); node; node = walker.nextNode()) {
    const element = node.parentElement;
    if (!node.data.trim() || element.closest("script, style, .picture")) continue;
    const style = getComputedStyle(element), drawn = element.namespaceURI.endsWith("svg");
    const [a, b] = [numbers(drawn ? style.fill : style.color), behind(element)].map(luminance);
    const ratio = (Math.max(a, b) + 0.05) / (Math.min(a, b) + 0.05);
    const size = parseFloat(style.fontSize), large = size >= 24 || (size >= 18.66 && style.fontWeight >= 700);
    found.push([node.data.trim().slice(0, 40), ratio, large]);
  }
  return found;
})()
"""
REACHED = """
(() => {
  const at = document.activeElement, style = getComputedStyle(at), box = at.getBoundingClientRect();
  const seen = style.outlineStyle !== "none" && parseFloat(style.outlineWidth) >= 2;
  const all = [...document.querySelectorAll("*")];
  return [at === document.body ? -1 : all.indexOf(at), at.outerHTML.slice(0, 80), seen && box.width > 0, box.left];
})()
"""
BROKEN_WORDS = """
(() => {
  const broken = []; let words = 0;
  const walker = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  for (let node = walker.nextNode(); node; node = walker.nextNode()) {
    if (!node.parentElement.closest("table")) continue;
    for (const found of node.data.matchAll(/\\p{L}+/gu)) {
      const range = document.createRange();
      range.setStart(node, found.index);
      range.setEnd(node, found.index + found[0].length);
      words += 1;
      if (new Set([...range.getClientRects()].map(it => it.top)).size > 1) broken.push(found[0]);
    }
  }
  return [broken, words];
})()
"""
USABLE = """
(() => {
  const all = [...document.querySelectorAll("*")];
  const asked = "a[href], button, input, select, textarea, summary, [tabindex='0']";
  return [...document.querySelectorAll(asked)].filter(it => it.checkVisibility()).map(it => all.indexOf(it));
})()
"""


@pytest.fixture(scope="module")
def pages(tmp_path_factory):
    """A review of every kind of result, and a comparison."""
    place = tmp_path_factory.mktemp("pages")
    folders = every_kind(tmp_path_factory.mktemp("results"))
    for name, result in (("choice", made_up_choice(broken_corners=3)), ("fit", made_up_fit(converged=False))):
        folders[name] = place / name
        jb.save(result, folders[name])
    made = {
        "review": review([load(folder) for folder in folders.values()]),
        "comparison": comparison([load(folders[name]) for name in ("run", "other")]),
    }
    for name, page in made.items():
        (place / f"{name}.html").write_text(page.html(), encoding="utf-8")
    return place


@pytest.fixture(params=["review", "comparison"])
def page(pages, request):
    return pages / f"{request.param}.html"


@pytest.mark.parametrize("dark", [False, True], ids=["light", "dark"])
@pytest.mark.parametrize("width", WIDTHS)
def test_it_is_quiet_and_alone_and_fits(browser, page, width, dark):
    browser.open(page, width, dark)
    said = [event for event in browser.events if event[0] in ("Runtime.consoleAPICalled", "Runtime.exceptionThrown")]
    said += [event for event in browser.events if event[0] == "Log.entryAdded"]
    assert said == []
    asked = [found["request"]["url"] for method, found in browser.events if method == "Network.requestWillBeSent"]
    assert [url for url in asked if not url.startswith("data:")] == [page.resolve().as_uri()]
    assert browser.run("document.documentElement.scrollWidth") <= width
    assert browser.run("matchMedia('(prefers-color-scheme: dark)').matches") is dark


@pytest.mark.parametrize("dark", [False, True], ids=["light", "dark"])
@pytest.mark.parametrize("width", WIDTHS)
def test_text_stands_out(browser, page, width, dark):
    browser.open(page, width, dark)
    browser.run("document.querySelectorAll('details').forEach(it => { it.open = true; })")
    found = browser.run(CONTRAST)
    assert len(found) > 50
    weak = [(text, ratio) for text, ratio, large in found if ratio < (LARGE_CONTRAST if large else LEAST_CONTRAST)]
    assert weak == []


@pytest.mark.parametrize("width", WIDTHS)
def test_everything_is_reached_by_keyboard_and_seen(browser, page, width):
    browser.open(page, width)
    browser.run("document.querySelectorAll('details').forEach(it => { it.open = true; })")
    wanted, reached = set(browser.run(USABLE)), set()
    assert len(wanted) > 10
    for _ in range(2 * len(wanted)):
        browser.press("Tab")
        number, element, seen, left = browser.run(REACHED)
        if number < 0 or number in reached:
            break
        assert seen, element
        assert left > -1.0, element  # a pixel: scrolling rounds
        reached.add(number)
    assert wanted <= reached


def test_no_word_is_broken(browser, page):
    """At 420 pixels, too: the letters of every word of a table stand in one line."""
    browser.open(page, 420)
    browser.run("document.querySelectorAll('details').forEach(it => { it.open = true; })")
    broken, words = browser.run(BROKEN_WORDS)
    assert words > 100 and broken == []


def test_on_paper_nothing_is_lost_and_no_heading_stands_alone(browser, page):
    browser.open(page)
    folded = "[...document.querySelectorAll('details tr, details pre')]"
    assert browser.run(f"{folded}.length") > 0
    browser.ask("Emulation.setEmulatedMedia", media="print")
    seen = "it => it.checkVisibility() && it.getBoundingClientRect().height > 0"
    assert browser.run(f"{folded}.every({seen})")
    kept = "[...document.querySelectorAll('h1, h2, caption, summary')].map(it => getComputedStyle(it).breakAfter)"
    assert set(browser.run(kept)) == {"avoid"}


def test_pictures_and_headings_are_named(browser, page):
    browser.open(page)
    assert browser.run("[...document.images].filter(it => !it.alt).length") == 0
    drawn = "[...document.querySelectorAll('[role=img]')].filter(it => !it.getAttribute('aria-label')).length"
    assert browser.run(drawn) == 0
    levels = browser.run("[...document.querySelectorAll('h1,h2,h3,h4,h5,h6')].map(it => Number(it.tagName[1]))")
    assert levels[0] == 1 and levels.count(1) == 1
    assert all(after <= before + 1 for before, after in itertools.pairwise(levels))
    assert browser.run("document.documentElement.lang") == "en"


def test_forces_are_read_off_by_keyboard(browser, pages):
    """The value told at a time is that of the record, between its neighbours; closer shows less time."""
    browser.open(pages / "comparison.html")
    data = json.loads(browser.run("document.querySelector('.curves script').textContent"))
    told = browser.run("document.querySelector('.curves .clock').textContent")
    highest = max(data[-1]["values"])
    assert f"{highest:.4g}" in told.replace(",", "")
    browser.run("document.querySelector('.curves .time').focus()")
    browser.press("ArrowRight")
    again = browser.run("document.querySelector('.curves .clock').textContent")
    time = float(again.split()[0])
    assert time > float(told.split()[0])
    curve = data[0]
    known = np.interp(time, curve["time"], curve["values"])
    said = float(again.split(" · ")[1].rpartition(": ")[2].removesuffix(" N"))
    assert said == pytest.approx(known, rel=2e-3, abs=1e-3 * highest)
    browser.run("document.querySelector('.curves .closer').focus()")
    for _ in range(3):  # 4³ times closer: less than the pulse of 3 ms in 40 ms
        browser.press("Enter")
    length = "(() => { const it = document.querySelector('.curves polyline'); return it.points.length; })()"
    assert 0 < browser.run(length) < len(curve["values"])
    assert not [event for event in browser.events if event[0] == "Runtime.exceptionThrown"]


def test_a_run_is_played_by_keyboard(browser, pages):
    browser.open(pages / "review.html")
    browser.run("document.querySelector('.play').focus()")
    browser.press("Enter")
    assert browser.run("document.querySelector('.play').textContent") == "Pause"
    later = "new Promise(done => setTimeout(() => done(Number(document.querySelector('.motion .time').value)), 400))"
    assert browser.run(later) >= 2
    browser.press("Enter")
    assert browser.run("document.querySelector('.play').textContent") == "Play"


def test_early_impacts_are_shown_first(browser, tmp_path):
    """Impacts in the first tenth of a run, then a lasting push: the view ends soon after the last touchdown, and the
    reading begins at the last curve's peak; the whole run is a button away."""
    one = {"name": "one", "time": [0.0, 0.01, 0.02, 0.03, 1.0], "values": [0.0, 300.0, 0.0, 50.0, 90.0]}
    other = {**one, "name": "other", "values": [0.0, 100.0, 0.0, 120.0, 0.0]}
    made = chart("Contact force", FORCE, [one, other])
    file = tmp_path / "page.html"
    file.write_text(Page("Forces", "", [], [PageSection("Forces", curves=[made])]).html(), encoding="utf-8")
    browser.open(file)
    clock = browser.run("document.querySelector('.clock').textContent")
    assert clock.startswith("0.03") and clock.endswith("other: 120 N")
    assert "Shown first: the beginning" in browser.run("document.querySelector('figcaption').textContent")
    last = "Math.max(...[...document.querySelectorAll('.chart text[text-anchor=middle]')].map(it => +it.textContent))"
    assert browser.run(last) <= 0.036  # 1.2 times the later of touchdown and peak
    browser.run("document.querySelector('.whole').click()")
    assert browser.run(last) == 1.0
