"""Archives and thumbnails that anybody may have made: what is right comes through, what could do harm is refused."""

from __future__ import annotations

import io
import json
import struct
import zipfile
import zlib

import pytest

from models.design import loads_design
from models.presets import load_preset
from models.problems import DesignError
from server.store import archive
from server.store.archive import MOST_ENTRIES, file_name, read_archive, write_archive
from server.store.records import Content, StoredDesign
from server.store.thumbnails import check_thumbnail
from studio.thumbnail import draw
from tests.server.support import Stopwatch

LARGEST = 100_000
SOON = 5.0
SVG = '<svg xmlns="http://www.w3.org/2000/svg" xmlns:xlink="http://www.w3.org/1999/xlink">{}</svg>'


def stored(number, name="A glider"):
    design = load_preset("canete-dual-bellows").model_copy(update={"name": name})
    made = Content(design)
    return StoredDesign(f"{number:026d}", 3, made.identity, ("a", "b"), "", 1e9, 2e9, made.document)


def zipped(entries, **options):
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as made:
        for name, content in entries:
            made.writestr(name, content, **options)
    return file.getvalue()


def with_info(**fields):
    info = zipfile.ZipInfo("a.json")
    for name, value in fields.items():
        setattr(info, name, value)
    return zipped([(info, b"{}")])


def test_what_is_written_is_read():
    many = [stored(1), stored(2, "../../etc/passwd"), stored(3, "C:\\ <b> Ünïcode \U0001f6a4"), stored(4, "…")]
    entries = read_archive(write_archive(many, now=1e9, largest_entry=LARGEST), largest_entry=LARGEST)
    assert [json.loads(entry.content) for entry in entries] == [json.loads(one.document) for one in many]
    assert all(entry.tags == ["a", "b"] for entry in entries)
    assert [entry.name for entry in entries] == [file_name(one, one.design.name) for one in many]
    assert [entry.name.rpartition("-")[0] for entry in entries] == ["a-glider", "etc-passwd", "c-b-n-code", "design"]


def test_the_manifest_says_what_is_inside():
    with zipfile.ZipFile(io.BytesIO(write_archive([stored(1)], now=1e9, largest_entry=LARGEST))) as made:
        manifest = json.loads(made.read("manifest.json"))
        assert made.testzip() is None
    one = stored(1)
    assert manifest["format"] == "glider-designs" and manifest["exported"] == "2001-09-09T01:46:40+00:00"
    assert manifest["items"] == [
        {"file": file_name(one, "A glider"), "id": one.id, "name": "A glider", "tags": ["a", "b"], "revision": 3,
         "identity": one.identity, "updated": "2033-05-18T03:33:20+00:00"}
    ]  # fmt: skip


def test_an_export_is_never_more_than_an_import_takes(monkeypatch):
    monkeypatch.setattr(archive, "LARGEST_ARCHIVE", 30_000)
    assert read_archive(write_archive([stored(1), stored(2)], now=1e9, largest_entry=LARGEST), largest_entry=LARGEST)
    with pytest.raises(DesignError, match="more than 30000 bytes together"):
        write_archive([stored(n) for n in range(3)], now=1e9, largest_entry=LARGEST)


def test_the_manifest_counts_too(monkeypatch):
    def written(most):
        monkeypatch.setattr(archive, "LARGEST_ARCHIVE", most)
        return write_archive([stored(1)], now=1e9, largest_entry=LARGEST)

    with zipfile.ZipFile(io.BytesIO(written(LARGEST))) as made:
        whole = sum(info.file_size for info in made.infolist())
    assert len(read_archive(written(whole), largest_entry=LARGEST)) == 1
    with pytest.raises(DesignError, match="choose fewer"):
        written(whole - 1)


def test_a_file_that_only_its_indents_make_too_large_goes_without_them():
    design = stored(1).design
    indented, plain = len(design.to_json().encode()), len(design.model_dump_json().encode())
    assert plain < indented

    def entry_of(largest):
        made = write_archive([stored(1)], now=1e9, largest_entry=largest)
        (entry,) = read_archive(made, largest_entry=largest)
        return entry.content

    assert [len(entry_of(most)) for most in (indented, indented - 1, plain)] == [indented, plain, plain]
    assert loads_design(entry_of(plain)) == design
    with pytest.raises(DesignError, match=f"is a file of {plain} bytes, more than an import takes: {plain - 1}"):
        entry_of(plain - 1)


