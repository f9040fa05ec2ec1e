"""Benchmarks: they print figures and ratios measured side by side."""

import os

# matrices here are small: threads of the linear algebra library would only spin, and wait for other programs
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
