"""Which workers of a cluster may compute: those that find the same bits."""

import warnings
from collections import Counter
from collections.abc import Mapping
from typing import Any

from distributed import Client

from ..block_store import differing
from ..errors import InputError
from ..programs.process import HOST, Kind, kind
from ..programs.store import folder
from .connect import SchedulerGone
from .remote import looked_at

LISTED = 5  # workers that a message names
PATIENCE = 20.0  # s until it is said that there is no worker


class Workers:
    """The workers of a cluster, those that differ left out.

    ``kind``: what all that compute agree in: the installation that asks, and the machine of most workers, or the one
    that is given.
    """

    def __init__(self, client: Client, given: Kind | None = None) -> None:
        """Wait for the first workers.

        **Raises:** `InputError` where none of them fits.
        """
        programs = folder()
        self.client, self.cache = client, None if programs is None else str(programs)
        self.differences: dict[str, list[str]] = {}  # what differs, by address
        self.threads = 0  # of all workers
        self._wait()
        answers = self._answers()
        self.kind = dict(given or self._expected(answers))
        self._compare(answers)
        if not self.fit:
            what = "; ".join(
                f"{address} in {', '.join(self.differences[address])}" for address in [*self.differences][:LISTED]
            )
            whose = "this process and its store" if given else "this process"
            raise InputError(f"no worker can be used: all differ from {whose}: {what}")

    @property
    def fit(self) -> list[str]:
        """Return the addresses of those that may compute, of all that were seen."""
        return [address for address, differs in self.differences.items() if not differs]

    @property
    def unfit(self) -> list[str]:
        """Return the addresses of those that may not."""
        return [address for address, differs in self.differences.items() if differs]

    @property
    def allowed(self) -> list[str] | None:
        """Return the addresses to which a task must be confined; None where all workers may have it."""
        return self.fit if self.unfit else None

    def look(self) -> None:
        """Judge those that have come since."""
        self._compare(self._answers())

    def refuse(self, address: str, differs: list[str]) -> None:
        """Give a worker no more tasks."""
        if not self.differences.get(address):
            self.differences[address] = differs
            what = ", ".join(differs)
            warnings.warn(f"worker {address} is left out: it differs in {what}, and so might its bits", stacklevel=2)

    def _wait(self) -> None:
        warned = False
        while True:
            try:
                return self.client.wait_for_workers(1, timeout=PATIENCE)
            except TimeoutError:
                if not warned:
                    warnings.warn("the scheduler has no worker yet; waiting for one", stacklevel=2)
                warned = True
            except OSError:
                raise SchedulerGone from None

    def _answers(self) -> dict[str, Any]:
        """Return what the workers that have come since the last time compute with, by address."""
        try:
            here = self.client.scheduler_info(n_workers=-1)["workers"]
            self.threads = sum(worker["nthreads"] for worker in here.values())
            # Workers that are gone are forgotten: another one that comes by the same address is asked anew.
            self.differences = {address: differs for address, differs in self.differences.items() if address in here}
            new = [address for address in here if address not in self.differences]
            return self.client.run(looked_at, self.cache, workers=new, on_error="return") if new else {}
        except OSError:  # its connection was closed
            raise SchedulerGone from None

    def _expected(self, answers: Mapping[str, Any]) -> dict[str, str]:
        mine = kind()
        # Bits may differ between processors, so that the kind most workers have leaves out the fewest of them.
        machines = Counter(tuple(it[name] for name in HOST) for it in answers.values() if isinstance(it, dict))
        return {**mine, **dict(zip(HOST, machines.most_common(1)[0][0], strict=True))} if machines else mine

    def _compare(self, answers: Mapping[str, Any]) -> None:
        for address, it in answers.items():
            differs = differing(self.kind, it) if isinstance(it, dict) else [f"its answer, {it!r}"]
            if differs:
                self.refuse(address, differs)
            else:
                self.differences[address] = []
