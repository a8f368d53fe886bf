"""The name that a wrong one may mean: by its spelling, by its words, and by what else those are called."""

import difflib
from collections.abc import Callable, Iterable
from typing import Any

CLOSE = 0.6  # how alike two words must be for one to be taken for the other mistyped, 1 is equal
MISSPELT = 0.75  # the same of one word among several
FEW, LISTED = 4, 25  # names that a message suggests, and that it lists
WORD = 0.6  # share of a name's words that another name must have, or mean
SURPLUS = 0.2  # what each further word of that name costs
EVEN = 1e-9
Meaning = Callable[[str], str]

# What people call the same thing, as whole names of a span, a limit or a choice …; mechanisms add their fields'.
NAMES: list[tuple[str, ...]] = [
    ("from", "start", "low", "lower", "min", "minimum", "first", "begin", "at_least", "lo", "gt", "ge"),
    ("to", "stop", "end", "high", "upper", "max", "maximum", "last", "at_most", "until", "hi", "lt", "le"),
    ("count", "num", "n", "number", "points", "steps", "size", "samples", "values"),
    ("scale", "spacing", "distribution", "kind"),
    ("constraints", "limits", "constraint", "bounds"),
    ("variables", "parameters", "design_variables", "unknowns"),
    ("objective", "goal", "cost", "minimize", "minimise", "target"),
    ("require_success", "captured", "success", "succeeded", "capture"),
    ("impacts", "impact_count", "touchdowns", "contacts"),
    ("duration", "end_time", "t_end", "tend", "t_stop", "time", "t_final"),
    ("rtol", "tolerance", "tol", "relative_tolerance"),
    ("optimizer", "optimiser", "algorithm"),
    ("iterations", "max_iterations", "maxiter", "max_iter", "steps"),
    ("solver", "integrator", "stepper"),
    ("tolerance", "slack", "margin"),
    ("uniform", "range", "between", "bounds"),
    ("normal", "gaussian", "gauss"),
    ("worst", "max", "minimax"),
    ("mean", "average", "expected"),
    ("cvar", "risk", "tail"),
    ("latin_hypercube", "lhs", "latin"),
    ("saltelli", "indices"),
    ("smooth", "continuous"),
    ("linear", "lin", "linspace"),
    ("log", "logarithmic", "geom", "geometric", "logspace", "geomspace"),
]
# … and as words within a name.
WORDS: list[tuple[str, ...]] = [
    ("peak", "max", "maximum", "maximal", "largest", "highest", "greatest", "worst"),
    ("speed", "velocity", "v0", "v"),
    ("stiffness", "rigidity", "spring", "stiff"),
    ("damping", "damper", "dampening", "dashpot", "viscosity"),
    ("force", "load", "thrust", "reaction"),
    ("angle", "rotation", "attitude", "tilt", "turning"),
    ("mass", "weight"),
    ("inertia", "moment"),
    ("time", "duration"),
    ("energy", "work"),
    ("radius", "diameter"),
    ("length", "distance", "depth"),
    ("friction", "mu"),
    ("restitution", "e"),
    ("young", "e", "elastic", "modulus"),
    ("poisson", "nu"),
    ("approach", "closing", "impact"),
    ("contact", "impact", "collision"),
    ("settling", "settle", "rest"),
    ("acceleration", "accel", "deceleration"),
    ("lateral", "transverse", "sideways"),
    ("share", "ratio", "fraction", "percentage"),
]


def same_name(*names: str) -> None:
    """Make it known that these whole names mean one thing: the module that declares a field says what else people call
    it."""
    NAMES.append(names)


def same_word(*words: str) -> None:
    """Make it known that these words, within a name, mean one thing."""
    WORDS.append(words)


