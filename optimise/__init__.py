"""Studies of the buffer: a TOML and a short script each; ``python -m optimise`` runs them (see README.md here)."""
