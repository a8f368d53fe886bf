"""A sweep in its Zarr store."""

import dataclasses
from pathlib import Path
from typing import Any

from .._types import Dataset
from ..block_store import TOKEN
from ..errors import InputError
from ..mechanisms.mechanism import Mechanism
from .columns import sanity_checks, empty_columns
from .cut import BlockSweep, RunsSweep
from .result import Sweep
from .store import existing, fill, opened
from .zarr_format import attributes


@dataclasses.dataclass(frozen=True)
class StoredSweep:
    """What a sweep over a scheduler found, in a Zarr store. Print it for how the runs ended.

    - ``store``: the store's folder.
    - ``asked``: what was swept; ``count``: runs of it; ``done``: how many of these are in the store.
    - ``codes``: how many runs ended with each outcome's code.
    - ``verdicts``: how many have each verdict of `jb.trust`, by its index; -1 for none.
    - ``token``: the store's own: where the folder is another sweep's by now, reading raises `InputError`.

    **Example:**

    >>> import tempfile
    >>> over = {"scenario.height": [0.1, 0.194]}
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     found = jb.sweep(jb.BarDrop(), jb.BarDropScenario(), 0.05, over=over, client="local", folder=folder)
    ...     found.outcomes, found.to_xarray().peak_force.units, found.load().shaped("peak_force").shape
    ({'finished': 2}, 'N', (2,))
    """

    store: Path
    asked: BlockSweep
    count: int
    done: int
    codes: dict[int, int]
    verdicts: dict[int, int]
    token: str = ""

    def _check(self) -> None:
        """Raise `InputError` where the folder has become another sweep's since."""
        now = attributes(self.store).get(TOKEN)
        if self.token and now != self.token:
            what = "is gone" if now is None else "has become another sweep's"
            raise InputError(f"{self.store} {what}: this sweep's numbers are no longer there; sweep again")

    @property
    def mechanism(self) -> Mechanism:
        """Return the mechanism of which these are runs."""
        return self.asked.mechanism

    @property
    def outcomes(self) -> dict[str, int]:
        """Return how many runs ended with each outcome, by its name."""
        return {self.mechanism.outcomes(code).name: count for code, count in sorted(self.codes.items())}

    def to_xarray(self) -> Dataset:
        """Return the sweep as labelled arrays that are read when they are used, with units.

        They have a dimension for each field of a grid, else ``run``; `code` is the outcome, -1 where there is none yet.
        """
        self._check()
        return opened(self.store)

    def load(self) -> Sweep:
        """Read the whole sweep into memory, as the same sweep without a scheduler would have returned it."""
        self._check()
        columns, store = empty_columns(self.mechanism, self.count), existing(self.store, self.asked)
        fill(store, self.asked, columns)
        self._check()  # it may have become another one's meanwhile
        if isinstance(self.asked, RunsSweep):
            return Sweep(self.mechanism, columns, *self.asked.swept[:2], identity=store.head.identity)
        template, grid = self.asked.template, self.asked.grid
        return Sweep(self.mechanism, columns, template.design, template.scenario, grid, store.head.identity)

    def __repr__(self) -> str:
        name = self.mechanism.view.run_name
        ended = ", ".join(f"{count} {outcome}" for outcome, count in self.outcomes.items())
        head = f"Sweep of {self.count} {name}s" + ("" if self.done == self.count else f"; {self.done} of them done")
        doubtful = sanity_checks(self.mechanism, self.done, self.verdicts, "see trust in the store")
        where = f"  in {self.store}: to_xarray() reads what is asked for, load() all"
        return "\n".join([f"{head}: {ended}", *doubtful, where])


class StoredInterrupted(KeyboardInterrupt):
    """Ctrl-C during a sweep over a scheduler; ``found`` says where it is stored."""

    def __init__(self, found: StoredSweep) -> None:
        super().__init__(
            f"{found.done} of {found.count} {found.mechanism.view.run_name}s done; they are in {found.store}"
        )
        self.found = found

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle the argument: an exception by itself would pickle its message alone."""
        return type(self), (self.found,)
