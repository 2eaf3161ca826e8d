"""3MF packages, for tests of their reader."""

import io
import zipfile
from collections.abc import Mapping

CORE = "http://schemas.microsoft.com/3dmanufacturing/core/2015/02"
EXTENSIONS = (
    'xmlns:m="http://schemas.microsoft.com/3dmanufacturing/material/2015/02" '
    'xmlns:p="http://schemas.microsoft.com/3dmanufacturing/production/2015/06"'
)
RELATIONS = (
    '<Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships"><Relationship '
    'Target="/3D/start.model" Id="r" Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/>'
    "</Relationships>"
)
TETRAHEDRON = ((0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3))


def mesh(size: float = 10.0, triangles: tuple[str, str, str, str] = ("", "", "", "")) -> str:
    """A tetrahedron with legs of `size`; triangles: the further attributes of each."""
    points = [(0, 0, 0), (size, 0, 0), (0, size, 0), (0, 0, size)]
    vertices = "".join(f'<vertex x="{x}" y="{y}" z="{z}"/>' for x, y, z in points)
    faces = "".join(
        f'<triangle v1="{a}" v2="{b}" v3="{c}" {more}/>' for (a, b, c), more in zip(TETRAHEDRON, triangles, strict=True)
    )
    return f"<mesh><vertices>{vertices}</vertices><triangles>{faces}</triangles></mesh>"


def model(resources: str, build: str = '<item objectid="1"/>', unit: str = 'unit="millimeter"') -> str:
    return (
        f'<?xml version="1.0"?><model {unit} xmlns="{CORE}" {EXTENSIONS}><resources>{resources}</resources>'
        f"<build>{build}</build></model>"
    )


def threemf(start: str | bytes, others: Mapping[str, str | bytes] | None = None) -> bytes:
    """A package with the model `start`; others: further files by their names."""
    written = io.BytesIO()
    with zipfile.ZipFile(written, "w", zipfile.ZIP_DEFLATED) as package:
        package.writestr("_rels/.rels", RELATIONS)
        package.writestr("3D/start.model", start)
        for name, content in (others or {}).items():
            package.writestr(name, content)
    return written.getvalue()
