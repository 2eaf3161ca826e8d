"""The renderer: scenes, virtual point lights and their clusters, and the Warp kernels that run per frame."""
