"""`pareto`: the front of several objectives, each point the best design under limits on the others than the first."""

import contextlib
import dataclasses
import itertools
import json
import re
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Executor
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Float

from ..block_store import short_hash
from ..errors import InputError, check_flag, check_names, check_type, check_whole, suggest
from ..fields import Part
from ..files import user_path, write
from ..programs.identity import user_code
from .problem.objective import Objective
from .problem.problem import Problem
from .problem.settings import settings_of
from .report.front import Front, worst_values
from .report.tuned import Tuned
from .search.store import LOG, PREVIOUS, STATE, Record
from .tune import tune

ROOM = 1e-3  # relative room above the least value of an objective: there its design alone would be allowed
MOST = 400  # points
BEGUN = "front.json"  # says which front a folder's points are of
POINT = re.compile(r"least-\w+|point-\d+(-again)?")  # names of their folders
RESULT = ("design.toml", "design.mat", "tuned.json", "history.csv", "force.json", "tune.txt", "tune.png", "tune.svg")
OF_A_POINT = (LOG, STATE, PREVIOUS, *RESULT)


def pareto(
    problem: Problem,
    objectives: Sequence[str],
    points: int = 9,
    *,
    limits: Mapping[str, Sequence[float]] | None = None,
    folder: str | Path | None = None,
    resume: bool = False,
    workers: int | None = None,
    executor: Executor | None = None,
    report: Callable[[Record], None] | bool | None = None,
    finished: Callable[[int, int], None] | None = None,
    save: bool = True,
    **settings: Any,
) -> Front:
    """Compute the front of several objectives: the least of the first one under ever tighter limits on the others.

    Of each objective the worst value over the load cases counts.

    The ends come first: the least of the first objective, with the others free, and the least of each other one. Limits
    between the least and the largest values there make the rest of the front, the tightest first, each searched from
    the last one's design, and from the next looser one's too where that did not converge. This is the ε-constraint
    method; it also finds what no weighted sum does, parts of the front that bend inwards.

    **Arguments:**

    - ``problem``: its objective is put aside; its limits hold at every point, and its ``then`` decides among equals.
    - ``objectives``: two names of quantities or more, of which the worst case counts.
    - ``points``: how many, both ends included; with more than two objectives, for each limited one.
    - ``limits``: the limits themselves, by objective, in its unit; then ends are not looked for.
    - ``folder``: a folder for each point's run is made in it, and at the end the result is written there, without
      figures (as of `tune`); ``resume``: go on there; ``save``: whether the result is written.
    - ``workers``, ``executor``, ``report``, ``settings``: as for `tune`; ``finished``: called with the points
      done and the points in all.

    **Returns:** a `Front`; points that are infeasible or dominated are in it, and it says which they are.

    **Raises:** `InputError` for objectives that are unknown or fewer than two, and limits that are not theirs.

    **Source:** Haimes, Lasdon and Wismer, IEEE Trans. Syst. Man Cybern. 1(3), 1971; Miettinen, *Nonlinear
    Multiobjective Optimization*, section 3.2.

    **Example:** a stiffer contact has less penetration and a higher peak.

    >>> problem = jb.Problem(
    ...     jb.BarDrop(), [jb.BarDropScenario()], [jb.Variable("impact.stiffness", 1e10, 1e12)], duration=0.25
    ... )
    >>> front = jb.pareto(problem, ["peak_force", "penetration"], points=2, starts=1, iterations=3)
    >>> [bool(best) for best in front.non_dominated]
    [True, True]
    """
    check_front(problem, objectives, points, limits)
    check_flag("save", save)
    names = tuple(objectives)
    place = None if folder is None else user_path(folder)
    identity = _identity(problem, names, points, limits, settings)
    if place is not None:
        _begin(place, identity, resume)
    options = {"workers": workers, "executor": executor, "report": report, **settings}
    search = _Search(problem, names, folder=place, resume=resume, options=options)
    if limits is None:
        front = _between_ends(search, points, finished)
    else:
        # The loosest limits first, as between ends: the search begins with the last row, the tightest.
        rows = np.array(list(itertools.product(*(sorted(limits[name], reverse=True) for name in names[1:]))), float)
        front = search.front(rows, None, problem.design, finished)
    front = dataclasses.replace(front, identity=identity)
    if save and place is not None:
        front.save(place, force=True, figures=False)
    return front


