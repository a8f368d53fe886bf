"""Random small faults in the source, and whether quick tests notice: `python -m verify.mutants` (docs/mutants.md)."""
