"""The smooth contact law converges to the exact model as its memory time goes to zero, and its defaults are close.

Measured on Table 2 at rtol 1e-9 (peak force against the reference): 2e-4 s -6.5e-6, 1e-4 s -3.6e-6, 1e-5 s -2.9e-8.
Touchdown events reach -2e-7 with a fifth of the steps, hence they are the default.
"""

import pytest

import jaxbuffer as jb

PEAK, END = 253.13152694328107, 0.7193424826485937


def error(memory_time=None, onset_length=None, rtol=1e-9):
    given = {"contact.memory": "smooth", "contact.memory_time": memory_time, "contact.onset_length": onset_length}
    design = jb.replace(jb.table2(), {path: value for path, value in given.items() if value is not None})
    capture = jb.simulate(design, rtol=rtol)
    return abs(float(capture.peak_force) / PEAK - 1), abs(float(capture.end_time) / END - 1)


def test_the_defaults_are_within_the_products_tolerance():
    peak, end = error(rtol=1e-7)
    assert peak < 1e-5 and end < 1e-5


@pytest.mark.slow
def test_error_falls_with_the_memory_time_and_the_onset_length():
    by_time = [error(t, 1e-9)[0] for t in (4e-4, 1e-4, 1e-5)]
    assert by_time[0] > 2.5 * by_time[1] > 5 * by_time[2]
    assert by_time[2] < 1e-7
    by_length = [error(2e-5, length)[0] for length in (1e-6, 1e-7)]
    assert by_length[0] > 5 * by_length[1]
