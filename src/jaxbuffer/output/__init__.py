"""Results as records, tables, figures and files."""
