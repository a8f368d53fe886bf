"""# What a softer contact costs in depth

The front of two objectives: each point is a contact of bar and plate, tuned for the least peak force under its own
limit on the penetration.
"""

import jaxbuffer as jb
from jaxbuffer.output.tune_figure import front_figure

jb.configure()
variables = [jb.Variable("impact.stiffness", 1e10, 1e12)]  # N/m^e
bar = jb.replace(jb.BarDrop(), {"impact.damping": 10.0})  # N s/m
problem = jb.Problem(bar, [jb.BarDropScenario(height=0.194)], variables, duration=0.25)  # m, s
front = jb.pareto(problem, ["peak_force", "penetration"], points=7, starts=2, iterations=15)
figure = front_figure(front)
