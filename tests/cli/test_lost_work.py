"""What was computed is saved before anything is printed, and neither a pipe, an encoding nor a disk takes it away."""

import functools
import io
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import warnings
from pathlib import Path

import numpy as np
import pytest
from determinism import computed_part

import jaxbuffer
import jaxbuffer as jb
from computed import stand_in
from in_short import quick
from jaxbuffer.cli import streams
from jaxbuffer.cli.entry import run
from jaxbuffer.cli.signals import Ending
from test_files import room_for

FILES = {
    "simulate": {
        "capture.json",
        "history.csv",
        "capture.png",
        "motion.png",
        "motion.json",
        "capture.txt",
        "capture.nc",
        "capture.mat",
        "force.json",
    },
    "sensitivity": {
        *("sensitivity.json", "sensitivity.csv", "sensitivity.txt", "sensitivity.png"),
    },
    "tune": {"design.toml", "design.mat", "tuned.json", "history.csv", "force.json", "tune.png", "tune.txt"},
    "sweep": {
        *("sweep.csv", "sweep.txt", "sweep.png", "sweep.nc", "sweep.json"),
        "envelope.png",
    },
}
FAILURES = [OSError(28, "No space left on device"), UnicodeEncodeError("ascii", "×", 0, 1, "ordinal not in range")]
SPEEDS = ["--over", "scenario.approach_speed=0.1:0.3:5"]


@pytest.mark.parametrize("command", FILES)
@pytest.mark.parametrize(
    "error",
    [
        OSError(28, "No space left on device"),
        pytest.param(UnicodeEncodeError("ascii", "×", 0, 1, "no"), marks=pytest.mark.slow),
    ],
)
def test_results_are_there_when_printing_fails(computed, no_figures, monkeypatch, tmp_path, capsys, command, error):
    class Full(io.StringIO):
        def write(self, text):
            raise error

    monkeypatch.setattr(sys, "stdout", Full())
    try:
        code = run([command, "--output", "out"])
    except UnicodeEncodeError:
        code = None  # the streams of a real process print what they can, see below
    assert {file.name for file in (tmp_path / "out").iterdir()} == FILES[command]
    if isinstance(error, OSError):
        last = capsys.readouterr().err.splitlines()[-1]
        assert (code, last) == (3, "error: standard output: No space left on device")


@pytest.mark.parametrize("encoding", ["latin-1", "ascii", "cp1252", "utf-8"])
@pytest.mark.parametrize("command", FILES)
def test_every_encoding_prints_what_it_can(computed, monkeypatch, command, encoding):
    out, err = io.BytesIO(), io.BytesIO()
    monkeypatch.setattr(sys, "stdout", io.TextIOWrapper(out, encoding=encoding))
    monkeypatch.setattr(sys, "stderr", io.TextIOWrapper(err, encoding=encoding))
    monkeypatch.setattr(warnings, "showwarning", warnings.showwarning)
    streams.prepare()
    assert run([command, *(SPEEDS if command == "sweep" else ())]) == 0
    shown = out.getvalue().decode(encoding)
    assert len(shown.splitlines()) > 5
    if command == "sweep":
        line = "─" if encoding == "utf-8" else "-"
        assert "scenario.approach_speed" in shown and 20 * line in shown and "?" not in shown


@pytest.mark.parametrize(
    "names", [pytest.param(["history.csv"], marks=pytest.mark.slow), ["history.csv", "capture.png"]]
)
def test_a_full_disk_is_named_and_the_other_files_are_whole(computed, capsys, tmp_path, names):
    assert run(["simulate", "--output", "whole"]) == 0
    sizes = {name: (tmp_path / "whole" / name).stat().st_size for name in FILES["simulate"]}
    least = min(sizes[name] for name in names)
    rest = {name for name in sizes if sizes[name] < least}
    assert len(rest) == len(sizes) - len([size for size in sizes.values() if size >= least]) and rest, sizes
    capsys.readouterr()
    with room_for(least - 1):
        assert run(["simulate", "--output", "out"]) == 3
    shown = capsys.readouterr()
    assert "peak contact force   250 N" in shown.out, "what was found is shown all the same"
    assert shown.err.splitlines()[-1].startswith("error: out/") and shown.err.endswith("File too large\n")
    assert {file.name for file in (tmp_path / "out").iterdir()} == rest
    for name in rest - {"capture.json"}:
        assert (tmp_path / "out" / name).stat().st_size == sizes[name]
    whole, found = (computed_part(tmp_path / folder / "capture.json") for folder in ("whole", "out"))
    assert found == whole


