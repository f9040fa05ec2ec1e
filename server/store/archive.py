"""Owns zip archives of designs: what goes into one, and what is taken out of one that anybody may have made.

Names of entries are only ever read and told, never used as paths. An archive that may harm is refused as a whole.
"""

from __future__ import annotations

import json
import re
import stat
import zipfile
import zlib
from collections.abc import Iterable
from dataclasses import dataclass
from datetime import UTC, datetime
from io import BytesIO
from typing import Any

from models.design import Design
from models.problems import DesignError, Problem, echo
from server.store.records import StoredDesign

MANIFEST = "manifest.json"
MANIFEST_FORMAT = "glider-designs"
MOST_ENTRIES = 1000
LARGEST_ARCHIVE = 64 * 2**20
"""Most bytes that an archive's entries may have together, unpacked."""
LARGEST_FILE = LARGEST_ARCHIVE + 1024 * MOST_ENTRIES
"""Most bytes of an archive itself: such entries that do not shrink, their names twice, and the table of them."""
CHUNK = 64 * 1024
ENCRYPTED = 0x1
ZIP_BEGINS = (b"PK\x03\x04", b"PK\x05\x06", b"PK\x07\x08")
LONGEST_SLUG = 60


@dataclass(frozen=True, slots=True)
class Entry:
    """A file in an archive, and the tags that the archive's manifest files it under, not yet checked."""

    name: str
    content: bytes
    tags: Any = ()


def file_name(stored: StoredDesign, name: str) -> str:
    """Return the name of a design's file: its own name in plain letters, and its identifier."""
    slug = re.sub(r"[^A-Za-z0-9]+", "-", name)[:LONGEST_SLUG].strip("-").lower() or "design"
    return f"{slug}-{stored.id}.json"


def write_archive(stored: Iterable[StoredDesign], *, now: float, largest_entry: int) -> bytes:
    """Return a zip of designs, each as the file that anyone can open, and a manifest of what is not in the files.

    Raises `DesignError` where they are more than an import takes back, whose largest entry is given.
    """
    items: list[dict[str, Any]] = []
    left = LARGEST_ARCHIVE
    file = BytesIO()
    with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as archive:
        for one in stored:
            design = one.design
            name, content = file_name(one, design.name), _file_of(design, largest_entry)
            left = _taken(left, content)
            archive.writestr(_info(name, one.updated), content)
            items.append(
                {
                    "file": name, "id": one.id, "name": design.name, "tags": one.tags, "revision": one.revision,
                    "identity": one.identity, "updated": _stamp(one.updated),
                }
            )  # fmt: skip
        manifest = {"format": MANIFEST_FORMAT, "version": 1, "exported": _stamp(now), "items": items}
        content = (json.dumps(manifest, indent=1, ensure_ascii=False) + "\n").encode()
        _taken(left, content)
        archive.writestr(_info(MANIFEST, now), content)
    return file.getvalue()


def _file_of(design: Design, largest: int) -> bytes:
    """Return a design's file: indented, unless only without that it is small enough to be taken back."""
    content = design.to_json().encode()
    if len(content) > largest:
        content = design.model_dump_json().encode()
    if len(content) > largest:
        size = f"a file of {len(content)} bytes, more than an import takes: {largest}"
        way_out = "export it alone, or raise GLIDER_STUDIO_MAX_BODY_BYTES"
        raise _refusal(f"the design {echo(design.name)} is {size}", limit=largest, hint=way_out)
    return content


def _taken(left: int, content: bytes) -> int:
    """Return how many bytes are left to an archive after an entry."""
    if len(content) > left:
        message = f"the designs have more than {LARGEST_ARCHIVE} bytes together"
        raise _refusal(message, limit=LARGEST_ARCHIVE, hint="choose fewer, by ids or by tag")
    return left - len(content)


def _info(name: str, at: float) -> zipfile.ZipInfo:
    when = max(datetime.fromtimestamp(at, UTC), datetime(1980, 1, 1, tzinfo=UTC))
    info = zipfile.ZipInfo(name, when.timetuple()[:6])
    info.compress_type = zipfile.ZIP_DEFLATED
    info.external_attr = 0o644 << 16
    return info


def _stamp(at: float) -> str:
    return datetime.fromtimestamp(at, UTC).isoformat()


