"""Where on Earth an IFC model stands, told but not applied: coordinates stay the file's own."""

from math import atan2, degrees
from typing import Any

from gpu.scene.formats.ifc.unshown import entities


def georeference(model: Any) -> list[str]:
    """Sentences on the map coordinates of the file's origin, and on the latitude and longitude of its sites."""
    notes = [_conversion(_attributes(it)) for it in entities(model, "IfcCoordinateOperation")]
    for properties in entities(model, "IfcPropertySet"):  # how IFC2X3 files say it
        if str(properties.Name).lower() == "epset_mapconversion":
            values = {it.Name: getattr(it.NominalValue, "wrappedValue", None) for it in properties.HasProperties or ()}
            notes.append(_conversion(values))
    for site in entities(model, "IfcSite"):
        if site.RefLatitude and site.RefLongitude:
            latitude, longitude = _angle(site.RefLatitude), _angle(site.RefLongitude)
            height = f", elevation {site.RefElevation:g} in its unit" if site.RefElevation else ""
            notes.append(
                f"the site {site.Name or site.GlobalId} is at latitude {latitude}, longitude {longitude}{height}"
            )
    return notes


def _attributes(conversion: Any) -> dict[str, Any]:
    return {"CRS": getattr(conversion.TargetCRS, "Name", None), **conversion.get_info(recursive=False)}


def _conversion(values: dict[str, Any]) -> str:
    """A sentence on an IfcMapConversion or IfcRigidOperation (IFC 4.3, 8.18.3)."""
    east = values.get("Eastings", values.get("FirstCoordinate"))
    north = values.get("Northings", values.get("SecondCoordinate"))
    height = values.get("OrthogonalHeight", values.get("Height"))
    angle = degrees(atan2(_number(values.get("XAxisOrdinate")), _number(values.get("XAxisAbscissa"), 1.0)))
    turned = f", its x axis turned {angle:.6g}° from east to north" if angle else ""
    scaled = f", scaled by {scale:.9g}" if (scale := _number(values.get("Scale"), 1.0)) != 1.0 else ""
    place = f"easting {_number(east):.12g}, northing {_number(north):.12g}, height {_number(height):.12g}"
    return f"the file's origin is at {place} of {values.get('CRS') or 'an unnamed map'}{turned}{scaled}"


def _number(value: Any, otherwise: float = 0.0) -> float:
    """`value`, or the number that IFC measures wrap, as a float."""
    value = getattr(value, "wrappedValue", value)
    return float(value) if isinstance(value, int | float) else otherwise


def _angle(parts: tuple[int, ...]) -> str:
    """Degrees, minutes, seconds and millionths, all of one sign, as decimal degrees (IfcCompoundPlaneAngleMeasure)."""
    units = (1.0, 60.0, 3600.0, 3.6e9)
    return f"{sum(part / unit for part, unit in zip(parts, units, strict=False)):.7g}°"
