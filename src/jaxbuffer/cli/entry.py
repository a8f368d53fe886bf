"""From arguments to an exit code: no error leaves as a traceback unless it is a bug."""

import functools
import os
import sys
import traceback
from collections.abc import Sequence
from typing import Any

import typer
from typer.main import get_command

from ..errors import InputError
from ..files import Lock
from . import streams
from .app import app
from .exits import BAD_INPUT, FAILED, INTERRUPTED, OK, fail
from .quick import prepare
from .signals import ENDING


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the command line and exit with its code."""
    prepare()
    streams.prepare()
    try:
        code = run(sys.argv[1:] if arguments is None else arguments)
    except Exception:  # a bug: Python's own exit code would say that limits are broken
        traceback.print_exc()
        code = FAILED
    # After a signal a failure has the signal's exit code; a command that was done all the same keeps its 0.
    if code == INTERRUPTED or (code and ENDING.first is not None):
        ENDING.leave()
    # Flushed here, where a failure can still become an exit code.
    try:
        sys.stdout.flush()
    except OSError:
        os._exit(code or FAILED)  # Python would try again and complain
    sys.exit(code)


def run(arguments: Sequence[str]) -> int:
    """Run the command line; errors become one line on stderr and an exit code."""
    try:
        # Outside its standalone mode typer raises what it would print over several lines before it ends the process.
        code = _commands()(list(arguments), prog_name="jaxbuffer", standalone_mode=False, obj=tuple(arguments))
    except InputError as error:
        return fail(error, BAD_INPUT)
    except OSError as error:
        return fail(f"{error.filename}: {error.strerror}" if error.filename else error)
    except SystemExit as ended:  # Click's own: of a shell's completion, and for a pipe that nobody reads any more
        return FAILED if ended.code else OK
    except (KeyboardInterrupt, typer.Abort):
        code = INTERRUPTED
    except Exception as error:
        if isinstance(error, ValueError) and "jax" not in sys.modules:  # JAX reads its switches as it is imported
            return fail(f"JAX cannot be imported with the switches in this environment: {error}", BAD_INPUT)
        if not hasattr(error, "format_message"):  # what typer's usage errors have in common, in all its versions
            raise
        message = error.format_message()
        quotes = '; a value with its unit needs quotes: "-4 deg"' if "unexpected extra argument" in message else ""
        none = "; 'jaxbuffer COMMAND --help' says what it needs" if "Missing argument" in message else ""
        return fail(f"{message.rstrip('.')}{quotes}{none}", BAD_INPUT)
    finally:
        # Also after an error: a folder that was made for results which never came is removed with its lock.
        Lock.release_all()
    if code == INTERRUPTED:
        print("interrupted", file=sys.stderr, flush=True)
    return code or OK


@functools.cache
def _commands() -> Any:
    """Return all commands with their options, which typer would otherwise build anew in each call."""
    return get_command(app)
