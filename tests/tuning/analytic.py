"""Design problems with known answers: functions of two or more variables stand where a simulation's numbers would."""

import numpy as np

from jaxbuffer import Limits, Objective, Outcome, Problem, Scenario, SecondObjective, Variable, replace, table2
from jaxbuffer.mechanisms.probe_cone import PROBE_CONE
from jaxbuffer.tuning.problem.own_quantities import compose
from jaxbuffer.tuning.search.evaluation import Evaluation
from jaxbuffer.tuning.search.measurement import PEAKS

QUANTITIES = tuple(name for name in PROBE_CONE.tuned if PROBE_CONE.has(name, table2()))

PATHS = ("buffer.k_A", "buffer.c_A", "buffer.k_T", "buffer.c_T")


class Functions:
    """Stands in for an `Evaluator`: ``peaks``, one list of functions a case, become that case's impacts, ``rest`` its
    other quantities by name, ``margin`` its margin; each of x, with its gradient by complex steps. The problem's own
    quantities are made of these."""

    tight = 1e-9

    def __init__(self, problem, peaks, rest=None, margin=None):
        self.problem, self.peaks, self.rest, self.margin = problem, peaks, rest or {}, margin
        self.captures = self.batches = 0
        self.dies_after = None

    def __enter__(self):
        return self

    def __exit__(self, *_):
        pass

    def __call__(self, points, rtol=None, slopes=None):
        if self.dies_after is not None and self.batches >= self.dies_after:
            raise KeyboardInterrupt
        self.batches += 1
        return [self.one(np.asarray(point, float)) for point in points]

    def one(self, scaled):
        x, n = self.problem.values(scaled), len(scaled)
        stretch = np.array([v.slope(value) for v, value in zip(self.problem.variables, x, strict=True)])
        self.captures += len(self.peaks)
        count = len(self.peaks)
        peaks, slots = np.zeros((count, PEAKS)), np.tile(np.arange(PEAKS), (count, 1))
        peaks_slope = np.zeros((count, PEAKS, n))
        rest, rest_slope = np.zeros((count, len(QUANTITIES) - 1)), np.zeros((count, len(QUANTITIES) - 1, n))
        margin, margin_slope = np.ones(count), np.zeros((count, n))
        for k, functions in enumerate(self.peaks):
            values, slopes = zip(*(gradient(f, x) for f in functions), strict=True)
            order = np.argsort(-np.array(values), kind="stable")
            peaks[k, : len(order)], slots[k, : len(order)] = np.array(values)[order], order
            peaks_slope[k, : len(order)] = np.array(slopes)[order] * stretch
            for name, f in self.rest.items():
                q = list(QUANTITIES).index(name) - 1
                rest[k, q], slope = gradient(f, x)
                rest_slope[k, q] = slope * stretch
            if self.margin is not None:
                margin[k], slope = gradient(self.margin, x)
                margin_slope[k] = slope * stretch
        own = compose(self.problem, peaks[:, 0], rest, rest_slope)
        code = np.where(margin >= 0.0, int(Outcome.captured), int(Outcome.timeout))
        return Evaluation(
            scaled=scaled,
            code=code,
            solved=np.ones(count, bool),
            succeeded=margin >= 0.0,
            impacts=np.full(count, 5),
            peaks=peaks,
            slots=slots,
            rest=np.column_stack([rest, own.values]),
            margin=margin,
            first=peaks[:, 0],
            peaks_slope=peaks_slope,
            rest_slope=np.concatenate([rest_slope, own.slopes], axis=1),
            margin_slope=margin_slope,
            by_peak=np.column_stack([np.zeros(rest.shape), own.by_peak]),
        )


def gradient(function, x):
    """Value and gradient by complex steps, exact to rounding."""
    steps = np.eye(len(x)) * 1e-30j
    return float(function(x.astype(complex)).real), np.array([function(x + step).imag / 1e-30 for step in steps])


def problem(low, high, start, cases=1, **fields):
    """Linear variables with these bounds; the first ones in `PATHS`."""
    variables = [Variable(path, a, b, "linear") for path, a, b in zip(PATHS, low, high, strict=False)]
    design = replace(table2(), dict(zip(PATHS, map(float, start), strict=False)))
    scenarios = [Scenario(approach_speed=0.1 + 0.01 * k) for k in range(cases)]
    return Problem(design, scenarios, variables, **fields)


def shifted(functions, shift):
    """Functions of x - shift, so that the variables stay positive as the mechanism's must."""
    return [lambda x, f=f: f(x - shift) for f in functions]


__all__ = ["Functions", "Limits", "Objective", "SecondObjective", "gradient", "problem", "shifted"]
