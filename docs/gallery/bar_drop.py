"""# A bar drops on a plate

A bar on a hinge falls on a plate, as in an experiment with a force sensor under the
plate.
"""

import jaxbuffer as jb
from jaxbuffer.output.figures import run_figure

jb.configure()
drop = jb.simulate(jb.BarDrop(), jb.BarDropScenario(height=0.194), history=True)  # m
figure = run_figure(drop)
