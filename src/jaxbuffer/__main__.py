"""`python -m jaxbuffer`: the command line."""

from .cli import main

main()
