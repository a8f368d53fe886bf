"""# A response surface, and how far it is off

The stroke from 64 captures spread over stiffness, damping and speed, predicted by a fit without the capture,
over the computed one. A number of captures that are not captured are left out and counted.
"""

import jaxbuffer as jb
from jaxbuffer.output.sample_figures import surfaces_figure

jb.configure()
ranges = {"buffer.k_A": (200, 2000), "buffer.c_A": (2, 40), "scenario.approach_speed": (0.08, 0.3)}  # N/m, N s/m, m/s
sample = jb.sample(jb.table2(), jb.Scenario(), ranges, count=64)
figure = surfaces_figure([jb.response_surface(sample, "stroke")])
