"""Whether a folder may hold programs: they are code, so nobody else may be able to put one there."""

import os
import stat
from pathlib import Path

OTHERS = stat.S_IWGRP | stat.S_IWOTH


def made_private(folder: Path) -> str:
    """Make the folder where it is missing, readable by its owner only; "" if nobody else can write there, else what is
    wrong and how to mend it.

    Where a link is on the way, what counts is where it leads; the folder itself must not be one. Windows, which has no
    such modes, leaves it to the home folder's own protection.
    """
    if not hasattr(os, "getuid"):
        folder.mkdir(parents=True, exist_ok=True)
        return ""
    try:
        _make(folder)
        if stat.S_ISLNK(os.lstat(folder).st_mode):
            return f"{folder} is a link; set JAXBUFFER_CACHE to where it leads"
        place = folder.resolve(strict=True)
        wrong = _wrong(place, os.lstat(place))
        return wrong or next(filter(None, (_replaceable(parent, os.lstat(parent)) for parent in place.parents)), "")
    except OSError as error:
        return f"{error.filename or folder}: {error.strerror}; set JAXBUFFER_CACHE to a folder of your own"


def _make(folder: Path) -> None:
    """Make the folder and those above it, for the owner only whatever the process's mask is."""
    missing = [place for place in (folder, *folder.parents) if not place.is_symlink() and not place.exists()]
    for place in reversed(missing):
        place.mkdir(mode=0o700, exist_ok=True)


def _wrong(folder: Path, found: os.stat_result) -> str:
    if not stat.S_ISDIR(found.st_mode):
        return f"{folder} is not a folder; set JAXBUFFER_CACHE to one"
    if found.st_uid != os.getuid():
        return f"{folder} belongs to another user; set JAXBUFFER_CACHE to a folder of your own"
    if found.st_mode & OTHERS:
        return f"others may write to {folder}; once you trust what is in it: chmod 700 '{folder}'"
    return ""


def _replaceable(parent: Path, found: os.stat_result) -> str:
    """What lets others put another folder in the place of one in here: in a sticky one (/tmp) they can't."""
    if found.st_uid not in (0, os.getuid()):
        return f"{parent} belongs to another user; set JAXBUFFER_CACHE to a folder of your own"
    if found.st_mode & OTHERS and not found.st_mode & stat.S_ISVTX:
        return f"others may write to {parent}: chmod go-w '{parent}', or set JAXBUFFER_CACHE to another folder"
    return ""
