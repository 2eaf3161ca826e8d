"""COLLADA files as text, for tests of their reader."""

from collections.abc import Sequence

QUAD = "0 0 0  100 0 0  100 200 0  0 200 0"
UVS = "0 0  1 0  1 1  0 1"


def source(name: str, numbers: str, columns: str) -> str:
    count, width = len(numbers.split()), len(columns)
    params = "".join(f'<param name="{column}" type="float"/>' for column in columns)
    return (
        f'<source id="{name}"><float_array id="{name}-a" count="{count}">{numbers}</float_array><technique_common>'
        f'<accessor source="#{name}-a" count="{count // width}" stride="{width}">{params}</accessor>'
        "</technique_common></source>"
    )


def geometry(
    name: str = "g", points: str = QUAD, surface: str = "", sources: str = "", inputs: str = "", material: str = "m"
) -> str:
    """One mesh. surface: its elements with indices, one polygon of four corners by default."""
    surface = surface or "<polylist><vcount>4</vcount><p>0 1 2 3</p></polylist>"
    vertex = f'<input semantic="VERTEX" source="#{name}-v" offset="0"/>{inputs}'
    for tag in ("triangles", "polylist", "polygons", "tristrips", "trifans"):
        surface = surface.replace(f"<{tag}>", f'<{tag} material="{material}">{vertex}')
    return (
        f'<geometry id="{name}"><mesh>{source(f"{name}-p", points, "XYZ")}{sources}'
        f'<vertices id="{name}-v"><input semantic="POSITION" source="#{name}-p"/></vertices>{surface}</mesh></geometry>'
    )


def effect(shader: str, params: str = "", extra: str = "") -> str:
    """The material "red" with this shader, in an effect."""
    return (
        f'<library_effects><effect id="e"><profile_COMMON>{params}<technique sid="t">{shader}</technique>{extra}'
        '</profile_COMMON></effect></library_effects><library_materials><material id="red" name="Red">'
        '<instance_effect url="#e"/></material></library_materials>'
    )


TEXTURE = (
    '<newparam sid="s"><surface type="2D"><init_from>i</init_from></surface></newparam>'
    '<newparam sid="t"><sampler2D><source>s</source><wrap_s>CLAMP</wrap_s></sampler2D></newparam>'
)
BOUND = (
    '<bind_material><technique_common><instance_material symbol="m" target="#red">'
    '<bind_vertex_input semantic="UV" input_semantic="TEXCOORD" input_set="0"/></instance_material>'
    "</technique_common></bind_material>"
)


def use(name: str = "g", bound: str = "") -> str:
    return f'<instance_geometry url="#{name}">{bound}</instance_geometry>'


def dae(
    nodes: Sequence[str] = ("<node>" + use() + "</node>",),
    geometries: str = "",
    libraries: str = "",
    asset: str = '<unit name="centimeter" meter="0.01"/><up_axis>Z_UP</up_axis>',
) -> bytes:
    """A whole file, of one quad of 1 m by 2 m by default."""
    return (
        '<?xml version="1.0" encoding="utf-8"?><COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" '
        f'version="1.4.1"><asset>{asset}</asset>{libraries}<library_geometries>{geometries or geometry()}'
        f'</library_geometries><library_visual_scenes><visual_scene id="scene">{"".join(nodes)}</visual_scene>'
        '</library_visual_scenes><scene><instance_visual_scene url="#scene"/></scene></COLLADA>'
    ).encode()
