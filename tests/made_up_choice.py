"""Choices made up in a moment: forces, strokes, prices and corners that are known."""

import dataclasses

from jaxbuffer import Limits, Problem, Scenario, replace, table2
from jaxbuffer.choosing.alternatives import _alternative
from jaxbuffer.choosing.bound import ContinuousOptimum
from jaxbuffer.choosing.choice import Choice
from jaxbuffer.choosing.choose import selection
from jaxbuffer.choosing.enumeration import RunTally
from jaxbuffer.tuning.problem.variable import Variable
from made_up import made_up_evaluation, made_up_tuning

PARTS = {
    "spring": {"S2": {"k_A": "0.2 kN/m", "price": "9 EUR"}, "S5": {"k_A": "0.45 kN/m", "price": "12 EUR"}},
    "tip": {"light": {"tip_mass": "25 g", "price": "8 EUR"}, "heavy": {"tip_mass": "70 g", "price": "5 EUR"}},
}
SPEEDS = (0.06, 0.14)  # m/s
TOLERANCES = {"buffer.c_A": "20 %", "probe.tip_radius": "0.5 mm"}
TALLY = RunTally(
    combinations=4, priced_out=1, unfit=0, failed=0, infeasible=1, beaten=0, complete=2, runs=30, possible=40
)


def made_up_choice(
    stroke=0.025, tolerances=TOLERANCES, broken_corners=0, optimum=180.0, design=None, then=None
) -> Choice:
    """Two ranked combinations of four: forces of 250 N, 300 N, … times 0.8 and 0.9, and strokes of 10 mm.

    **Arguments:** ``stroke``: its limit [m]; ``broken_corners``: how many of the corners have a stroke of 30 mm;
    ``optimum``: the continuous one's objective [N], None for none; ``then``: a second objective.
    """
    design = table2() if design is None else design
    scenarios = [Scenario(approach_speed=speed) for speed in SPEEDS]
    problem = Problem(design, scenarios, [], limits=Limits(at_most={"stroke": stroke}), tolerances=tolerances)
    criterion, combinations = selection(problem, PARTS, at_most={"price": 18.0}, then=then)
    ranked = []
    for share, number in ((0.8, 0), (0.9, 1)):
        own = dataclasses.replace(criterion.problem, design=combinations.built(number))
        point = made_up_evaluation(own, own.start(), share)
        rest = point.rest.copy()
        rest[list(own.corner_places[:broken_corners]), own.names.index("stroke") - 1] = 0.030
        point = point._replace(rest=rest)
        ranked.append(_alternative(criterion, own, combinations.parts(number), point, point))
    bound = None
    if optimum is not None:
        variables = [Variable("buffer.k_A", 200.0, 450.0)]
        tuned = made_up_tuning(Problem(replace(design, {"buffer.k_A": 300.0}), scenarios, variables))
        bound = ContinuousOptimum(dataclasses.replace(tuned, confirmed=False), optimum)
    second = {} if then is None else {"least": ranked[0], "ceiling": then.ceiling(ranked[0].value)}
    return Choice(criterion, combinations.catalogues, tuple(ranked), TALLY, bound, **second)


def largest_force(choice) -> float:
    """The objective of the first combination [N], by hand: the last of its scenarios and corners."""
    return 0.8 * (250.0 + 50.0 * (len(choice.problem.cases) - 1))


def without_combination(choice) -> Choice:
    """The same where no combination could be run."""
    tally = TALLY._replace(priced_out=4, infeasible=0, complete=0, runs=0)
    return dataclasses.replace(choice, ranked=(), optimum=None, tally=tally)
