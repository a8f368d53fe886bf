"""Where a page's numbers come from: commands, studies, versions, machines, numerical errors, verification."""

from collections.abc import Mapping, Sequence

from ..labelled.record import Record, headings
from ..output.folder import BESIDE, RECORDS, Results
from ..output.provenance import MADE
from ..value_text import table_text
from .page import Cell, PageSection, Table
from .records import words
from .verification import lines, verified

TITLE = "Where the numbers come from"
UNRECORDED = "not recorded"
FILES = {**RECORDS, **BESIDE}
MINUTE = 120.0  # s from which a time is told in minutes


def origin(every: Sequence[Results]) -> PageSection:
    """Return how each result came about, and how exact the runs were."""
    records = [  # every record that says which version made it
        (str(results.folder / (f"{results.mechanism.view.run_name}.json" if name == "run" else FILES[name])), record)
        for results in every
        for name, record in results.records.items()
        if "jaxbuffer" in record or MADE in record
    ]
    typed: list[list[str | Cell]] = [[name, Cell(_made(it).get("command", UNRECORDED), "code")] for name, it in records]
    commands = Table("Commands, as typed", ("result", "command"), typed)
    tables = [commands, _settings(records), _computers(records)]
    balances = [(name, record["numerical_balance"]) for name, record in records if "numerical_balance" in record]
    if balances:
        conserved = list(balances[0][1])
        shown = headings({words(name): balances[0][1].units.get(name, "") for name in conserved})
        errors = [
            [result, *("–" if balance.get(name) is None else f"{balance[name]:.1e}" for name in conserved)]
            for result, balance in balances
        ]
        tables.append(Table("Numerical errors of what is conserved", ("result", *shown), errors))
    missing = [name for name, record in records if not record.get(MADE)]
    warnings = differing(records)
    if missing:
        warnings.append(f"Nothing is recorded of how these came about: {', '.join(missing)}.")
    # The text of each study stands there once, with the results it belongs to.
    studies: dict[str, list[str]] = {}
    for name, record in records:
        if text := _made(record).get("study"):
            studies.setdefault(text, []).append(name)
    listings = {f"The study of {', '.join(names)}": text for text, names in studies.items()}
    return PageSection(TITLE, tables=tables, warnings=warnings, listings=listings)


def verification() -> PageSection:
    """Return what is known of the program's own correctness."""
    counted = verified()
    text = lines(counted)
    return PageSection("Verification", [] if counted is None else text, warnings=text if counted is None else [])


def differing(records: Sequence[tuple[str, Record]]) -> list[str]:
    """Return a warning for each program of which not all results were made by the same version."""
    makers: dict[str, dict[str, list[str]]] = {}
    for name, record in records:
        # Records without `made` name the version of jaxbuffer alone.
        versions = {"jaxbuffer": record.get("jaxbuffer", UNRECORDED), **record.get(MADE, {}).get("versions", {})}
        for program, version in versions.items():
            makers.setdefault(program, {}).setdefault(version, []).append(name)
    versions_of = lambda of: "; ".join(f"{version} ({', '.join(names)})" for version, names in of.items())  # noqa: E731
    return [
        f"Made by different versions of {program}: {versions_of(of)}." for program, of in makers.items() if len(of) > 1
    ]


def _settings(records: Sequence[tuple[str, Record]]) -> Table:
    given = [_made(record).get("settings", Record({})) for _, record in records]
    units = {name: settings.units.get(name, "") for settings in given for name in settings}
    rows: list[list[str | Cell]] = []
    for (result, record), settings in zip(records, given, strict=True):
        made = _made(record)
        time = _time(made["wall_time"]) if "wall_time" in made else UNRECORDED
        time += ", the rest of a run that was interrupted" if made.get("resumed") else ""
        # Without the offset, as the heading says that times are in UTC.
        finished = made.get("finished", UNRECORDED).partition("+")[0].replace("T", " ")
        rows.append([result, finished, time, *(table_text(settings.get(name)) for name in units)])
    return Table("When, how long, how exactly", ("result", "finished (UTC)", "wall time", *headings(units)), rows)


def _time(seconds: float) -> str:
    return f"{seconds:.1f} s" if seconds < MINUTE else f"{seconds / 60.0:.1f} min"


def _computers(records: Sequence[tuple[str, Record]]) -> Table:
    """Return each set of versions on each machine once, with the results it has made."""
    computers: dict[tuple[str, ...], list[str]] = {}
    for name, record in records:
        made = _made(record)
        versions, machine = made.get("versions", {}), made.get("machine", {})
        computer = (
            versions.get("jaxbuffer", record.get("jaxbuffer", UNRECORDED)),
            *(versions.get(program, UNRECORDED) for program in ("Python", "JAX")),
            machine.get("processor", UNRECORDED),
            table_text(machine.get("cores")),
            machine.get("system", UNRECORDED),
        )
        computers.setdefault(computer, []).append(name)
    rows = [[", ".join(names), *computer] for computer, names in computers.items()]
    headings = ("results", "jaxbuffer", "Python", "JAX", "processor", "cores", "system")
    return Table("Versions and machines", headings, rows)


def _made(record: Record) -> Mapping:
    return record.get(MADE) or {}