def suggest(name: Any, known: Iterable[str], meaning: Meaning | None = None) -> str:
    """Return '; did you mean …?' for a name that is mistyped, or called otherwise; '; known: …' where none is like it.

    **Arguments:** ``known``: the names that there are; ``meaning``: says in words what one of them means.
    """
    options = list(known)
    section, _, last = str(name).rpartition(".")
    beside = [option for option in options if option.rpartition(".")[0] == section]
    same = [option for option in beside if _same(last, option.rpartition(".")[2])]
    with_word = list[str]()
    for option in beside:
        # The words of its name, and the first one of what it means: "stiffness along the cylinder" of k_A.
        means = (meaning(option) if meaning else None) or ""
        if last in [*option.rpartition(".")[2].split("_"), *means.split()[:1]]:
            with_word.append(option)
    # Too many to be a suggestion: only those that are nearest are named.
    if len(with_word) > FEW:  # the names that have the word stand before those that only mean it
        words = {option: option.rpartition(".")[2].split("_") for option in with_word}
        with_word = sorted((it for it in with_word if last in words[it]), key=lambda it: len(words[it]))[:FEW]
    elif len(with_word) <= 1:
        near = nearest(name, options)
        with_word = (same or _meant(last, beside, meaning))[:FEW] or ([near] if near else [])
    if with_word:
        return f"; did you mean {' or '.join(with_word)}?"
    return "; known: " + listed(beside or dict.fromkeys(option.split(".")[0] for option in options))


def listed(names: Iterable[str]) -> str:
    """Return names in a row, of many the first and how many more there are."""
    first, rest = list(names)[:LISTED], list(names)[LISTED:]
    return ", ".join(first) + (f" and {len(rest)} more" if rest else "")


def nearest(name: Any, known: Iterable[str]) -> str | None:
    """Return the name most like a mistyped one, if any is: each word of a dotted name must be like its counterpart."""

    def alike(option: str) -> tuple[float, float]:
        words, others = (text.lower().split(".")[::-1] for text in (str(name), option))
        # From the last word backwards: a section may be left out, a name may not.
        least = min(_alike(word, other) for word, other in zip(words, others, strict=False))
        return least, _alike(str(name).lower(), option.lower())

    best = max(known, key=alike, default=None)
    return best if best is not None and alike(best)[0] >= CLOSE else None


def _alike(word: str, other: str) -> float:
    ratio = difflib.SequenceMatcher(None, word, other).ratio()
    return max(ratio, CLOSE) if len(word) > 2 and word in other else ratio  # "speed" for "approach_speed"


def same_as(name: Any, known: Iterable[str]) -> str | None:
    """Return the name under which the same thing is known here, if there is one: "worst" for "max"."""
    return next((option for option in known if isinstance(name, str) and _same(name, option)), None)


def _same(name: str, option: str) -> bool:
    """Return whether both are names of one thing."""
    return any(name.lower() in names and option in names for names in NAMES)


def _meant(name: str, options: Iterable[str], meaning: Meaning | None) -> list[str]:
    """Return the options whose words, or else whose meanings, are the name's; the best first, all that are equally
    good."""
    words, scores = _words(name), dict[str, float]()
    if not words:
        return []
    for option in options:
        own = _words(option.rpartition(".")[2])
        both = own | (_words(meaning(option)) if meaning else set())
        has, means = (sum(any(_kin(it, other) for other in those) for it in words) for those in (own, both))
        if means >= WORD * len(words) and (has or means == len(words)):
            surplus = sum(not any(_kin(it, other) for it in words) for other in own)
            spelt = difflib.SequenceMatcher(None, name.lower(), option.rpartition(".")[2]).ratio()
            scores[option] = (has + means) / len(words) - SURPLUS * surplus + spelt
    best = max(scores.values(), default=0.0)
    return [option for option, score in scores.items() if score >= best - EVEN]


def _words(text: str) -> set[str]:
    """Return the words of a name or a sentence, without those that say nothing."""
    plain = "".join(letter if letter.isalnum() else " " for letter in text)
    return {
        word
        for word in plain.lower().split()
        if word not in ("the", "of", "a", "an", "and", "in", "at", "which", "coefficient")
    }


def _kin(word: str, other: str) -> bool:
    """Return whether two words are one, misspelt or not, or name the same."""
    if word == other or any(word in words and other in words for words in WORDS):
        return True
    return min(len(word), len(other)) > 3 and difflib.SequenceMatcher(None, word, other).ratio() >= MISSPELT
