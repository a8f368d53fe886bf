"""# A tuning

Every scenario before and after, the worst one's force over time, the variables within their bounds, what is limited,
and how the search went.
"""

import jaxbuffer as jb
from jaxbuffer.output.tune_figure import tune_figure

jb.configure()
problem = jb.Problem(
    jb.table2(),
    [jb.Scenario(approach_speed=speed) for speed in (0.1, 0.15, 0.2)],  # m/s
    [jb.Variable("buffer.k_A", 100, 2000), jb.Variable("buffer.c_A", 1, 60), jb.Variable("probe.tip_mass", 0.02, 0.2)],
    limits=jb.Limits(at_most={"stroke": 0.025}),  # m
)
tuned = jb.tune(problem, starts=8, iterations=15)
worst = problem.scenarios[-1]
runs = [jb.simulate(design, worst, problem.duration, history=True) for design in (problem.design, tuned.design)]
figure = tune_figure(tuned, runs)
