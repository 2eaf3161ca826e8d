"""Scenes: from a file or a built-in name (load.py) to plain arrays that a device can take (types.py)."""
