"""Every check of the project in one report: `python -m verify`, or `make verify`. No part of the package."""
