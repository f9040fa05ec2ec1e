"""The documents that are computed: `python -m docs.make_paper` writes docs/paper.md and its figures anew."""
