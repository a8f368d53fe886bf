"""``python -m optimise [STUDY …]``: run all studies, or those named; results and figures below ``--output``."""

import argparse
import importlib
import os
import sys
from pathlib import Path

STUDIES = (
    "speeds",
    "misalignment",
    "pareto",
    "tip",
    "robust",
    "bending",
    "bar",
    "slider_crank",
    "tank",
    "full_tank",
    "card",
    "initial_conditions",
)


def main(arguments: list[str] | None = None) -> int:
    """Run the studies one after the other."""
    parser = argparse.ArgumentParser(prog="python -m optimise", description="Studies of the buffer.")
    parser.add_argument("studies", nargs="*", choices=[*STUDIES, []], metavar="STUDY", help=", ".join(STUDIES))
    parser.add_argument("--output", type=Path, default=Path("results/studies"), metavar="FOLDER")
    parser.add_argument("--resume", action="store_true", help="go on with runs that were interrupted")
    parser.add_argument("--scheduler", metavar="WHERE", help="over Dask, as for jaxbuffer tune (docs/clusters.md)")
    options = parser.parse_args(arguments)
    import jaxbuffer
    from jaxbuffer.cluster.extra import executor_at

    jaxbuffer.configure(cache=os.environ.get("JAXBUFFER_CACHE") or Path.home() / ".cache" / "jaxbuffer")
    try:
        with executor_at(options.scheduler) as (executor, _):
            for name in options.studies or STUDIES:
                print(f"--- {name}", file=sys.stderr, flush=True)
                importlib.import_module(f"optimise.{name}").main(options.output / name, options.resume, executor)
    except jaxbuffer.InputError as error:
        parser.error(str(error))
    return 0


if __name__ == "__main__":
    sys.exit(main())