@pytest.mark.parametrize(
    "manifest",
    [b"[]", b"{", b"\xff", b'{"format": "glider-designs"}', b'{"format": "glider-designs", "items": [1, {}]}'],
)
def test_other_manifests_are_passed_over(manifest):
    (entry,) = read_archive(
        zipped([("manifest.json", manifest), ("d/", b""), ("d/x.json", b"{}")]), largest_entry=LARGEST
    )
    assert (entry.name, entry.content, entry.tags) == ("d/x.json", b"{}", ())


@pytest.mark.parametrize(
    ("content", "says"),
    [
        (b"", "no zip"),
        (b"PK\x03\x04", "no zip"),
        (b"x" * 1000, "no zip"),
        (zipped([("a.json", b"{}" * 99)])[:-30], "no zip"),
        (zipped([("/etc/passwd", b"")]), "absolute path"),
        (zipped([("\\windows\\x", b"")]), "absolute path"),
        (zipped([("C:/x.json", b"")]), "absolute path"),
        (zipped([("a/../../x.json", b"")]), "leads elsewhere"),
        (zipped([("a\\..\\x.json", b"")]), "leads elsewhere"),
        (zipped([("a\nb.json", b"")]), "leads elsewhere"),
        (zipped([("x.zip", b"")]), "itself an archive"),
        (zipped([("x.json", zipped([("y.json", b"{}")]))]), "itself an archive"),
        (zipped([("x.json", zipped([]))]), "itself an archive"),
        (zipped([(f"{n}.json", b"") for n in range(MOST_ENTRIES + 2)]), f"more than {MOST_ENTRIES}"),
        (zipped([("a.json", b" " * (LARGEST + 1))]), f"more than {LARGEST} bytes unpacked"),
        (zipped([("a.json", b"{}")], compress_type=zipfile.ZIP_LZMA), "other than deflate"),
        (zipped([("a.json", b"{}")], compress_type=zipfile.ZIP_BZIP2), "other than deflate"),
        (with_info(external_attr=0o120777 << 16), "a link or a device"),
        (with_info(external_attr=0o020666 << 16), "a link or a device"),
    ],
    ids=lambda value: value[:24] if isinstance(value, str) else "zip",
)  # fmt: skip
def test_archives_that_may_do_harm_are_refused(content, says):
    with Stopwatch(SOON), pytest.raises(DesignError, match=says):
        read_archive(content, largest_entry=LARGEST)


def test_encrypted_and_repeated_entries_are_refused():
    flagged = bytearray(zipped([("a.json", b"{}")]))
    flagged[flagged.index(b"PK\x01\x02") + 8] |= 1
    with pytest.raises(DesignError, match="is encrypted"):
        read_archive(bytes(flagged), largest_entry=LARGEST)
    with pytest.warns(UserWarning, match="Duplicate"):
        twice = zipped([("a.json", b"{}"), ("a.json", b"[]")])
    with pytest.raises(DesignError, match="comes twice"):
        read_archive(twice, largest_entry=LARGEST)


def test_bombs_are_stopped_by_what_comes_out(monkeypatch):
    many = zipped([(f"{n}.json", b" " * 90_000) for n in range(900)])
    assert len(many) < 400_000
    with Stopwatch(SOON), pytest.raises(DesignError, match=f"more than {archive.LARGEST_ARCHIVE} bytes unpacked"):
        read_archive(many, largest_entry=LARGEST)
    lying = zipped([("a.json", b" " * 50_000_000)])
    says_ten = lying.replace(struct.pack("<L", 50_000_000), struct.pack("<L", 10))
    with Stopwatch(SOON), pytest.raises(DesignError, match=r"unpacked|damaged"):
        read_archive(says_ten, largest_entry=LARGEST)


def test_damaged_archives_are_told_as_such():
    good = zipped([("a.json", bytes(range(256)) * 20)])
    refused = 0
    for place in range(0, len(good), 7):
        bad = bytearray(good)
        bad[place] ^= 0xFF
        try:
            read_archive(bytes(bad), largest_entry=LARGEST)
        except DesignError:
            refused += 1
    assert refused > 5


