"""Tests of the glider studio; the folders mirror the source."""
