"""Owns the tables of designs. Times are seconds since 1970; text that is sought or sorted is folded to one case.

A document is kept once, by its identity, as the canonical JSON that the identity is the hash of. Revisions only ever
grow in number; a design's row repeats of its newest revision what lists show.
"""

from __future__ import annotations

from sqlalchemy import Column, Float, ForeignKey, Index, Integer, LargeBinary, MetaData, String, Table, Text

metadata = MetaData(
    naming_convention={
        "fk": "fk_%(table_name)s_%(column_0_name)s",
        "pk": "pk_%(table_name)s",
        "uq": "uq_%(table_name)s",
    }
)
# by code point, as in SQLite: a database's own order of words would let pages differ from one server to the next
_folded = String(400).with_variant(String(400, collation="C"), "postgresql")

documents = Table(
    "documents",
    metadata,
    Column("identity", String(64), primary_key=True),
    Column("content", Text, nullable=False),
)

designs = Table(
    "designs",
    metadata,
    Column("number", Integer, primary_key=True),  # SQLite keeps it in every index, so that a search need not read rows
    Column("id", String(26), nullable=False, unique=True),
    Column("name", String(200), nullable=False),
    Column("name_folded", _folded, nullable=False),
    Column("summary", Text, nullable=False),
    Column("tags", Text, nullable=False),  # a JSON list, as they were written
    Column("revision", Integer, nullable=False),
    Column("identity", String(64), ForeignKey("documents.identity"), nullable=False),
    Column("created", Float, nullable=False),
    Column("updated", Float, nullable=False),
    Column("deleted", Float),
    Index("designs_by_update", "updated", "number"),
    Index("designs_by_age", "created", "number"),
    Index("designs_by_name", "name_folded", "number"),
)

revisions = Table(
    "revisions",
    metadata,
    Column("design_id", String(26), ForeignKey("designs.id"), primary_key=True),
    Column("number", Integer, primary_key=True),
    Column("identity", String(64), ForeignKey("documents.identity"), nullable=False),
    Column("name", String(200), nullable=False),
    Column("tags", Text, nullable=False),
    Column("comment", Text, nullable=False),
    Column("created", Float, nullable=False),
)

design_tags = Table(
    "design_tags",
    metadata,
    Column("design", Integer, ForeignKey("designs.number"), primary_key=True),
    Column("tag", String(120), primary_key=True),  # folded
    Index("design_tags_by_tag", "tag", "design"),
)

design_texts = Table(
    "design_texts",
    metadata,
    Column("design", Integer, ForeignKey("designs.number"), primary_key=True, autoincrement=False),
    Column("folded", Text, nullable=False),
)

thumbnails = Table(
    "thumbnails",
    metadata,
    Column("design_id", String(26), ForeignKey("designs.id"), primary_key=True),
    Column("media_type", String(80), nullable=False),
    Column("digest", String(64), nullable=False),
    Column("created", Float, nullable=False),
    Column("content", LargeBinary, nullable=False),  # last: SQLite then finds the digest without reading the picture
)
