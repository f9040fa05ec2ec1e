"""The versions of the database's schema, one a file, oldest first."""
