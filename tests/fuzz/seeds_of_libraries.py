"""Small sound files of the formats that are XML, packed, or read by libraries, for mutations to start from."""

import io
import tempfile
import zipfile
from importlib.util import find_spec
from pathlib import Path

from dae_file import BOUND, TEXTURE, UVS, dae, effect, geometry, source, use
from fbx_file import FbxFile
from gltf_file import UV, GltfFile
from ifc_file import House
from ktx2_file import ktx2, uastc_block
from step_file import Box, step
from threemf_file import mesh, model, threemf

from tests.fuzz.seed import Seed

# What a format's library is called; these are written in C or C++, and a broken file may end the process.
LIBRARIES = {"ktx2.glb": "opengl_basisu", ".usda": "pxr", ".usdc": "pxr", ".usdz": "pxr"}
LIBRARIES |= {".fbx": "ufbx", ".ifc": "ifcopenshell", ".step": "cascadio"}


def library_of(name: str) -> str:
    """What reads files of that name, where it is not the project itself."""
    return next((library for end, library in LIBRARIES.items() if name.endswith(end)), "")


def more_seeds() -> list[Seed]:
    """All those whose library is installed."""
    with tempfile.TemporaryDirectory() as folder:
        return [*_xml(), *_made_by_libraries(Path(folder))]


def _xml() -> list[Seed]:
    uv_input = '<input semantic="TEXCOORD" source="#g-uv" offset="0" set="0"/>'
    lamp = (
        '<library_lights><light id="l"><technique_common><spot><color>1 1 0</color><falloff_angle>40</falloff_angle>'
        '</spot></technique_common></light></library_lights><library_cameras><camera id="c"><optics><technique_common>'
        "<perspective><yfov>40</yfov><aspect_ratio>1.5</aspect_ratio><znear>0.1</znear></perspective>"
        "</technique_common></optics></camera></library_cameras>"
    )
    phong = (
        '<phong><diffuse><texture texture="t" texcoord="UV"/></diffuse>'
        "<transparency><float>0.5</float></transparency></phong>"
    )
    placed = "<matrix>1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1</matrix><rotate>0 0 1 90</rotate><scale>1 2 1</scale>"
    nodes = [
        f'<node id="n">{placed}{use(bound=BOUND)}<node>{use("h")}</node></node>',
        '<node><translate>0 0 3</translate><instance_light url="#l"/><instance_camera url="#c"/></node>',
    ]
    fans = "<trifans><p>0 1 2 3</p></trifans><polygons><p>0 1 2</p></polygons>"
    document = dae(
        nodes,
        geometry(sources=source("g-uv", UVS, "ST"), inputs=uv_input) + geometry("h", surface=fans),
        lamp
        + effect(phong, TEXTURE)
        + '<library_images><image id="i"><init_from>red.png</init_from></image></library_images>',
    )
    colors = '<m:colorgroup id="2"><m:color color="#FF8000FF"/><m:color color="#00FF00"/></m:colorgroup>'
    base = '<basematerials id="3"><base name="red" displaycolor="#FF0000"/></basematerials>'
    mix = '<m:compositematerials id="4" matid="3" matindices="0"><m:composite values="1"/></m:compositematerials>'
    faces = ('pid="2" p1="0" p2="1" p3="0"', 'pid="3" p1="0"', 'pid="4" p1="0"', "")
    parts = (
        '<object id="5"><components><component objectid="1" transform="1 0 0 0 1 0 0 0 1 5 0 0"/></components></object>'
    )
    start = model(f'{colors}{base}{mix}<object id="1">{mesh(triangles=faces)}</object>{parts}', '<item objectid="5"/>')
    return [
        Seed("scene.dae", document),
        Seed("scene.zae", document, pack=lambda content: _zip("scene.dae", content)),
        Seed("scene.3mf", start.encode(), pack=threemf),
    ]


