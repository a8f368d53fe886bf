"""Many runs: over a grid or any arrays, on all cores, stored as they are done."""
