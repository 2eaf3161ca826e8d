"""Rendering methods: each orders the stages of a frame and does nothing else."""
