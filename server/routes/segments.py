"""Owns the part of a path that names one thing and ends before a colon, where what is done to it begins."""

from __future__ import annotations

from starlette.convertors import StringConvertor, register_url_convertor


class SegmentConvertor(StringConvertor):
    """Matches `x` in /designs/x and in /designs/x:export, so that an unknown deed is told as such."""

    regex = "[^/:]+"


register_url_convertor("segment", SegmentConvertor())
