"""The best combination of parts from catalogues, and buildable roundings of a continuous design."""
