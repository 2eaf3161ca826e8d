"""What a COLLADA file has and this reader does not use, for the scene's report."""

from gpu.scene.formats.collada.document import Document

# Libraries that are read, or whose content only matters through what uses it.
_READ = {"geometries", "controllers", "lights", "cameras", "images", "effects", "materials", "nodes", "visual_scenes"}
_SHAPES = ("convex_mesh", "spline", "brep")


def say_unread(document: Document) -> None:
    """Say what is not shown, with counts."""
    remarks, root = document.remarks, document.root
    remarks.add_count(
        "animations are not played; the scene is shown without them", len(root.findall("library_animations/animation"))
    )
    for library in root:
        kind = library.tag.removeprefix("library_")
        entries = [child for child in library if child.tag not in ("asset", "extra")]
        if library.tag.startswith("library_") and kind not in _READ | {"animations", "animation_clips"}:
            remarks.add_count(f"{kind.replace('_', ' ')} are not used", len(entries))
    for shape in _SHAPES:
        remarks.add_count(
            f"geometries of kind {shape} are not shown", len(root.findall(f"library_geometries/geometry/{shape}"))
        )
    lines = [len(root.findall(f"library_geometries/geometry/mesh/{kind}")) for kind in ("lines", "linestrips")]
    remarks.add_count("groups of lines are not shown", sum(lines))
    scenes = len(root.findall("library_visual_scenes/visual_scene"))
    remarks.add_count("visual scenes other than the shown one were left out", scenes - 1)
