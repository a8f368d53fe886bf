"""A fit made up in a moment: numbers, intervals and residuals that are known."""

import numpy as np

import jaxbuffer as jb
from jaxbuffer.fitting.fitted import Fitted, FittedNumber, RecordBesideFit


def made_up_fit(
    tests=("a.csv",), converged=True, told=(), inflation=1.0, residual=0.5, clips=False, **others
) -> Fitted:
    """Two numbers; ``told``: what is not told apart; ``inflation`` of the variances; ``residual`` of the column;
    ``clips``: whether a row is clipped."""
    times = np.linspace(0.0, 0.1, 11)
    stroke = np.array([0.01 * np.sin(30.0 * times)])
    # The sixth row, the largest but one, is beyond the sensor's range.
    clipped = np.arange(11)[None] == 5 if clips else np.zeros((1, 11), bool)
    record = RecordBesideFit(("stroke [mm]",), ("stroke",), ("m",), times, stroke, stroke + 1e-5, clipped)
    shift = FittedNumber(0.008, 0.0079, 0.0081, "s")
    return Fitted(
        start=jb.table2(),
        scenario=jb.Scenario(),
        parameters={
            "buffer.k_A": FittedNumber(655.5, 655.4, 655.6, "N/m"),
            "buffer.c_A": FittedNumber(60.0, 55.0, 60.0, "N s/m", "at high bound"),
        },
        nuisance={test: {"time_shift": shift} for test in tests},
        residual={test: {"stroke [mm]": residual} for test in tests},
        noise={test: {"stroke [mm]": 2e-5} for test in tests},
        names=("buffer.k_A", "buffer.c_A", *(f"{test}: time_shift" for test in tests)),
        correlation=np.eye(2 + len(tests)),
        not_told_apart=tuple(told),
        inflation=inflation,
        rows=dict.fromkeys(tests, 11),
        records=dict.fromkeys(tests, record),
        evaluations=12,
        converged=converged,
        **others,
    )
