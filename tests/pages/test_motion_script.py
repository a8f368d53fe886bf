"""The page's script that moves a run's pictures."""

import json
import shutil
import subprocess
from importlib.resources import files

import pytest

SCRIPT = files("jaxbuffer.pages") / "templates" / "motion.js"
PAGE = """
const element = () => ({ attributes: {}, style: {}, children: [], addEventListener() {}, remove() {},
  setAttribute(name, value) { this.attributes[name] = value; },
  appendChild(child) { this.children.push(child); return child; } });
const document = { createElementNS: element };
"""
SEEN = """
  const parts = {}, root = { querySelector: name => parts[name] ??= element() };
  root.querySelector("script").textContent = JSON.stringify(data);
  const motion = new Motion(root), clocks = [], ways = [];
  for (const k of [0, 1]) {
    motion.show(k);
    clocks.push(parts[".clock"].textContent);
    ways.push(parts[".closer"].children.map(child => child.attributes.points));
  }
  console.log(JSON.stringify([clocks, ways])); }
"""


def shown(data):
    """What the clock says at both instants, and the points of each line of the closer look."""
    source = SCRIPT.read_text()
    program = f"{PAGE}const data = {json.dumps(data)};\n{source[: source.rindex('document.querySelectorAll')]}{SEEN}"
    done = subprocess.run(["node", "-e", program], capture_output=True, text=True, check=True, timeout=60)
    return json.loads(done.stdout)


def record(**more):
    """Two instants of one body that goes from (1, 2) to (3, 4), seen closer without shapes of its own."""
    detail = {"body": -1, "x": 0.0, "y": 0.0, "half": 5.0, "title": "", "shapes": [], "path": None}
    return {
        "times": [0.0, 0.5],
        "paces": ["slow", "slow"],
        "frames": [[[1.0, 2.0, 0.0]], [[3.0, 4.0, 0.0]]],
        "forces": [[], []],
        "acting": [[3.25], [0.0]],
        "contacts": ["cone"],
        "largest": 3.25,
        "bounds": [[0.0, 0.0], [5.0, 5.0]],
        "shapes": [],
        "detail": {**detail, **more},
    }


pytestmark = pytest.mark.skipif(shutil.which("node") is None, reason="no node is installed")


def test_a_run_without_arrows_tells_its_forces_and_draws_the_path_so_far():
    clocks, ways = shown(record(path=0))
    assert clocks == ["0.000 s · slow · 3.25 N cone", "0.5000 s · slow"]
    # The first line is the arrow's, of which there is none.
    assert ways == [[None, "1,-2"], [None, "1,-2 3,-4"]]


def test_a_record_of_an_earlier_version_tells_the_arrows_sizes():
    data = record()
    del data["acting"], data["detail"]["path"]
    data["forces"] = [[[1.0, 2.0, 0.3, 0.4]], [[1.0, 2.0, 0.0, 0.0]]]
    data["largest"] = 0.5
    clocks, ways = shown(data)
    assert clocks == ["0.000 s · slow · 0.500 N cone", "0.5000 s · slow"]
    # An arrow of a fifth of the picture's width, and its head.
    assert ways[0][0].startswith("1,-2 2.2,-3.6 ") and ways[1] == [""]
