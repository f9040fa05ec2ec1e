"""The physics of gliders with buoyancy cells: a library on its own that knows no web and no database."""
