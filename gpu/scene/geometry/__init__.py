"""Triangles on the host: boxes, normals, polygons, the few rays that defaults need."""
