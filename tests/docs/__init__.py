"""Tests of the documents that are computed."""