def read_archive(content: bytes, *, largest_entry: int) -> list[Entry]:
    """Return the files of an archive, folders and its manifest left out.

    Raises
    ------
    DesignError
        Where it is no zip, is damaged, or could do harm: too many entries, too much inside, paths that lead elsewhere,
        links, passwords, archives in it.

    """
    try:
        with zipfile.ZipFile(BytesIO(content)) as archive:
            infos = [info for info in archive.infolist() if not info.is_dir()]
            _check_entries(infos)
            files = _unpacked(archive, infos, largest_entry)
    except (zipfile.BadZipFile, zlib.error, EOFError, NotImplementedError, ValueError, OSError, RuntimeError) as error:
        if isinstance(error, DesignError):
            raise
        raise _refusal(f"the archive is damaged or no zip file: {error}") from None
    tags = _manifest_tags(files.pop(MANIFEST, b"{}"))
    return [Entry(name, inside, tags.get(name, ())) for name, inside in files.items()]


def _refusal(message: str, *, limit: int | None = None, hint: str | None = None) -> DesignError:
    return DesignError([Problem("", message, limit, hint)])


def _check_entries(infos: list[zipfile.ZipInfo]) -> None:
    if len(infos) > MOST_ENTRIES + 1:  # and the manifest
        raise _refusal(
            f"the archive has {len(infos)} entries, more than {MOST_ENTRIES}", limit=MOST_ENTRIES, hint="send several"
        )
    seen: set[str] = set()
    for info in infos:
        reason = _entry_problem(info)
        if reason is None and info.filename in seen:
            reason = "comes twice"
        if reason is not None:
            raise _refusal(f"the archive is refused: its entry {echo(info.filename)} {reason}")
        seen.add(info.filename)


def _entry_problem(info: zipfile.ZipInfo) -> str | None:
    # as it is in the file: zipfile itself cuts names at a NUL and turns some separators
    name = info.orig_filename
    mode = info.external_attr >> 16
    if name.startswith(("/", "\\")) or re.match(r"[A-Za-z]:", name):
        return "has an absolute path"
    if ".." in re.split(r"[/\\]", name) or "\\" in name or not name.isprintable():
        return "has a path that leads elsewhere"
    if mode and stat.S_IFMT(mode) not in (0, stat.S_IFREG):
        return "is a link or a device, not a file"
    if info.flag_bits & ENCRYPTED:
        return "is encrypted"
    if info.compress_type not in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED):
        return "is compressed by a method other than deflate"
    if name.lower().endswith(".zip"):
        return "is itself an archive"
    return None


def _unpacked(archive: zipfile.ZipFile, infos: list[zipfile.ZipInfo], largest: int) -> dict[str, bytes]:
    """Unpack within limits: by what comes out, not by what the archive says will come out."""
    files: dict[str, bytes] = {}
    left = LARGEST_ARCHIVE
    for info in infos:
        most = LARGEST_ARCHIVE if info.filename == MANIFEST else largest
        parts: list[bytes] = []
        size = 0
        with archive.open(info) as file:
            while part := file.read(CHUNK):
                size += len(part)
                if size > most:
                    raise _refusal(
                        f"the archive's entry {echo(info.filename)} has more than {most} bytes unpacked", limit=most
                    )
                if size > left:
                    raise _refusal(f"the archive has more than {LARGEST_ARCHIVE} bytes unpacked", limit=LARGEST_ARCHIVE)
                parts.append(part)
        left -= size
        inside = b"".join(parts)
        if inside.startswith(ZIP_BEGINS):
            raise _refusal(f"the archive is refused: its entry {echo(info.filename)} is itself an archive")
        files[info.filename] = inside
    return files


def _manifest_tags(manifest: bytes) -> dict[str, Any]:
    try:
        content = json.loads(manifest)
    except (ValueError, RecursionError):
        return {}  # a file of that name that is no manifest of ours
    items = content.get("items") if isinstance(content, dict) and content.get("format") == MANIFEST_FORMAT else None
    tags: dict[str, Any] = {}
    for item in items if isinstance(items, list) else ():
        if isinstance(item, dict) and isinstance(item.get("file"), str):
            tags[item["file"]] = item.get("tags", ())
    return tags
