"""What a folder of results holds, read back: `load`."""

import dataclasses
import json
import warnings
from collections.abc import Iterator, Mapping
from pathlib import Path

import numpy as np

from .._types import Dataset
from ..block_store import described_identity, differing
from ..choosing.store import BEGUN as CHOICE_BEGUN
from ..choosing.store import FOLDER as CHOICE
from ..errors import InputError
from ..fields import Part, paths
from ..files import user_path
from ..labelled.netcdf import SUFFIX, read
from ..labelled.record import Record, has_headings, part_from_json
from ..mechanisms import all_mechanisms, mechanism_named
from ..mechanisms.mechanism import Mechanism
from ..mechanisms.registry import mechanism_of
from ..study.load import load as load_study
from ..sweeps.store import STORE, in_words, is_unfinished, opened
from ..sweeps.zarr_format import attributes
from ..tables import summary_html
from ..tuning.pareto import begun_identity
from ..tuning.search.store import stored_identity
from .provenance import MADE

DESIGN = "design.toml"
TABLES = ("sweep.nc", "sample.nc")  # the runs of a sweep and of a sample
RECORDS = {
    **{"tuned": "tuned.json", "sensitivity": "sensitivity.json", "sample": "sample.json"},
    **{"front": "pareto.json", "choice": "choice.json", "fit": "fit.json"},
}
COMMANDS = ("simulate", "sensitivity", "sweep", "tune", "sample", "pareto", "choose", "fit")
MAKE = f"jaxbuffer simulate STUDY.toml --output FOLDER makes some; so do {', '.join(COMMANDS[1:-1])} and {COMMANDS[-1]}"
BEGUN = {  # what a command keeps while it runs, and the files of its results
    "tuning": ("log.jsonl", ("tuned.json",)),
    "sweep or sample": (STORE, ("sweep.nc", "sample.json")),
    "front": ("least-*/log.jsonl", ("pareto.json",)),
    "choice": (f"{CHOICE}/{CHOICE_BEGUN}", ("choice.json",)),
}
# Entries that have other names by now: a page would leave them out and so say less than the result.
RENAMED = ("must_succeed", "asked", "rows_asked", "shown_in", "borne_out", "standing")
ADDED = {"choice.json": "warnings", "fit.json": "explained"}  # entries that the first records of these kinds lacked
BESIDE = {
    "sweep": "sweep.json",
    "motion": "motion.json",
    "force": "force.json",
    "what_if": "what_if.json",
}  # of something else in the folder


@dataclasses.dataclass(frozen=True)
class Results:
    """What a folder of results holds; what it has not is None. Print it to see which.

    - ``folder``: where it is.
    - ``run``: of `jaxbuffer simulate`, as `Run.to_xarray` made it, history included.
    - ``sweep``: of `jaxbuffer sweep`, as `Sweep.to_xarray` made it.
    - ``records``: the JSON files by what they are of: "run", "tuned", "sensitivity", "sweep", "sample", "front",
      "choice", "fit"; "motion" and "force" over time of a run, or "force" of a tuning; "what_if": models around a tuned
      design. A number stands under its name, its unit in ``units``:
      ``found.records["run"]["peak_force"]``, ``found.records["run"].units["peak_force"]``.
    - ``design``: the tuned one, or else that of the run, the sensitivities, the sweep, the sample or the front.

    **Example:**

    >>> import pathlib
    >>> found = jb.Results(pathlib.Path("results"), records={"tuned": {"message": "no reduction is left"}})
    >>> found.run is None, found.tuned["message"]
    (True, 'no reduction is left')
    """

    folder: Path
    run: Dataset | None = None
    sweep: Dataset | None = None
    records: Mapping[str, Record] = dataclasses.field(default_factory=dict)
    design: Part | None = None

    def __post_init__(self) -> None:
        records = {name: Record.of(record) for name, record in self.records.items()}
        object.__setattr__(self, "records", records)  # the class is frozen

    @property
    def tuned(self) -> Record | None:
        """Return the record of tuned.json, which `jaxbuffer tune` writes; None where there is none."""
        return self.records.get("tuned")

    @property
    def sensitivity(self) -> Record | None:
        """Return the record of sensitivity.json, which `jaxbuffer sensitivity` writes; None where there is none."""
        return self.records.get("sensitivity")

    @property
    def mechanism(self) -> Mechanism:
        """Return the mechanism whose results they are."""
        kinds = [record["kind"] for record in self.records.values() if "kind" in record]
        kinds += [data.attrs["kind"] for data in (self.run, self.sweep) if data is not None]
        return mechanism_named(kinds[0]) if kinds else mechanism_of(self.design)

    @property
    def success(self) -> str | None:
        """Return how its runs should end, in a word; None where any end will do."""
        return self.mechanism.success if self.design is None else self.mechanism.success_of(self.design)

    def __repr__(self) -> str:
        return "\n".join(
            [f"Results in {self.folder}:", *(f"  {name:12} {text}" for name, text in self._lines().items())]
        )

    def _repr_html_(self) -> str:
        return summary_html(repr(self))

    def _lines(self) -> dict[str, str]:
        """Return a line for each thing there is."""
        lines = {}
        if self.run is not None:
            steps = f"history of {self.run.sizes['step']} steps" if "step" in self.run.sizes else "no history"
            lines["run"] = f"{self.run.title}: {self.run.outcome}; {self.run.sizes['impact']} impacts listed, {steps}"
        if self.sweep is not None:
            sizes = " × ".join(f"{n} {'runs' if name == 'run' else name}" for name, n in self.sweep.sizes.items())
            lines["sweep"] = f"{self.sweep.title}: {sizes}"
        if self.tuned is not None:
            lines["tuned"] = str(self.tuned.get("message", ""))
        if self.sensitivity is not None:
            pairs = self.sensitivity.get("derivatives", ())
            lines["sensitivity"] = f"{len(pairs)} derivatives"
        if (choice := self.records.get("choice")) is not None:
            lines["choice"] = str(choice.get("message", ""))
        if (fit := self.records.get("fit")) is not None:
            how = "converged" if fit["converged"] else "NOT converged"
            how = how if fit["explained"] else "test NOT explained"
            lines["fit"] = f"{len(fit['parameters'])} numbers from {', '.join(fit['rows'])}, {how}"
        for name, what in (("sample", "runs"), ("front", "points")):
            if (record := self.records.get(name)) is not None:
                count = record[what] if isinstance(record[what], int) else len(record[what])
                lines[name] = f"{count} {what}"
        if self.design is not None:
            lines["design"] = f"{type(self.design).__name__} with {len(list(paths(self.design)))} fields"
        return lines


