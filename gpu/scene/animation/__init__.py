"""What moves in a scene, and the scene at a time."""