def _zip(name: str, content: bytes) -> bytes:
    written = io.BytesIO()
    with zipfile.ZipFile(written, "w") as package:
        package.writestr(name, content)
    return written.getvalue()


def _made_by_libraries(folder: Path) -> list[Seed]:
    made = {"ktx2.glb": _ktx2, ".usda": _usd, ".fbx": _fbx, ".ifc": _ifc, ".step": _step}
    return [seed for end, make in made.items() if find_spec(LIBRARIES[end]) for seed in make(folder)]


def _ktx2(folder: Path) -> list[Seed]:
    gltf = GltfFile(folder)
    gltf.json["extensionsUsed"] = ["KHR_texture_basisu"]
    packed = ktx2([[uastc_block(200, 30, 30), uastc_block(0, 255, 0)]], 8, 4)
    gltf.add("images", bufferView=gltf.view(packed), mimeType="image/ktx2")
    gltf.add("textures", extensions={"KHR_texture_basisu": {"source": 0}})
    gltf.add("materials", pbrMetallicRoughness={"baseColorTexture": {"index": 0}})
    gltf.mesh_node(gltf.primitive(material=0, TEXCOORD_0=UV))
    return [Seed("ktx2.glb", gltf.write().read_bytes())]


def _usd(folder: Path) -> list[Seed]:
    from pxr import Sdf, UsdGeom, UsdLux, UsdUtils
    from usd_file import UsdFile

    usd = UsdFile(folder)
    mesh = usd.mesh()
    usd.primvar(mesh, "st", "TexCoord2fArray", "varying", [(0, 0), (1, 0), (1, 1), (0, 1)])
    usd.primvar(mesh, "displayColor", "Color3fArray", "constant", [(1, 0, 0)])
    usd.material(mesh, diffuseColor=(1.0, 0.5, 0.2), roughness=0.5, opacity=0.5)
    usd.mesh("/Root/Inner", counts=[3, 3], indices=[0, 1, 2, 0, 2, 3])
    UsdGeom.Xformable(usd.stage.GetPrimAtPath("/Mesh")).AddTranslateOp().Set((1, 2, 3))
    UsdLux.RectLight.Define(usd.stage, "/Panel").CreateIntensityAttr(5.0)
    UsdLux.SphereLight.Define(usd.stage, "/Bulb")
    UsdLux.DistantLight.Define(usd.stage, "/Sun")
    UsdGeom.Camera.Define(usd.stage, "/View")
    kinds = [Seed(f"scene.{end}", usd.write(f"scene.{end}").read_bytes()) for end in ("usda", "usdc")]
    assert UsdUtils.CreateNewUsdzPackage(Sdf.AssetPath(str(folder / "scene.usda")), str(folder / "scene.usdz"))
    return [*kinds, Seed("scene.usdz", (folder / "scene.usdz").read_bytes())]


def _fbx(folder: Path) -> list[Seed]:
    fbx = FbxFile(folder)
    node = fbx.node("Box", "Mesh", Lcl_Translation=(1.0, 2.0, 3.0), Lcl_Rotation=(0.0, 90.0, 0.0))
    fbx.mesh(node, polygons="0,1,-3,0,2,-4", materials=(0, 0))
    fbx.texture(fbx.material(node, "red", DiffuseColor=(1.0, 0.0, 0.0), Shininess=20.0), "red.png")
    fbx.attribute(fbx.node("Lamp", "Light"), "Light", LightType=2, Intensity=100.0, OuterAngle=40.0)
    fbx.attribute(fbx.node("View", "Camera"), "Camera", FieldOfView=40.0)
    return [Seed("scene.fbx", fbx.write().read_bytes())]


def _ifc(_: Path) -> list[Seed]:
    return [Seed("scene.ifc", House().bytes())]


def _step(_: Path) -> list[Seed]:
    return [Seed("scene.step", step(Box(color=(0.5, 0, 1), transparency=0.5), Box((2, 0, 0), (3, 1, 1))))]
