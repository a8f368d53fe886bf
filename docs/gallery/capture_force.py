"""# The contact force of one capture

The tip strikes one flank, then the other, until it lies in the throat. The second panel enlarges the largest impact,
which lasts a fraction of a millisecond.
"""

import jaxbuffer as jb
from jaxbuffer.output.figures import run_figure

jb.configure()
capture = jb.simulate(jb.table2(), jb.Scenario(approach_speed=0.1), history=True)
figure = run_figure(capture)
