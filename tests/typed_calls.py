"""What type checkers say of calls as users write them: `make types` checks this file, nothing runs it.

What is right passes, and has the type named. What is wrong has a comment that names mypy's error; both mypy and pyright
take a comment without an error for one.
"""

from typing import Any, assert_type

import numpy as np

import jaxbuffer as jb
from jaxbuffer.fields import Part
from jaxbuffer.mechanisms.bar_drop.run import BarDropRun
from jaxbuffer.mechanisms.tank_drop.tank_run import TankRun


class Pendulum(Part):
    """A design of the user's own."""


# Runs are of their mechanism's class, also after a number was replaced.
assert_type(jb.simulate(jb.table2()), jb.Capture)
assert_type(jb.simulate(jb.replace(jb.table2(), {"buffer.k_A": 800.0}), jb.Scenario(approach_speed=0.1)), jb.Capture)
assert_type(jb.simulate(jb.BarDrop(), duration=0.2, history=True), BarDropRun)
assert_type(jb.simulate(jb.SliderCrank()), jb.Run)
assert_type(jb.simulate(jb.TankDrop()), TankRun)
assert_type(jb.simulate(Pendulum()), jb.Run)
assert_type(jb.simulate(jb.table2()).peak_flank.ndim, int)
jb.simulate(jb.table2()).rebound_height  # type: ignore[attr-defined]
jb.simulate(jb.BarDrop()).stroke  # type: ignore[attr-defined]

# Numbers, texts with units, and lists for a sweep.
jb.Scenario(approach_speed="10 cm/s", misalignment="2 deg")
jb.BarDropScenario(height=[0.1, 0.2])
jb.sweep(jb.table2(), jb.Scenario(approach_speed=np.linspace(0.05, 0.3, 5)))
jb.replace(jb.table2(), {"buffer.k_A": "0.8 kN/m"})
jb.BarDrop(heigth=3)  # type: ignore[call-arg]
jb.Scenario(aproach_speed=0.1)  # type: ignore[call-arg]

# Results in folders.
jb.simulate(jb.table2()).save("run")
jb.save(jb.sweep(jb.table2(), jb.Scenario(approach_speed=[0.1, 0.2])), "sweep", force=True)
assert_type(jb.load("run"), jb.Results)
jb.report("run", "sweep", to="page.html", title="Both").name
jb.save(3.0, "run")  # type: ignore[arg-type]

# Names that are not there.
jb.BarDroop  # type: ignore[attr-defined]
jb.simulte(jb.table2())  # type: ignore[attr-defined]

# A design from a file is of whatever kind the file says.
assert_type(jb.load_design("study.toml")[0].buffer, Any)
jb.simulate("study.toml")  # type: ignore[call-overload]
jb.simulate(jb.table2(), tolerance=1e-9)  # type: ignore[call-overload]