def _identity(
    problem: Problem,
    names: tuple[str, ...],
    points: int,
    limits: Mapping[str, Sequence[float]] | None,
    settings: Mapping[str, Any],
) -> str:
    """Return a hash of all that makes a front the one it is."""
    code = user_code(problem.mechanism, problem.design, *(case.scenario for case in problem.cases))
    given = None if limits is None else {name: [float(x) for x in limits[name]] for name in names[1:]}
    return short_hash({"front": repr((problem.fingerprint(), code, names, points, given, settings_of(settings)))})


def _begin(folder: Path, identity: str, resume: bool) -> None:
    """Say in a folder which front is begun there, without the points of another one unless it is resumed."""
    if not resume:
        for place in folder.glob("*") if folder.is_dir() else ():
            # Only folders that look like a point of a front, and hold a tuning's files, are emptied.
            if POINT.fullmatch(place.name) and any((place / name).exists() for name in (LOG, STATE, PREVIOUS)):
                for name in OF_A_POINT:
                    (place / name).unlink(missing_ok=True)
                with contextlib.suppress(OSError):  # something else is in it
                    place.rmdir()
    folder.mkdir(parents=True, exist_ok=True)
    write(folder / BEGUN, json.dumps({"identity": identity}) + "\n")


def begun_identity(folder: Path) -> str | None:
    """Return which front was begun in a folder; None where there is none."""
    try:
        return str(json.loads((folder / BEGUN).read_text(encoding="utf-8"))["identity"])
    except (OSError, ValueError, KeyError, TypeError):
        return None


def _between_ends(search: "_Search", points: int, finished: Callable[[int, int], None] | None) -> Front:
    """Search for the ends of the front, and for points under limits between them."""
    names = search.names
    free = search.least(names[0], {}, f"least-{names[0]}", search.problem.design)
    ends = [search.least(name, {}, f"least-{name}", free.design) for name in names[1:]]
    values = np.array([worst_values(end, names) for end in (free, *ends)])
    for name, column in zip(names, values.T, strict=True):
        # Limits are positive, so that there is none between values that are not.
        if not np.nanmax(column) > 0.0:
            raise InputError(
                f"pareto: {name} is {np.nanmax(column):g} wherever an objective is least, so that nothing"
                " is traded for it; leave it out of the objectives"
            )
    spread = limits_between(values[:, 1:], points)
    rows = np.array(list(itertools.product(*spread)))
    # The first point is the first objective's own end, with the others free.
    rows[0] = np.inf
    return search.front(rows, free, ends[-1].design, finished)


def limits_between(ends: Float[np.ndarray, "k k-1"], points: int) -> list[np.ndarray]:
    """Return for each objective but the first limits from its largest value over all ends down to its least.

    ``ends``: their values [units of the objectives], of the first objective's end, then of the others' in order.
    """
    # Each objective is least at its own end: the diagonal.
    high, low = np.fmax.reduce(ends), np.diag(ends[1:])
    # A limit is positive: where an objective can be brought to zero, the tightest is a share of its largest value.
    tightest = np.where(low > 0.0, low * (1.0 + ROOM), ROOM * high)
    return [np.linspace(most, least, points) for most, least in zip(high, tightest, strict=True)]