@pytest.mark.usefixtures("no_figures")
def test_a_file_that_appears_meanwhile_is_left_and_the_result_put_beside_it(computed, monkeypatch, capsys, tmp_path):
    compute = computed.simulate

    def another_comes(*arguments, **options):
        (tmp_path / "out").mkdir(exist_ok=True)
        (tmp_path / "out" / "capture.json").write_text("theirs")
        return compute(*arguments, **options)

    monkeypatch.setattr("jaxbuffer.cli.commands.simulate.compute", another_comes)
    assert run(["simulate", "--output", "out"]) == 0
    shown = capsys.readouterr()
    assert "capture.json appeared meanwhile and is left as it is; the result is in out/capture-1.json" in shown.err
    assert "wrote out/capture-1.json" in shown.out
    assert (tmp_path / "out" / "capture.json").read_text() == "theirs"
    assert '"outcome": "captured"' in (tmp_path / "out" / "capture-1.json").read_text()


@pytest.mark.parametrize(
    ("command", "file"),
    [("tune", "log.jsonl"), pytest.param("tune", "state.npz", marks=pytest.mark.slow), ("sweep", "sweep.zarr")],
)
def test_an_earlier_run_is_resumed_or_overwritten_on_purpose(computed, no_figures, capsys, tmp_path, command, file):
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / file).write_text("theirs")
    assert run([command, "--output", "out"]) == 2
    assert f"out/{file} exists; --resume goes on, --force overwrites" in capsys.readouterr().err
    assert (tmp_path / "out" / file).read_text() == "theirs"
    assert run([command, "--output", "out", "--resume"]) == 0
    assert computed.asked(command)["resume"] and "overwritten" not in capsys.readouterr().err
    assert run([command, "--output", "out", "--force"]) == 0
    assert f"note: --force: an earlier run is overwritten, out/{file}\n" in capsys.readouterr().err
    assert not computed.asked(command)["resume"]


@pytest.mark.parametrize("command", ["tune", "sweep"])
def test_resuming_needs_a_folder(computed, capsys, command):
    assert run([command, "--resume"]) == 2
    assert "--resume needs --output DIR" in capsys.readouterr().err


def test_an_interrupted_sweep_says_how_to_go_on(computed, no_figures, capsys):
    computed.interrupt_after = 3
    assert run(["sweep", *SPEEDS, "--output", "out"]) == 130
    assert "3 of 5 captures are kept; the same command with --resume goes on in out" in capsys.readouterr().err


