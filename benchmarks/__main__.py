"""The one command of all benchmarks: ``python -m benchmarks [NAME] [options]``; without a name, `speed`."""

import importlib
import inspect
import sys
from collections.abc import Sequence
from difflib import get_close_matches

import typer

DEFAULT = "speed"
NAMES = {  # modules of this package, each with a `main`, and what they are for
    "speed": "jaxbuffer and its peers at equal accuracy: the headline",
    "docs": "the tables of the latest run of speed, for docs/benchmarks.md",
    "accelerator": "captures and gradients in one jax.vmap, on any device",
    "campaign": "reported maxima of random runs against their histories and tight solves",
    "certificates": "how good gradients are, and how often their certificates are right",
    "diffrax_route": "a capture through diffrax.diffeqsolve beside our own",
    "docking": "runs until the latches hold, and free starts",
    "elements": "finite elements a second beside a loop in numba",
    "equations": "how large the programs of a run and of its derivatives are",
    "evaluation": "one evaluation of the right-hand side, alone and with derivatives",
    "gradients": "time and memory of a design problem's gradient by scenarios",
    "missed_events": "events of motions in closed form: is one missed?",
    "optimisers": "jb.tune and its peers on four design problems",
    "problems": "how far jb.tune ends from the best design known",
    "scaling_model": "how far a sweep over a scheduler scales",
    "space": "a capture in space beside a compiled loop of its own, and beside the plane's",
    "trust": "whether jb.trust tells which numbers are wrong",
    "variables": "what a gradient costs by how many variables",
    "elasticities": "elasticities with any optional parts against differences of tight solves",
    "wide": "random designs far wider than an engineer would search",
    "peers.check": "whether every peer is right",
    "peers.space.check": "whether the peer in space is right",
    "peers.slider_crank.reference": "what tests of the slider-crank compare with",
    "peers.slider_crank.statistics": "many turns of the slider-crank's reference design",
    "fresh": "one measurement in a process of its own, for others",
}
LIST = "NAMES\n\n\b\n" + "\n".join(f"  {name:<30} {what}" for name, what in NAMES.items())


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one benchmark; the exit status."""
    words = list(sys.argv[1:] if arguments is None else arguments)
    name = words.pop(0) if words and not words[0].startswith("-") else DEFAULT
    if name not in NAMES:
        meant = "".join(f"; did you mean {close}?" for close in get_close_matches(name, NAMES, 1))
        print(f"no benchmark is called {name}{meant}\n`python -m benchmarks --help` lists them", file=sys.stderr)
        return 2
    module = importlib.import_module(f"benchmarks.{name}")
    app = typer.Typer(add_completion=False, rich_markup_mode=None, pretty_exceptions_enable=False)
    app.command(help=inspect.cleandoc(module.__doc__ or ""), epilog=LIST if name == DEFAULT else None)(module.main)
    try:
        return app(words, prog_name=f"python -m benchmarks {name}", standalone_mode=False) or 0
    except Exception as error:
        if not hasattr(error, "format_message"):  # what typer's usage errors have in common, in all its versions
            raise
        print(f"{name}: {error.format_message()}", file=sys.stderr)
        return 2


if __name__ == "__main__":
    sys.exit(main())
