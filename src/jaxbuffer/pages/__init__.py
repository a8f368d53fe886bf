"""Pages for a design review, made of the files that other commands have saved."""
