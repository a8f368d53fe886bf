"""Places that are not as usual: homes that nobody knows, paths with "~", file systems without locks, dangling links."""

import errno
import fcntl
import os
import pathlib
import platform
import pwd
import subprocess
import sys

import pytest

import jaxbuffer as jb
from jaxbuffer.cli.entry import run
from jaxbuffer.files import LOCK, Lock, cache_folder, home, user_path
from jaxbuffer.output.provenance import made
from jaxbuffer.programs import store
from jaxbuffer.programs.load import MachineCode

NO_LOCKS = (errno.ENOSYS, errno.ENOLCK, errno.EOPNOTSUPP, errno.EINVAL)


@pytest.fixture
def nobody(monkeypatch):
    """A user without a home: neither $HOME nor an entry in the system's list, as in some containers."""

    def unknown(_):
        raise KeyError

    for name in ("HOME", "XDG_CACHE_HOME", "JAXBUFFER_CACHE"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setattr(pwd, "getpwuid", unknown)


@pytest.fixture(params=NO_LOCKS, ids=errno.errorcode.get)
def without_locks(monkeypatch, request):
    def refuse(*_):
        raise OSError(request.param, os.strerror(request.param))

    monkeypatch.setattr(fcntl, "flock", refuse)


@pytest.mark.parametrize(
    ("own", "word", "recorded"),
    [
        ("/home/me", "/home/me/drop.toml", "~/drop.toml"),
        ("/home/me", "/home/me", "~"),
        ("/home/me/", "/home/me/two words.toml", "~/'two words.toml'"),
        ("/home/me", "--output=/home/me/out", "--output=~/out"),
        ("/home/me", "/home/menu/drop.toml", "/home/menu/drop.toml"),
        ("/home/me", "--output=/home/me2", "--output=/home/me2"),
        ("/home/me", "/data/home/me/drop.toml", "/data/home/me/drop.toml"),
        ("/home/me", "0.15 m/s", "'0.15 m/s'"),
        ("/", "/data/drop.toml", "/data/drop.toml"),
        ("/root", "rooted", "rooted"),
        ("m", "drop.toml", "drop.toml"),
    ],
)
def test_the_home_folder_in_a_recorded_command_is_a_tilde_and_nothing_else_is(monkeypatch, own, word, recorded):
    monkeypatch.setenv("HOME", own)
    assert made(["simulate", word], None, {}, 1.0)["command"] == f"jaxbuffer simulate {recorded}"


def test_a_command_without_a_home_is_recorded_and_has_no_cache(nobody):
    assert home() is None and cache_folder() is None
    assert made(["simulate", "/data/drop.toml"], None, {}, 1.0)["command"] == "jaxbuffer simulate /data/drop.toml"
    with pytest.raises(jb.InputError, match=r"~/out: the folder ~ is not known; write the whole path"):
        user_path("~/out")


def test_programs_are_kept_in_memory_where_no_home_is_known(nobody, monkeypatch, capsys):
    monkeypatch.setattr("jaxbuffer.programs.process.folder", lambda: None)
    jb.configure()
    said = "the home folder is not known; set JAXBUFFER_CACHE to a folder of your own"
    assert capsys.readouterr().err == f"note: compiled programs are not stored: {said}\n"


def test_an_empty_home_is_not_the_folder_one_stands_in(monkeypatch):
    monkeypatch.setenv("HOME", "")
    monkeypatch.setenv("JAXBUFFER_CACHE", "")
    monkeypatch.setenv("XDG_CACHE_HOME", "")
    assert str(cache_folder()) == f"{pwd.getpwuid(os.getuid()).pw_dir}/.cache/jaxbuffer"


@pytest.mark.parametrize("path", ["~", "~/out", "~/a/~/b", "here/~", "./~", "out", ""])
def test_a_leading_tilde_is_the_home_folder(monkeypatch, path):
    monkeypatch.setenv("HOME", "/home/me")
    expected = {"~": "/home/me", "~/out": "/home/me/out", "~/a/~/b": "/home/me/a/~/b", "": ".", "./~": "~"}
    meant = {**expected, "./~": "/home/me"}  # pathlib drops a leading "./"
    assert str(user_path(path)) == meant.get(path, path)


def test_another_user_s_home_is_named_where_it_is_not_known():
    with pytest.raises(jb.InputError, match="the folder ~nobody-has-this-name is not known"):
        user_path("~nobody-has-this-name/out")


def test_every_path_of_a_call_may_begin_with_a_tilde(monkeypatch, tmp_path):
    monkeypatch.setenv("HOME", str(tmp_path))
    monkeypatch.chdir(tmp_path)
    jb.save_design("~/drop.toml", jb.BarDrop())
    assert jb.load_design("~/drop.toml")[0] == jb.BarDrop()
    run = jb.simulate(jb.BarDrop(), jb.BarDropScenario(height=0.194), 0.22)
    assert jb.save(run, "~/out")[0] == tmp_path / "out" / "drop.json"
    assert jb.load("~/out").run.attrs["kind"] == "bar_drop"
    assert jb.report("~/out") == tmp_path / "out" / "report.html"
    assert jb.report("~/out", to="~/page.html") == tmp_path / "page.html"
    assert not (tmp_path / "~").exists()


def test_a_folder_has_one_owner_where_files_cannot_be_locked(without_locks, tmp_path):
    lock = Lock(tmp_path / "out")
    with pytest.raises(jb.InputError, match=rf"out is in use by another run, process {os.getpid()};"):
        Lock(tmp_path / "out")
    lock.release()
    assert not list((tmp_path / "out").iterdir())
    Lock(tmp_path / "out").release()


def test_an_owner_that_is_gone_or_may_be_at_work_elsewhere_is_told_apart(without_locks, tmp_path):
    gone = subprocess.Popen([sys.executable, "-c", ""])
    gone.wait()
    for owner in (f"{gone.pid} {platform.node()}", f"{gone.pid}", f"{os.getpid()} {platform.node()}", "", "garbled"):
        (tmp_path / LOCK).write_text(owner)
        Lock(tmp_path).release()
    for owner, message in (
        (f"{os.getppid()} {platform.node()}", f"process {os.getppid()}; choose another folder"),
        ("1 elsewhere", f"process 1 on elsewhere; choose another folder, or delete {tmp_path / LOCK} once"),
    ):
        (tmp_path / LOCK).write_text(owner)
        with pytest.raises(jb.InputError, match=message):
            Lock(tmp_path)
        assert (tmp_path / LOCK).read_text() == owner


def test_a_program_is_read_again_where_files_cannot_be_locked(without_locks, tmp_path):
    """A marker without a lock would be taken for one that a process left which the program had ended."""
    file = tmp_path / "a.program"
    program = store.Stored({}, b"example", [MachineCode(b"code", 2, 1, False)])
    store.write(file, program)
    for _ in range(2):
        with store.being_made(file), store.being_loaded(file):
            assert store.read(file) == program
    assert [it.name for it in tmp_path.iterdir()] == ["a.program"]


@pytest.mark.parametrize("folder", ["out", "out/further"])
def test_a_link_that_leads_nowhere_is_named(computed_nowhere, tmp_path, monkeypatch, capsys, folder):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "out").symlink_to("unmounted")
    said = "out is a link to unmounted, which is not there; make it, or choose another folder"
    assert run(["simulate", "--output", folder]) == 2
    assert capsys.readouterr().err == f"error: {said}\n"
    with pytest.raises(jb.InputError, match=said):
        Lock(pathlib.Path(folder))
    assert [it.name for it in tmp_path.iterdir()] == ["out"]


@pytest.fixture
def computed_nowhere(monkeypatch):
    """Nothing may be computed: the folder is refused first."""

    def never(*_, **__):
        raise AssertionError

    monkeypatch.setattr("jaxbuffer.cli.commands.simulate.compute", never)
