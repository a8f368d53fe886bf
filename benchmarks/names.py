"""Names on a benchmark's command line."""

from collections.abc import Collection, Iterable

import typer


def chosen(given: Iterable[str] | None, known: Collection[str], what: str) -> list[str]:
    """Return the names that are given, or all that are ``known``; one that is not is an error of ``what`` it names."""
    if given is None:
        return list(known)
    names = list(given)
    if unknown := sorted(set(names) - set(known)):
        raise typer.BadParameter(f"no such {what}: {', '.join(unknown)}; there are {', '.join(known)}")
    return names