DAMAGES = {
    "empty": lambda content: b"",
    "cut": lambda content: content[: len(content) // 2],
    "garbled": lambda content: np.random.default_rng(3).bytes(len(content)),
    "flipped": lambda content: content[:500] + bytes([content[500] ^ 128]) + content[501:],
}


@functools.cache
def results(command):
    """The folder of a command's results, made once for all kinds of damage."""
    folder = tempfile.TemporaryDirectory(prefix="results-")
    with pytest.MonkeyPatch.context() as patched:
        stand_in(patched)
        assert run([command, "--output", folder.name, "--force", "--format", "none"]) == 0
    return folder


@pytest.mark.parametrize("damage", quick(DAMAGES, "empty", "garbled"))
@pytest.mark.parametrize(
    ("command", "name"), [("sweep", "sweep.nc"), ("simulate", "capture.json"), ("tune", "tuned.json")]
)
def test_a_report_of_a_damaged_folder_is_one_line(computed, capsys, tmp_path, command, name, damage):
    shutil.copytree(results(command).name, tmp_path / "out")
    file = tmp_path / "out" / name
    capsys.readouterr()
    file.write_bytes(DAMAGES[damage](file.read_bytes()))
    code = run(["report", "out"])
    shown = capsys.readouterr()
    assert code == 2 and shown.err.startswith(f"error: out/{name} is ") and shown.err.count("\n") == 1


def test_the_same_sweep_makes_the_same_bytes(computed, no_figures, tmp_path):
    assert run(["sweep", *SPEEDS, "--output", "one"]) == 0 and run(["sweep", *SPEEDS, "--output", "two"]) == 0
    for name in ("sweep.csv", "sweep.txt", "sweep.json"):
        assert computed_part(tmp_path / "one" / name) == computed_part(tmp_path / "two" / name)
    one, two = (jb.load(tmp_path / name).sweep for name in ("one", "two"))
    assert one.identical(two) and one.sizes == {"scenario.approach_speed": 5}


@pytest.fixture
def ending():
    """A fresh one that listens, and the handlers of before afterwards."""
    numbers = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
    before = {number: signal.getsignal(number) for number in numbers}
    yield Ending()
    for number, handler in before.items():
        signal.signal(number, handler)


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_signals_interrupt_once(ending, monkeypatch, number):
    left = []
    monkeypatch.setattr(os, "_exit", left.append)
    for each in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):  # whatever the caller of this process ignores
        signal.signal(each, signal.default_int_handler)
    ending.listen()
    with pytest.raises(KeyboardInterrupt):
        signal.raise_signal(number)
    signal.raise_signal(signal.SIGINT)
    signal.raise_signal(signal.SIGTERM)
    assert left == [], "quick repetitions do not cut short what is being saved"
    ending.leave()
    assert left == [128 + number]
    ending.first -= 10.0  # s
    signal.raise_signal(signal.SIGINT)
    assert left[1:] == [128 + signal.SIGINT], "a later one does"


def test_signals_ignored_by_the_caller_stay_ignored(ending):
    """As under nohup."""
    signal.signal(signal.SIGHUP, signal.SIG_IGN)
    ending.listen()
    signal.raise_signal(signal.SIGHUP)


def started(folder, *arguments, code="from jaxbuffer.cli import main; main()", **options):
    """The command line in another process."""
    source = Path(jaxbuffer.__file__).resolve().parents[1]
    settings = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, **options}
    environment = {**os.environ, "PYTHONPATH": str(source), **settings.pop("env", {})}
    return subprocess.Popen([sys.executable, "-c", code, *arguments], cwd=folder, env=environment, **settings)


@pytest.mark.slow
@pytest.mark.parametrize("encoding", [pytest.param("latin-1", marks=pytest.mark.long), "ascii"])
def test_another_process_prints_in_its_encoding(computed, no_figures, tmp_path, encoding):
    assert run(["sweep", "--output", "out"]) == 0
    with started(tmp_path, "report", "out", env={"PYTHONIOENCODING": encoding}) as process:
        shown, errors = process.communicate(timeout=60)
    assert (process.returncode, errors) == (0, b"")
    assert b"captures end captured in a sweep" in shown and shown.decode(encoding)


@pytest.mark.long
def test_a_full_pipe_is_one_line(computed, no_figures, tmp_path):
    assert run(["simulate", "--output", "out"]) == 0
    with open("/dev/full", "wb") as full, started(tmp_path, "report", "out", stdout=full) as process:
        errors = process.communicate(timeout=60)[1]
    assert (process.returncode, errors) == (3, b"error: standard output: No space left on device\n")


@pytest.mark.slow
def test_a_reader_that_leaves_is_no_traceback(computed, no_figures, tmp_path):
    assert run(["simulate", "--output", "out"]) == 0
    reading, writing = os.pipe()
    os.close(reading)
    with started(tmp_path, "report", "out", stdout=writing) as process:
        errors = process.communicate(timeout=60)[1]
    os.close(writing)
    assert process.returncode == 3 and b"Traceback" not in errors and errors.count(b"\n") <= 1