def load(folder: str | Path) -> Results:
    """Return what a folder holds that `--output` named.

    **Arguments:**

    - ``folder``: a folder of `jaxbuffer simulate`, `sensitivity`, `sweep`, `tune`, `sample`, `pareto`, `choose` or
      `fit`, or of several of them.

    **Returns:** `Results`. A warning says where a sweep, a sample, a tuning or a front was begun beside the results of
    another one, which are what is returned.

    **Raises:** `InputError` for a folder that is not there, holds no results, or has a damaged file, which it names.

    **Example:**

    >>> try:
    ...     jb.load("no-such-folder")
    ... except jb.InputError as error:
    ...     print(error)
    no-such-folder: no such folder
    """
    folder = user_path(folder)
    if not folder.is_dir():
        raise InputError(f"{folder}: no such folder")
    run, sweep, records = _run(folder), _sweep(folder), _records(folder)
    for line in _begun_beside(folder, records):
        warnings.warn(line, stacklevel=2)
    # A tuned design comes before those of other records: it is the result, they may be of the start.
    design = load_study(folder / DESIGN).design if (folder / DESIGN).is_file() else None
    # What only ever stands beside a result, such as the force over time, is none by itself.
    if run is None and sweep is None and design is None and not records.keys() - BESIDE.keys():
        nothing = f"{folder} holds no results of {', '.join(COMMANDS[:-1])} or {COMMANDS[-1]}; {MAKE}"
        raise InputError(unfinished(folder) or nothing)
    for data in (run, sweep):
        if design is None and data is not None and "design" in data.attrs:
            design = _design(folder, data.attrs["kind"], data.attrs["design"])
    for name in ("tuned", "choice", "fit", "run", "sensitivity", "sample", "front"):
        if design is None and "design" in records.get(name, Record()):
            design = _design(folder, records[name]["kind"], json.dumps(records[name]["design"]))
    return Results(folder, run, sweep, records, design)


def load_finished(folder: str | Path) -> Results:
    """Load a folder for a page. **Raises:** `InputError` as `load` does, and where it has an unfinished sweep alone."""
    begun = unfinished(user_path(folder))
    try:
        results = load(folder)
    except InputError as error:
        if begun and STORE in str(error):  # the store cannot be read either: the package that reads it is missing, say
            raise InputError(begun) from None
        raise
    # A page would show a part of a sweep as if it were all of it.
    if begun and results.sweep is not None and not results.records:
        raise InputError(begun)
    return results


def unfinished(folder: Path) -> str:
    """Return what is begun in a folder and not finished, and how it goes on; "" where nothing is."""
    for what, (log, results) in BEGUN.items():
        begun = is_unfinished(folder / STORE) if log == STORE else any(folder.glob(log))
        if begun and not any((folder / name).exists() for name in results):
            return f"{folder} holds an unfinished {what}: the command that began it, with --resume, goes on"
    return ""


