"""The store: designs and what belongs to them in SQLite or PostgreSQL; it knows no HTTP."""
