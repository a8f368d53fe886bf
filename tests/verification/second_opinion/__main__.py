"""``PYTHONPATH=src:tests python -m verification.second_opinion``: Exudyn's opinion on whole captures, as a table.

A minute or so a capture; ``--steps`` chooses Exudyn's, ``--cases`` the captures.
"""

import argparse
import time

import jaxbuffer.programs.process

jaxbuffer.programs.process.configure(cache=None)

from verification.second_opinion.compare import DOCKED, NAMES, STEPS, ask, table  # noqa: E402


def main() -> None:
    parser = argparse.ArgumentParser(description="jaxbuffer against Exudyn; deviations are Exudyn/jaxbuffer - 1")
    parser.add_argument("--steps", type=float, nargs="+", default=STEPS, metavar="S", help="Exudyn's steps [s]")
    parser.add_argument("--cases", nargs="+", default=(*NAMES, *DOCKED), metavar="NAME", help="reference runs")
    given = parser.parse_args()
    for name in given.cases:
        start = time.perf_counter()
        print(table(ask(name, tuple(given.steps))), flush=True)
        print(f"  {time.perf_counter() - start:.0f} s", flush=True)


main()