def _begun_beside(folder: Path, records: Mapping[str, Record]) -> Iterator[str]:
    """Yield a line where a sweep or sample, a tuning or a front was begun beside the results of another one."""
    own = described_identity(attributes(folder / STORE))
    known = {name: described_identity(read(folder / name).attrs) for name in TABLES if (folder / name).is_file()}
    others = {name: it for name, it in known.items() if it is not None}  # earlier versions wrote none
    if own is not None and others and own not in others.values():
        unfinished = is_unfinished(folder / STORE)
        name, other = next(iter(others.items()))
        state = "is not finished" if unfinished else "has all its runs"
        goes_on = "goes on" if unfinished else "writes its results"
        yield (
            f"{folder} holds two sweeps, differing in {in_words(differing(own, other))}: {name} is of one, {STORE} of"
            f" the other, which {state}: the command that began it, with --resume, {goes_on}"
        )
    for what, name, begun in (("tuning", "tuned", stored_identity), ("front", "front", begun_identity)):
        # Without both identities nothing tells whether the two belong together.
        finished, now = records.get(name, Record()).get("identity"), begun(folder)
        if finished and now and finished != now:
            yield (
                f"{folder} holds two {what}s: {RECORDS[name]} is of one, and another was begun there and has no results"
                " yet: the command that began it, with --resume, goes on"
            )


def _records(folder: Path) -> dict[str, Record]:
    """Return every JSON record there is; a run's is named after what its mechanism calls it."""
    records = {name: _record(folder / file) for name, file in {**RECORDS, **BESIDE}.items()}
    for mechanism in all_mechanisms():
        run = _record(folder / f"{mechanism.view.run_name}.json")
        # Several mechanisms may call their runs by the same word.
        if run is not None and run.get("kind") == mechanism.name:
            records["run"] = run
    # What is not there is left out, so that `in` tells what a folder holds.
    return {name: record for name, record in records.items() if record is not None}


def _run(folder: Path) -> Dataset | None:
    """Return the run in a folder, named after what its mechanism calls it."""
    names = [f"{mechanism.view.run_name}{SUFFIX}" for mechanism in all_mechanisms()]
    # Mechanisms may share a name for their runs: each file counts once.
    files = [folder / name for name in dict.fromkeys(names) if (folder / name).is_file()]
    if len(files) > 1:
        raise InputError(f"{folder} holds several runs, {', '.join(it.name for it in files)}; keep one in a folder")
    return _dataset(files[0]) if files else None


def _sweep(folder: Path) -> Dataset | None:
    if (folder / "sweep.nc").is_file():
        return _dataset(folder / "sweep.nc")
    if (folder / STORE).is_dir() and not (folder / RECORDS["sample"]).is_file():  # a sample's runs are in its table
        return opened(folder / STORE)
    if (folder / "sweep.npz").is_file():
        raise InputError(f"{folder / 'sweep.npz'} was written by {_writer(folder / 'sweep.npz')}; sweep again")
    return None


def _dataset(file: Path) -> Dataset:
    data = read(file)
    if "kind" not in data.attrs or "outcome" not in {**data, **data.attrs}:
        raise InputError(f"{file} is damaged or no result of jaxbuffer: it names no mechanism and no outcome")
    return data


def _writer(arrays: Path) -> str:
    """Return which version wrote the arrays of a sweep, which this one does not read."""
    try:
        # A pickle could run any code, and folders come from others (docs/security.md).
        with np.load(arrays, allow_pickle=False) as stored:
            return f"jaxbuffer {json.loads(str(stored['sweep']))['jaxbuffer']}, an earlier state of it"
    except Exception:  # zip files and arrays fail in many ways; all mean the same
        return "an earlier version, or is damaged"


def _record(file: Path) -> Record | None:
    if not file.is_file():
        return None
    try:
        text = file.read_text(encoding="utf-8")
        record = Record.from_json(text)
    except ValueError as error:  # no JSON, or no UTF-8
        raise InputError(f"{file} is damaged: {error}") from None
    if not isinstance(record, Record):
        raise InputError(f"{file} is damaged: it holds no record")
    lacks = file.name in ADDED and ADDED[file.name] not in record
    with_units = any(map(has_headings, (record, record.get("design", {}), record.get(MADE, {}))))
    if lacks or with_units or any(f'"{name}"' in text for name in RENAMED):
        raise InputError(f"{file} was written by an earlier version of jaxbuffer; run its command again")
    return record


def _design(folder: Path, kind: str, design: str) -> Part:
    try:
        return part_from_json(mechanism_named(kind).design(), design)
    except (KeyError, ValueError, AttributeError) as error:
        raise InputError(f"{folder}: the design of its results is damaged or of another release: {error}") from None