@dataclasses.dataclass
class _Search:
    """Tunings of one problem under limits, each in a folder of its own; ``options``: as of `tune`."""

    problem: Problem
    names: tuple[str, ...]
    folder: Path | None
    resume: bool
    options: dict[str, Any]

    def front(
        self,
        rows: np.ndarray,
        free: Tuned | None,
        start: Part,
        finished: Callable[[int, int], None] | None,
    ) -> Front:
        """Search for a point for each row of limits, the tightest first.

        Its design is within the next, looser limits too, so that these points can only be better; one that did not
        converge is searched for from the next looser one's design too. ``free``: the first point, if it is known;
        ``start``: the design to begin from.
        """
        known = {} if free is None else {0: free}
        for done, number in enumerate(reversed(range(len(rows))), 1):
            if number not in known:
                known[number] = self._under(rows[number], f"point-{number + 1}", start)
                start = known[number].design
            if finished is not None:
                finished(done, len(rows))
        for number in range(1, len(rows)):
            point = known[number]
            if not point.converged:
                other = self._under(rows[number], f"point-{number + 1}-again", known[number - 1].design)
                better = not point.feasible or other.objective[1] < point.objective[1]
                known[number] = other if other.feasible and better else point
        return Front(self.problem, self.names, rows, tuple(known[number] for number in range(len(rows))))

    def _under(self, row: np.ndarray, name: str, start: Part) -> Tuned:
        """Search for the least of the first objective under a row of limits on the others."""
        limits = {key: float(x) for key, x in zip(self.names[1:], row, strict=True) if np.isfinite(x)}
        return self.least(self.names[0], limits, name, start)

    def least(self, objective: str, limits: Mapping[str, float], name: str, start: Part) -> Tuned:
        """Search for the least of an objective under some limits; ``name`` of its folder."""
        own = self.problem.limits
        # The problem's own limits hold at every point, also where the front's limit is looser.
        tighter = {key: min(x, own.at_most.get(key, np.inf)) for key, x in limits.items()}
        constraints = dataclasses.replace(own, at_most={**own.at_most, **tighter})
        problem = dataclasses.replace(
            self.problem, design=start, objective=Objective({objective: 1.0}), limits=constraints
        )
        folder = None if self.folder is None else self.folder / name
        # A point that an interrupted front had not reached has nothing to resume.
        begun = self.resume and folder is not None and (folder / LOG).exists()
        return tune(problem, folder=folder, resume=begun, **self.options)


def two_objectives(problem: Problem) -> str:
    """Return an example of objectives, and which there are, for a message."""
    first = problem.names[0]
    # Two forces would rise and fall together: an example shows what is traded for what.
    second = next((name for name in problem.names if "force" not in name), problem.names[-1])
    return f"{first},{second} say; known: {', '.join(problem.names)}"


def check_front(
    problem: Problem, objectives: Sequence[str], points: int, limits: Mapping[str, Sequence[float]] | None = None
) -> int:
    """Return how many points a front has, without limits of its own.

    **Raises:** `InputError` for objectives, counts and limits that make none.
    """
    example = "Problem(jb.table2(), [Scenario()], [Variable('buffer.k_A', 100.0, 2000.0)])"
    check_type("problem", problem, Problem, example)
    problem.check_tunable()
    names = check_names("objectives", objectives, problem.main_quantity)
    for name in names:
        if name not in problem.names:
            raise InputError(f"objectives: {name} is unknown{suggest(name, problem.names)}")
    if len(names) < 2:
        raise InputError(f"objectives = {names[0]}: a front needs two at least; {two_objectives(problem)}")
    check_whole("points", points, 2)
    total = points ** (len(names) - 1)
    if total > MOST:
        raise InputError(f"points = {points} for each of {len(names) - 1} limited objectives; at most {MOST} in all")
    if limits is not None:
        check_type("limits", limits, Mapping, "limits={'stroke': [0.025, 0.01]}")
        if set(limits) != set(names[1:]):
            raise InputError(f"limits name {', '.join(limits) or 'nothing'}; needed: {', '.join(names[1:])}")
    return int(total)
