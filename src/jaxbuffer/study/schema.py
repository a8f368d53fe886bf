"""The JSON Schema of a mechanism's studies, for editors, in draft 7, which taplo and VS Code read (json-schema.org).

It knows names, ranges, choices and units; what must fit together is checked by `jaxbuffer check`.
"""

from ..fields import declared
from ..mechanisms.mechanism import Mechanism
from .config import sections, study_tables
from .tables import Keys, StudyNames, keys_schema
from .values import Schema, toleranced_schema

DIALECT = "http://json-schema.org/draft-07/schema#"


def study_schema(mechanism: Mechanism) -> Schema:
    """Return the schema of a study of the mechanism."""
    names = StudyNames(mechanism.design(), mechanism.scenario())
    parts = {name: _with_tolerances(declared(getattr(names.design, name)), names) for name in sections(mechanism)}
    kind = {"const": mechanism.name, "description": f"the mechanism: {mechanism.view.title}"}
    whole = keys_schema(study_tables(), names)
    whole["properties"]["scenario"] |= _with_tolerances(declared(names.scenario), names)
    about = {"$schema": DIALECT, "title": f"jaxbuffer study, kind = {mechanism.name}"}
    return about | whole | {"properties": {"kind": kind} | parts | whole["properties"]}


def _with_tolerances(keys: Keys, names: StudyNames) -> Schema:
    """Return the schema of a table whose numbers may stand with their tolerances."""
    schema = keys_schema(keys, names)
    for name, known in keys.items():
        # Only numbers can have a tolerance.
        if "unit" in known:
            schema["properties"][name]["anyOf"].append(toleranced_schema(known))
    return schema
