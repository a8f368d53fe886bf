"""The option that has runs repeated at a tenth of the tolerance."""

from typing import Annotated

import typer

from ..errors import check_choice

Trust = Annotated[
    str, typer.Option(metavar="WHEN", help="Whether to run again at a tenth of the tolerance: on or off.")
]


def asked_for(trust: str) -> bool:
    """Whether it is on."""
    check_choice("trust", trust, ("on", "off"))
    return trust == "on"
