"""The page around the studio, served as it is: a package so that it is found wherever the program is installed."""
