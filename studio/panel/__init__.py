"""The left panel: rows made from the fields' metadata, sections of rows, and the form that holds them together."""
