"""What a mechanism's designs, scenarios and results are made of, as tables."""

from ..fields import Part, field_text, get, meaning, metadata, paths
from ..tables import table, text
from ..value_text import interval_text
from .mechanism import Mechanism


def described(mechanism: Mechanism) -> str:
    """Return a table of every field with unit, default, allowed range and meaning, and of every quantity with unit and
    meaning."""
    fields = table(
        f'{mechanism.view.title}: kind = "{mechanism.name}"', left=("field", "unit", "default", "allowed", "meaning")
    )
    for prefix, part in (("", mechanism.design()), ("scenario.", mechanism.scenario())):
        for path in paths(part):
            fields.add_row(prefix + path, *_declared(part, path), meaning(part, path))
    quantities = table("Quantities of a run", left=("quantity", "unit", "meaning", "sweep", "tune"))
    for name, quantity in mechanism.quantities.items():
        used = ("yes" if use else "" for use in (quantity.swept, quantity.tuned))
        quantities.add_row(name, quantity.unit, quantity.description, *used)
    return text(fields, quantities)


def _declared(part: Part, path: str) -> tuple[str, str, str]:
    """Return unit, default and allowed range of a field."""
    known, value = metadata(part, path), get(part, path)
    default = "none" if value is None else field_text(value, "")
    if "choices" in known:
        return "", default, ", ".join(known["choices"])
    if "curve" in known:
        return "", default, "points that rise in both numbers"
    if "mesh" in known:
        return "", default, "a mesh file"
    if "limits" in known:
        return known["unit"], default, interval_text(**known["limits"])
    if "least" in known:
        upto = "" if known["most"] is None else f" to {known['most']}"
        return "", default, f"whole numbers from {known['least']}{upto}"
    return "", default, "true, false"
