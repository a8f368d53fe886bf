"""Folders with results of every kind, of a dropped bar, as the commands write them."""

from jaxbuffer.cli.entry import run

STUDY = """kind = "bar_drop"
[problem.variables]
impact.stiffness = [1e10, 1e12]
[problem.constraints]
peak_force = 2500.0
[problem.objective]
peak_force = 1.0
"""
OVER = ("--over", "scenario.height=0.1:0.2:2", "--over", "impact.stiffness=1e10:1e12:2:log")
RANGES = ("--over", "scenario.height=0.1:0.2", "--over", "impact.stiffness=1e10:1e12")
COMMANDS = {
    "run": ("simulate", "{study}"),
    "other": ("simulate", "{study}", "--impact.damping", "7.5"),
    "sensitivity": ("sensitivity", "{study}", "--wrt", "impact.damping", "--certify", "none"),
    "tuned": ("tune", "{study}", "--iterations", "2", "--starts", "1"),
    "sweep": ("sweep", "{study}", *OVER),
    "sample": ("sample", "{study}", *RANGES, "--count", "16", "--method", "sobol", "--indices", "--surface"),
    "front": ("pareto", "{study}", "--objectives", "peak_force,penetration", "--points", "2", "--starts", "1"),
}


def every_kind(place):
    """The folders by what is in them."""
    study = place / "study.toml"
    study.write_text(STUDY)
    for name, words in COMMANDS.items():
        assert run([*(word.format(study=study) for word in words), "--output", str(place / name)]) == 0
    return {name: place / name for name in COMMANDS}
