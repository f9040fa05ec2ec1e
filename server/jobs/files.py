"""Owns a job's folder: chunk files that are whole or not there, and how they are found again."""

from __future__ import annotations

import contextlib
import errno
import os
import shutil
import socket
from collections.abc import Iterator
from pathlib import Path

from server.jobs.task import ChunkResult

TABLE, TRAJECTORIES = "parquet", "nc"
FULL = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)


class DiskFullError(Exception):
    """There is no room for a result; what was written before is whole."""


class JobFiles:
    """The results of one job, below the folder of all jobs. `job_id` is one that this program made."""

    def __init__(self, root: Path, job_id: str, *, reserve: int = 0) -> None:
        assert job_id.isalnum(), job_id
        self.folder = root / job_id
        self._reserve = reserve

    def path(self, chunk: int, ending: str = TABLE) -> Path:
        """Return where a chunk's file is, or would be."""
        return self.folder / f"chunk-{chunk:09d}.{ending}"

    def write(self, chunk: int, result: ChunkResult) -> None:
        """Write what a chunk gave; afterwards all of it is there.

        Raises
        ------
        DiskFullError
            Where there is no room, or less than the reserve would remain.

        """
        self.require_room(len(result.table) + len(result.trajectories or b""))
        try:
            if result.trajectories is not None:
                write_whole(self.path(chunk, TRAJECTORIES), result.trajectories)
            else:
                self.path(chunk, TRAJECTORIES).unlink(missing_ok=True)
            write_whole(self.path(chunk), result.table)
        except OSError as error:
            if error.errno not in FULL:
                raise
            message = f"the disk is full: {error.strerror}, while results were written; free some space and resume"
            raise DiskFullError(message) from None

    def require_room(self, wanted: int) -> None:
        """Raise `DiskFullError` unless `wanted` bytes can be written here and the reserve is left."""
        self.folder.mkdir(parents=True, exist_ok=True)
        free = shutil.disk_usage(self.folder).free
        if free < wanted + self._reserve:
            needed, reserve = max(wanted // 2**20, 1), self._reserve // 2**20
            raise DiskFullError(
                f"the disk is full: {free // 2**20} MiB are free where the results go; {needed} MiB are to be written "
                f"and {reserve} MiB kept free beside them; free some space and resume the job"
            )

    def forget(self, chunk: int) -> None:
        """Delete what a chunk gave."""
        for ending in (TABLE, TRAJECTORIES):
            self.path(chunk, ending).unlink(missing_ok=True)

    def sweep(self) -> None:
        """Delete what a process left half written as it died; nobody else may be writing."""
        for part in self.folder.glob("*.part"):
            part.unlink(missing_ok=True)

    def remove(self) -> None:
        """Delete the folder."""
        shutil.rmtree(self.folder, ignore_errors=True)

    def written(self, ending: str = TABLE) -> Iterator[Path]:
        """Yield the files of one kind, in the order of the cases."""
        yield from sorted(self.folder.glob(f"chunk-*.{ending}"))


def part_of(path: Path) -> Path:
    """Return where a file is while it is written: a name that no other process uses."""
    return path.with_name(f"{path.name}.{socket.gethostname()}-{os.getpid()}.part")


def write_whole(path: Path, content: bytes) -> None:
    """Write a file so that it is whole or not there, also after a power failure."""
    part = part_of(path)
    try:
        with part.open("wb") as out:
            out.write(content)
            out.flush()
            os.fsync(out.fileno())
        part.replace(path)
    except OSError:
        with contextlib.suppress(OSError):
            part.unlink()
        raise
    folder = os.open(path.parent, os.O_RDONLY)
    try:
        os.fsync(folder)
    finally:
        os.close(folder)
