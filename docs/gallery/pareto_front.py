"""# What less stroke costs in hinge force

The front of two objectives: each point is a design tuned for the least hinge force under its own limit on the stroke.
"""

import jaxbuffer as jb
from jaxbuffer.output.front_files import front_figure

jb.configure()
variables = [jb.Variable("buffer.k_A", 100, 3000), jb.Variable("buffer.c_A", 1, 60)]  # N/m, N s/m
problem = jb.Problem(jb.table2(), [jb.Scenario(approach_speed=0.15)], variables)
limits = {"stroke": [0.0037, 0.004, 0.0045, 0.005, 0.006, 0.007]}  # m
front = jb.pareto(problem, ["peak_hinge_force", "stroke"], limits=limits, starts=4, iterations=12)
figure = front_figure(front)
