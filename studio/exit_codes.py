"""Owns what the command line's exit codes mean."""

DONE, REFUSED, MISUSED, UNUSABLE, STOPPED, PARTIAL = range(6)
MEANING = (
    "exit codes: 0 done; 1 the design is refused, or there is no such motion or controller; 2 the command line is "
    "wrong; 3 a file or the port cannot be used; 4 the run failed or was cancelled, what it computed is kept; "
    "5 some cases of a batch failed, all are kept"
)
