"""Designs: documents, revisions, tags, the text that searches look into, and thumbnails."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0001"
down_revision: str | None = None

# trigrams find any part of a word of three letters or more; the text is folded to one case before it is kept
SQLITE_SEARCH = (
    "CREATE VIRTUAL TABLE design_search USING fts5(folded, content='design_texts', content_rowid='design', "
    "tokenize='trigram case_sensitive 1')",
    "CREATE TRIGGER design_texts_added AFTER INSERT ON design_texts BEGIN "
    "INSERT INTO design_search(rowid, folded) VALUES (new.design, new.folded); END",
    "CREATE TRIGGER design_texts_removed AFTER DELETE ON design_texts BEGIN "
    "INSERT INTO design_search(design_search, rowid, folded) VALUES ('delete', old.design, old.folded); END",
    "CREATE TRIGGER design_texts_changed AFTER UPDATE ON design_texts BEGIN "
    "INSERT INTO design_search(design_search, rowid, folded) VALUES ('delete', old.design, old.folded); "
    "INSERT INTO design_search(rowid, folded) VALUES (new.design, new.folded); END",
)


def upgrade() -> None:
    """Make the tables of designs."""
    sqlite = op.get_bind().dialect.name == "sqlite"
    _make_designs(sa.String(400) if sqlite else sa.String(400, collation="C"))
    _make_revisions()
    _make_searched()
    op.create_table(
        "thumbnails",
        sa.Column("design_id", sa.String(26), sa.ForeignKey("designs.id", name="fk_thumbnails_design_id")),
        sa.Column("media_type", sa.String(80), nullable=False),
        sa.Column("digest", sa.String(64), nullable=False),
        sa.Column("created", sa.Float, nullable=False),
        sa.Column("content", sa.LargeBinary, nullable=False),
        sa.PrimaryKeyConstraint("design_id", name="pk_thumbnails"),
    )
    if sqlite:
        for statement in SQLITE_SEARCH:
            op.execute(statement)


def _make_designs(folded: sa.String) -> None:
    op.create_table(
        "documents",
        sa.Column("identity", sa.String(64), nullable=False),
        sa.Column("content", sa.Text, nullable=False),
        sa.PrimaryKeyConstraint("identity", name="pk_documents"),
    )
    op.create_table(
        "designs",
        sa.Column("number", sa.Integer, nullable=False),
        sa.Column("id", sa.String(26), nullable=False),
        sa.Column("name", sa.String(200), nullable=False),
        sa.Column("name_folded", folded, nullable=False),
        sa.Column("summary", sa.Text, nullable=False),
        sa.Column("tags", sa.Text, nullable=False),
        sa.Column("revision", sa.Integer, nullable=False),
        sa.Column(
            "identity", sa.String(64), sa.ForeignKey("documents.identity", name="fk_designs_identity"), nullable=False
        ),
        sa.Column("created", sa.Float, nullable=False),
        sa.Column("updated", sa.Float, nullable=False),
        sa.Column("deleted", sa.Float),
        sa.PrimaryKeyConstraint("number", name="pk_designs"),
        sa.UniqueConstraint("id", name="uq_designs"),
    )
    op.create_index("designs_by_update", "designs", ["updated", "number"])
    op.create_index("designs_by_age", "designs", ["created", "number"])
    op.create_index("designs_by_name", "designs", ["name_folded", "number"])


def _make_revisions() -> None:
    op.create_table(
        "revisions",
        sa.Column("design_id", sa.String(26), sa.ForeignKey("designs.id", name="fk_revisions_design_id")),
        sa.Column("number", sa.Integer, nullable=False),
        sa.Column(
            "identity", sa.String(64), sa.ForeignKey("documents.identity", name="fk_revisions_identity"), nullable=False
        ),
        sa.Column("name", sa.String(200), nullable=False),
        sa.Column("tags", sa.Text, nullable=False),
        sa.Column("comment", sa.Text, nullable=False),
        sa.Column("created", sa.Float, nullable=False),
        sa.PrimaryKeyConstraint("design_id", "number", name="pk_revisions"),
    )


def _make_searched() -> None:
    op.create_table(
        "design_tags",
        sa.Column("design", sa.Integer, sa.ForeignKey("designs.number", name="fk_design_tags_design")),
        sa.Column("tag", sa.String(120), nullable=False),
        sa.PrimaryKeyConstraint("design", "tag", name="pk_design_tags"),
    )
    op.create_index("design_tags_by_tag", "design_tags", ["tag", "design"])
    op.create_table(
        "design_texts",
        sa.Column(
            "design", sa.Integer, sa.ForeignKey("designs.number", name="fk_design_texts_design"), autoincrement=False
        ),
        sa.Column("folded", sa.Text, nullable=False),
        sa.PrimaryKeyConstraint("design", name="pk_design_texts"),
    )
