"""Readers of scene files, a package or module a format, and what several of them need."""
