"""Cache folder of the user. Its files may be programs, so no other user may be able to write there.

A folder or file is trusted if this user owns it and neither its group nor others may write it. The parent folder must
not let others rename it. Windows keeps such folders private.
"""

from __future__ import annotations

import errno
import os
import stat
import sys
from contextlib import suppress
from pathlib import Path

from martensite.base.errors import DataError

_SHARED = stat.S_IWGRP | stat.S_IWOTH


def cache_folder() -> Path:
    """Return the user's cache folder for this package."""
    if os.environ.get("XDG_CACHE_HOME"):
        return Path(os.environ["XDG_CACHE_HOME"]) / "martensite"
    if sys.platform == "darwin":
        return Path.home() / "Library" / "Caches" / "martensite"
    if sys.platform == "win32" and os.environ.get("LOCALAPPDATA"):
        return Path(os.environ["LOCALAPPDATA"]) / "martensite" / "Cache"
    return Path.home() / ".cache" / "martensite"


def make_cache(*names: str) -> Path:
    """Return a folder within the cache folder; create it with mode 0700 if it is missing.

    Args:
        names: path of the folder, relative to the cache folder.

    Raises:
        OSError: the folder cannot be created, or another user owns it or may write it.
    """
    try:
        folder = cache_folder()
    except RuntimeError as error:  # a user without a home
        raise OSError(errno.ENOENT, str(error)) from None
    make_private_folder(folder)
    for name in names:
        folder /= name
        make_private_folder(folder)
    return folder


def require_cache(*names: str) -> Path:
    """Return a cache folder as `make_cache` does; raise `DataError` instead of `OSError`."""
    try:
        return make_cache(*names)
    except OSError as error:
        raise DataError(f"The cache folder cannot be used: {error.strerror}. Name another in XDG_CACHE_HOME.") from None


def make_private_folder(folder: Path) -> None:
    """Create a folder with mode 0700 if it is missing; raise `OSError` if other users control it."""
    with suppress(FileExistsError):
        folder.parent.mkdir(parents=True, exist_ok=True)
    with suppress(FileExistsError):
        folder.mkdir(mode=0o700)
    if not folder.is_dir():
        raise NotADirectoryError(errno.ENOTDIR, os.strerror(errno.ENOTDIR), str(folder))
    if os.name != "posix":
        return
    for one in {folder, folder.resolve()}:
        above = one.parent.stat().st_mode
        if above & stat.S_IWOTH and not above & stat.S_ISVTX:
            raise _describe_danger(one.parent, "others may write it; run `chmod o-w` on it")
        status = one.lstat()
        if status.st_uid != os.getuid():
            raise _describe_danger(one, "another user owns it")
        if status.st_mode & _SHARED and not stat.S_ISLNK(status.st_mode):
            raise _describe_danger(one, "others may write it; run `chmod go-w` on it")


def is_private_file(path: Path) -> bool:
    """Return whether a regular file exists that this user owns and no other user may write."""
    try:
        status = path.lstat()
    except OSError:
        return False
    private = os.name != "posix" or (status.st_uid == os.getuid() and not status.st_mode & _SHARED)
    return stat.S_ISREG(status.st_mode) and private


def keep_private(new_file: Path, path: Path, mode: int = 0o600) -> None:
    """Move a new file to its place in a cache and deny other users write access."""
    new_file.chmod(mode)
    new_file.replace(path)


def _describe_danger(path: Path, reason: str) -> OSError:
    return PermissionError(errno.EACCES, f"`{path}` is not trusted, for {reason}", str(path))
