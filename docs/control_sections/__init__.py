"""The sections of docs/control.md: one module each with a `section()` that returns its Markdown, heading included."""
