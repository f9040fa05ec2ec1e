"""Colours that must be told apart are, for each kind of colour blindness, and the page has those of the scene.

Seen as by Machado, Oliveira and Fernandes (2009), "A Physiologically-based Model for Simulation of Color Vision
Deficiency", IEEE TVCG 15(6), table 1 at severity 1.0: matrices on linear RGB. Differences are CIEDE2000 (Sharma, Wu
and Dalal, 2005, Color Research and Application 30(1)), checked against pairs of their table 1.
"""

from __future__ import annotations

import itertools
import re
from pathlib import Path

import numpy as np
import pytest

from studio import palette

SIGHTS = {
    "all cones": np.eye(3),
    "protanopia": ((0.152286, 1.052583, -0.204868), (0.114503, 0.786281, 0.099216), (-0.003882, -0.048116, 1.051998)),
    "deuteranopia": ((0.367322, 0.860646, -0.227968), (0.280085, 0.672501, 0.047413), (-0.011820, 0.042940, 0.968881)),
    "tritanopia": ((1.255528, -0.076749, -0.178779), (-0.078411, 0.930809, 0.147602), (0.004733, 0.691367, 0.303900)),
}
LEAST = 8.0
"""Of CIEDE2000, for which 1 is just seen side by side: lines and arrows are thin, and apart from each other."""

XYZ_FROM_RGB = np.array(
    ((0.4124564, 0.3575761, 0.1804375), (0.2126729, 0.7151522, 0.0721750), (0.0193339, 0.1191920, 0.9503041))
)
"""Of sRGB (IEC 61966-2-1), white D65."""

STATIC = Path(palette.__file__).parents[1] / "static"
TOKENS = (STATIC / "tokens.css").read_text(encoding="utf-8")
DARK, LIGHT = (dict(re.findall(r"--([\w-]+): ([^;]+);", part)) for part in TOKENS.split(':root[data-theme="light"]'))


def page_colors(scheme: str, kind: str) -> list[str]:
    """Return the colours that tokens.css gives to --kind-1 and on in a scheme, found through var()."""
    tokens = DARK | LIGHT if scheme == "light" else DARK
    values = [value for name, value in tokens.items() if re.fullmatch(rf"{kind}-\d", name)]
    return [tokens[value[6:-1]] if value.startswith("var(") else value for value in values]


def linear(color: str) -> np.ndarray:
    share = np.array(palette.rgb(color)) / 255.0
    return np.where(share <= 0.04045, share / 12.92, ((share + 0.055) / 1.055) ** 2.4)


def lab(color: str, sight: str) -> np.ndarray:
    """Return CIE L*a*b* of #rrggbb as somebody sees it."""
    seen = np.clip(np.asarray(SIGHTS[sight]) @ linear(color), 0.0, 1.0)
    share = XYZ_FROM_RGB @ seen / XYZ_FROM_RGB.sum(axis=1)
    f = np.where(share > (6 / 29) ** 3, np.cbrt(share), share / (3 * (6 / 29) ** 2) + 4 / 29)
    return np.array((116 * f[1] - 16, 500 * (f[0] - f[1]), 200 * (f[1] - f[2])))


def difference(one: np.ndarray, other: np.ndarray) -> float:
    """Return CIEDE2000 of two L*a*b* (Sharma et al., 2005, eqs. 2 to 22)."""
    lightness, a, b = np.array((one, other)).T
    mean = np.hypot(a, b).mean()
    a = a * (1.5 - 0.5 * np.sqrt(mean**7 / (mean**7 + 25.0**7)))
    chroma, hue = np.hypot(a, b), np.degrees(np.arctan2(b, a)) % 360
    turn = (hue[1] - hue[0] + 180) % 360 - 180
    middle = np.radians(hue[0] + turn / 2)
    d_hue = 2 * np.sqrt(chroma.prod()) * np.sin(np.radians(turn) / 2)
    light, full = lightness.mean(), chroma.mean()
    t = (
        1
        - 0.17 * np.cos(middle - np.radians(30))
        + 0.24 * np.cos(2 * middle)
        + 0.32 * np.cos(3 * middle + np.radians(6))
        - 0.20 * np.cos(4 * middle - np.radians(63))
    )
    l_term = np.diff(lightness)[0] / (1 + 0.015 * (light - 50) ** 2 / np.sqrt(20 + (light - 50) ** 2))
    c_term = np.diff(chroma)[0] / (1 + 0.045 * full)
    h_term = d_hue / (1 + 0.015 * full * t)
    around = np.radians(60 * np.exp(-(((np.degrees(middle) % 360 - 275) / 25) ** 2)))
    rotation = -2 * np.sqrt(full**7 / (full**7 + 25.0**7)) * np.sin(around)
    return float(np.sqrt(l_term**2 + c_term**2 + h_term**2 + rotation * c_term * h_term))


TOGETHER = {
    "components that move": palette.CELLS,
    "forces and moments": (palette.BUOYANCY, palette.LIFT, palette.DRAG, palette.SIDE, palette.MOMENT),
    "centres": (palette.CENTER_OF_MASS, palette.CENTER_OF_BUOYANCY),
    "kept runs and the present path": (*palette.KEPT, palette.PATH),
    "lines on paper": palette.PLOT_COLORS,
    "kept runs and the present one, light": (*page_colors("light", "kept"), LIGHT["present"]),
    "lines of a plot, dark": page_colors("dark", "series"),
    "lines of a plot, light": page_colors("light", "series"),
}
"""What appears side by side with nothing but its colour to name it."""


@pytest.mark.parametrize(
    ("one", "other", "expected"),
    [
        ((50.0, 2.6772, -79.7751), (50.0, 0.0, -82.7485), 2.0425),
        ((50.0, 2.49, -0.001), (50.0, -2.49, 0.0011), 7.2195),
        ((22.7233, 20.0904, -46.6940), (23.0331, 14.9730, -42.5619), 2.0373),
        ((2.0776, 0.0795, -1.1350), (0.9033, -0.0636, -0.5514), 0.9082),
    ],
)
def test_the_difference_is_that_of_the_published_pairs(one, other, expected):
    assert difference(np.array(one), np.array(other)) == pytest.approx(expected, abs=1e-4)


def test_grey_is_seen_as_grey_by_all():
    for sight in SIGHTS:
        assert np.abs(lab("#808080", sight)[1:]).max() < 0.5, sight


@pytest.mark.parametrize("sight", SIGHTS)
@pytest.mark.parametrize("kind", TOGETHER)
def test_colours_side_by_side_are_told_apart(kind, sight):
    seen = {color: lab(color, sight) for color in TOGETHER[kind]}
    assert len(seen) == len(TOGETHER[kind])
    near = {
        (one, other): round(difference(seen[one], seen[other]), 1)
        for one, other in itertools.combinations(seen, 2)
        if difference(seen[one], seen[other]) < LEAST
    }
    assert near == {}, f"seen with {sight}, closer than {LEAST:g}"


def test_the_page_draws_forces_in_the_colours_of_the_scene():
    forces = {"buoyancy": palette.BUOYANCY, "lift": palette.LIFT, "drag": palette.DRAG, "side": palette.SIDE}
    assert {name: DARK[f"force-{name}"] for name in forces} == forces
    assert not {f"force-{name}" for name in forces} & LIGHT.keys(), "they lie on dark glass in both schemes"


def test_the_page_names_kept_runs_in_the_colours_of_the_scene():
    assert tuple(page_colors("dark", "kept")) == palette.KEPT
    assert DARK["present"] == palette.PATH
