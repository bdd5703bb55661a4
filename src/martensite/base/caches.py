"""The cache folder of the user, whose files may be programs, so that no other user may write there.

A folder or file is trusted if this user owns it and neither its group nor others may write it. The folder
above the cache must not let others rename what is in it. Windows keeps such folders private by itself.
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
    """Return a folder within the cache folder, made if need be, with mode 0700.

    Args:
        names: the folder, from the cache folder down.

    Raises:
        OSError: it cannot be made, or another user owns it or may write it; `strerror` is the reason.
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
    """Return the same folder; raise `DataError` with a remedy instead of `OSError`."""
    try:
        return make_cache(*names)
    except OSError as error:
        raise DataError(f"The cache folder cannot be used: {error.strerror}. Name another in XDG_CACHE_HOME.") from None


def make_private_folder(folder: Path) -> None:
    """Make a folder with mode 0700 if it is missing; `OSError` if another user owns it or may write it."""
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
        found = one.lstat()
        if found.st_uid != os.getuid():
            raise _describe_danger(one, "another user owns it")
        if found.st_mode & _SHARED and not stat.S_ISLNK(found.st_mode):
            raise _describe_danger(one, "others may write it; run `chmod go-w` on it")


def is_private_file(path: Path) -> bool:
    """Return whether an ordinary file is there that this user owns and no other may write."""
    try:
        found = path.lstat()
    except OSError:
        return False
    if os.name != "posix":
        return stat.S_ISREG(found.st_mode)
    return stat.S_ISREG(found.st_mode) and found.st_uid == os.getuid() and not found.st_mode & _SHARED


def keep_private(made: Path, path: Path, mode: int = 0o600) -> None:
    """Move a new file to its place in a cache, as one that no other user may write."""
    made.chmod(mode)
    made.replace(path)


def _describe_danger(path: Path, reason: str) -> OSError:
    return PermissionError(errno.EACCES, f"`{path}` is not trusted, for {reason}", str(path))