def png(width, height):
    head = struct.pack(">LLBBBBB", width, height, 8, 2, 0, 0, 0)
    chunk = b"IHDR" + head
    return b"\x89PNG\r\n\x1a\n" + struct.pack(">L", len(head)) + chunk + struct.pack(">L", zlib.crc32(chunk))


def test_the_studios_own_pictures_are_kept():
    picture = draw(load_preset("canete-dual-bellows"), None).encode()
    assert check_thumbnail("image/svg+xml", picture).content == picture
    assert check_thumbnail("image/png", png(480, 216)).media_type == "image/png"


@pytest.mark.parametrize(
    "inside",
    [
        "<style>rect { fill: url(#water) }</style><rect/>",
        '<use href="#a"/>',
        '<use xlink:href="#a"/>',
        '<!-- <script>x</script> --><path d="M 0 0"/>',
        '<rect fill="url(#water)" style="fill: url( \'#x\' )"/>',
    ],
)
def test_pictures_that_only_draw_are_kept(inside):
    assert check_thumbnail("image/svg+xml", SVG.format(inside).encode())


@pytest.mark.parametrize(
    ("content", "says"),
    [
        (SVG.format("<script>alert(1)</script>"), "'script' may do more"),
        (SVG.format('<g xmlns:h="http://www.w3.org/1999/xhtml"><h:script>x</h:script></g>'), "script' may do more"),
        (SVG.format('<rect onload="x"/>'), "'onload' runs a script"),
        (SVG.format('<rect OnClick="x"/>'), "'onclick' runs a script"),
        (SVG.format("<foreignObject/>"), "may do more"),
        (SVG.format('<image href="http://x/"/>'), "may do more"),
        (SVG.format('<animate attributeName="href"/>'), "may do more"),
        (SVG.format('<a href="javascript:x"><rect/></a>'), "may do more"),
        (SVG.format('<use href="http://x/#a"/>'), "a link leads out"),
        (SVG.format('<use xlink:href=" javascript:x"/>'), "a link leads out"),
        (SVG.format('<use href="data:image/svg+xml,x"/>'), "a link leads out"),
        (SVG.format("<style>@import 'http://x';</style>"), "a style fetches"),
        (SVG.format("<style>* { fill: url(http://x) }</style>"), "a style fetches"),
        (SVG.format("<style>@im\\70ort 'http://x';</style>"), "a style fetches"),
        (SVG.format('<rect style="fill: URL ( http://x )"/>'), "fetches from elsewhere"),
        (SVG.format('<rect fill="url(//x)"/>'), "fetches from elsewhere"),
        ('<!DOCTYPE svg [<!ENTITY a "b">]>' + SVG.format("&a;"), "declares a document type"),
        ("<?xml-stylesheet href='http://x'?>" + SVG.format(""), "style sheet"),
        ("<?xml version='1.0' encoding='none'?>" + SVG.format(""), "not"),
        ("<svg/>", "its root"),
        ("<html xmlns='http://www.w3.org/1999/xhtml'/>", "its root"),
        (SVG.format("<g>"), "not well-formed"),
        ("", "not well-formed"),
        ("text", "not well-formed"),
    ],
)
def test_pictures_that_do_more_are_refused(content, says):
    with pytest.raises(DesignError, match=says):
        check_thumbnail("image/svg+xml", content.encode())


@pytest.mark.parametrize(
    ("content", "says"),
    [(b"", "not a PNG"), (b"\x89PNG\r\n\x1a\n", "not a PNG"), (b"GIF89a" + b" " * 40, "not a PNG"),
     (png(4096, 10), "4096 by 10 pixels"), (png(10, 0), "10 by 0 pixels")],
)  # fmt: skip
def test_other_files_are_no_pictures(content, says):
    with pytest.raises(DesignError, match=says):
        check_thumbnail("image/png", content)


def test_text_that_is_not_utf_8_is_no_picture():
    with pytest.raises(DesignError, match="not UTF-8"):
        check_thumbnail("image/svg+xml", SVG.format("é").encode("latin-1"))
