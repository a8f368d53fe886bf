"""Compiled programs kept on disk, settings of the process, threads."""
