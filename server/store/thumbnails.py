"""Owns which pictures the store keeps: small PNG files, and SVG that draws and does nothing else."""

from __future__ import annotations

import hashlib
import re
from xml.etree import ElementTree

from models.problems import DesignError, Problem, echo
from server.store.records import Thumbnail

PNG, SVG = "image/png", "image/svg+xml"
LARGEST_THUMBNAIL = 256 * 1024
MOST_PIXELS = 2048
"""Across, and down."""
SVG_NAMESPACE = "{http://www.w3.org/2000/svg}"
DRAWING = frozenset(
    "svg g defs title desc path rect circle ellipse line polyline polygon text tspan linearGradient radialGradient "
    "stop clipPath marker pattern use symbol style".split()
)
"""The elements that a picture may have: none runs, links, embeds or animates."""
ELSEWHERE = re.compile(r"url\s*\((?!\s*['\"]?#)|@import|expression\s*\(|\\", re.IGNORECASE)
"""What fetches in a style; a backslash could hide it."""


def check_thumbnail(media_type: str, content: bytes) -> Thumbnail:
    """Return a picture that is safe to keep and to show; raises `DesignError` where it is not."""
    reason = _png_problem(content) if media_type == PNG else _svg_problem(content)
    if reason is not None:
        raise DesignError([Problem("", f"the thumbnail cannot be kept: {reason}")])
    return Thumbnail(media_type, content, hashlib.sha256(content).hexdigest())


def _png_problem(content: bytes) -> str | None:
    if len(content) < 33 or not content.startswith(b"\x89PNG\r\n\x1a\n") or content[12:16] != b"IHDR":
        return "it is not a PNG file"
    width, height = int.from_bytes(content[16:20], "big"), int.from_bytes(content[20:24], "big")
    if not (0 < width <= MOST_PIXELS and 0 < height <= MOST_PIXELS):
        return f"it has {width} by {height} pixels, and may have {MOST_PIXELS} each way"
    return None


def _svg_problem(content: bytes) -> str | None:
    try:
        written = content.decode("utf-8-sig")
        if "<!DOCTYPE" in written.upper() or "<!ENTITY" in written.upper() or "<?XML-STYLESHEET" in written.upper():
            return "it declares a document type, entities or a style sheet"
        root = ElementTree.fromstring(content)  # bytes: in the encoding that a browser would read it in
    except (UnicodeDecodeError, LookupError, ValueError):
        return "it is not UTF-8"
    except ElementTree.ParseError as error:
        return f"it is not well-formed XML: {error}"
    if root.tag != f"{SVG_NAMESPACE}svg":
        return "its root is not <svg> of the namespace http://www.w3.org/2000/svg"
    return next((found for element in root.iter() if (found := _element_problem(element)) is not None), None)


def _element_problem(element: ElementTree.Element) -> str | None:
    name = element.tag.removeprefix(SVG_NAMESPACE)
    if name not in DRAWING:
        return f"the element {echo(name)} may do more than draw"
    if name == "style" and ELSEWHERE.search(element.text or ""):
        return "a style fetches from elsewhere"
    for attribute, value in element.attrib.items():
        plain = attribute.rpartition("}")[2].lower()
        if plain.startswith("on"):
            return f"the attribute {echo(plain)} runs a script"
        if plain == "href" and not value.strip().startswith("#"):
            return "a link leads out of the picture"
        if ELSEWHERE.search(value):
            return f"the attribute {echo(plain)} fetches from elsewhere"
    return None
