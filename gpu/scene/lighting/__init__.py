"""The light of a scene: sky, sun and pictures of them, what a file leaves out, and what never gets out of a shade."""
