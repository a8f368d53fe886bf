"""Design and scenario fields as command line options: ``--buffer.k_A 800`` or ``--buffer.k_A=800``."""

from collections.abc import Collection, Mapping, Sequence
from typing import Any

from typer import Context
from typer.core import TyperCommand

from ..errors import InputError, nearest
from . import completion

OTHER_KINDS = "'jaxbuffer fields KIND' says what each means, of any mechanism"
WIDE, INDENT = 100, 12  # characters of a line of help, and before the names in it
FEW = 5  # words of a field that help shows


class Plain(TyperCommand):
    """A command that takes each option once, unless it is repeatable, and no empty words."""

    def parse_args(self, ctx: Context, args: list[str]) -> list[str]:
        """Check the words, then parse them."""
        if not ctx.resilient_parsing:  # of a shell's completion, in which words are still missing
            check_words(args, [name for it in self.params if getattr(it, "multiple", False) for name in it.opts])
        return super().parse_args(ctx, args)


class Command(Plain):
    """A command that sets dotted options aside, as text, in the context's ``obj``; its help ends with their names.

    They are taken out before the parser sees them: to it their values would look like the CONFIG argument.
    """

    def format_epilog(self, ctx: Context, formatter: Any) -> None:
        """Write the fields of the usual mechanism below the help."""
        formatter.write(f"\n{fields_text(completion.names(()))}\n")

    def parse_args(self, ctx: Context, args: list[str]) -> list[str]:
        """Parse what is left without the dotted options."""
        ctx.meta[completion.WORDS] = args
        rest, ctx.obj = split(args, unfinished=ctx.resilient_parsing)
        if ctx.resilient_parsing and completion.joined():
            rest = [*rest, "CONFIG"]  # else the unfinished value would be completed as if it were CONFIG
        try:
            return super().parse_args(ctx, rest)
        except Exception as error:
            option = getattr(error, "option_name", "")
            # By name, since some versions of typer have a copy of click's classes and others import click itself.
            unknown = type(error).__name__ == "NoSuchOption" and not getattr(error, "possibilities", None)
            if not unknown or not (alike := fields_like(option)):
                raise
            raise InputError(f"No such option: {option}; did you mean {' or '.join(alike)}?") from None

    def shell_complete(self, ctx: Context, incomplete: str) -> list[Any]:
        """Offer dotted options beside the others, and what is the value of one."""
        words = ctx.meta.get(completion.WORDS, ())
        own = completion.field_options(words, incomplete) or completion.value(words, incomplete)
        return [*super().shell_complete(ctx, incomplete), *own]


class CommandOfQuantities(Command):
    """A command whose help names quantities too."""

    def format_epilog(self, ctx: Context, formatter: Any) -> None:
        """Write the quantities and the fields of the usual mechanism below the help."""
        formatter.write(f"\n{quantities_text(completion.names(()))}\n")
        super().format_epilog(ctx, formatter)


def fields_text(names: Mapping[str, Any]) -> str:
    """Return the fields of a mechanism, a section a paragraph, with units or words. ``names``: as completion has
    them."""
    sections = dict[str, list[str]]()
    for path, known in names["fields"].items():
        section, _, name = path.rpartition(".")
        words = known["words"] if len(known["words"]) <= FEW else [*known["words"][:FEW], "…"]
        taken = f"[{known['unit']}]" if known["unit"] else f"({', '.join(words) or known['takes']})"
        sections.setdefault(section, []).append(f"{name} {taken}")
    lines = [f"  {section:{INDENT - 2}}{_packed(shown)}" for section, shown in sections.items()]
    return "\n".join(
        ["Fields (each as --section.field VALUE here, or under [section] in CONFIG.toml;", f"{OTHER_KINDS}):", *lines]
    )


def quantities_text(names: Mapping[str, Any]) -> str:
    """Return the quantities of a mechanism with their units: those with derivatives, then the others."""
    known = names["quantities"]
    shown = {
        "whole run": [f"{name} [{it['unit']}]" for name, it in known.items() if it["differentiable"]],
        "no slopes": [f"{name} [{it['unit']}]" for name, it in known.items() if not it["differentiable"]],
        "impact N": [f"{name} [{unit}]" for name, unit in names["impacts"].items()],
    }
    lines = [f"  {title:{INDENT - 2}}{_packed(them)}" for title, them in shown.items() if them]
    return "\n".join([f"Quantities (each as --of QUANTITY; {OTHER_KINDS}):", *lines])


def _packed(names: Sequence[str]) -> str:
    """Return names in lines, none of them broken."""
    lines = [""]
    for name in names:
        if lines[-1] and INDENT + len(lines[-1]) + len(name) + 2 > WIDE:
            lines.append("")
        lines[-1] += f" {name}," if lines[-1] else f"{name},"
    return f"\n{' ' * INDENT}".join(lines).removesuffix(",")


def fields_like(option: str) -> list[str]:
    """Return the dotted options that one without a section may mean: of the fields whose last part it is or is in, or
    of the field nearest to it; a capture's first."""
    # here, because both import JAX, for which neither help nor other refusals of options wait
    from ..fields import addresses
    from ..mechanisms import all_mechanisms

    name = option.lstrip("-").replace("-", "_")
    every = [addresses(mechanism.design(), mechanism.scenario()) for mechanism in all_mechanisms()]
    exact = ([path for path in known if path.rpartition(".")[2] == name] for known in every)
    # One or two letters are part of many fields' names.
    partly = ([path for path in known if name in path.rpartition(".")[2]] for known in every if len(name) > 2)
    near = ([path] for known in every if (path := nearest(name, known)))
    # The closest kind of likeness counts, within it the first mechanism: a capture's.
    matches = next((paths for group in (exact, partly, near) for paths in group if paths), [])
    return [f"--{path}" for path in matches]


def check_words(words: Sequence[str], repeatable: Collection[str]) -> None:
    """Raise `InputError` for an option given twice that is not ``repeatable``, and for an empty word."""
    options = [word.partition("=")[0] for word in words if word.startswith("--")]
    for name in options:
        if name not in repeatable and options.count(name) > 1:
            raise InputError(f"{name} is given twice; keep one")
    # An empty word, such as a shell variable that is not set, is named after the option before it.
    for before, word in zip(["an argument", *words], words, strict=False):
        if not word or (word.startswith("--") and word.endswith("=")):
            name = word.rstrip("=") or (before if before.startswith("--") else "an argument")
            raise InputError(f"{name} is empty; give it a value or leave it out")


def split(arguments: Sequence[str], unfinished: bool = False) -> tuple[list[str], dict[str, str]]:
    """Split ordinary arguments from the dotted options with their values; ``unfinished``: whether a shell completes
    them, so that nothing is an error yet."""
    rest, overrides = list[str](), dict[str, str]()
    words = iter(arguments)
    for word in words:
        name, equals, value = word.partition("=")
        # After this word there are no more options, by convention.
        if word == "--":
            rest += [word, *words]
        elif name.startswith("--") and "." in name:
            path = name.removeprefix("--")
            # A field at the very end lacks its value like one before an option, and is refused in the same words.
            given = value if equals else next(words, "--")
            if unfinished:
                continue
            if given.startswith("--"):
                raise InputError(f"{path} needs a value: --{path} VALUE")
            if path in overrides:
                raise InputError(f"--{path} is given twice, as {overrides[path]} and as {given}; keep one")
            overrides[path] = given
        else:
            rest.append(word)
    return rest, overrides
