"""What the same command must write with the same bits: everything but how a result came about."""

import json

MADE = "made"  # command line, time and duration: what must differ


def computed_part(file):
    """A file's bytes; of a JSON record those of all but its "made", which must be there and complete."""
    content = file.read_bytes()
    if file.suffix != ".json" or MADE not in (record := json.loads(content)):
        return content
    made = record.pop(MADE)
    assert set(made) == {
        *("command", "study", "settings", "wall_time", "resumed", "finished", "versions", "machine", "units"),
    }
    assert json.dumps({**record, MADE: made}, indent=2, ensure_ascii=False) + "\n" == content.decode(), "made is last"
    return json.dumps(record, indent=2, ensure_ascii=False).encode()
