"""A small house as an IFC file, written by IfcOpenShell: two storeys, each with a wall, a window, a slab and a room."""

from typing import Any

SIZE, HEIGHT, THICK = 4000.0, 3000.0, 200.0
WINDOW = (1000.0, 2000.0, 1000.0, 2000.0)
"""The opening in each wall: from and to along it, from and to in height [mm]."""
COLOR, GLASS = (0.8, 0.4, 0.2), (0.5, 0.7, 0.9)
Triple = tuple[float, float, float]


class House:
    """The model, in millimetres, for tests to change. `at`: where the site stands."""

    def __init__(self, schema: str = "IFC4", at: Triple = (0.0, 0.0, 0.0)) -> None:
        import ifcopenshell

        self.model = ifcopenshell.file(schema=schema)
        units = [
            self.make("IfcSIUnit", UnitType="LENGTHUNIT", Prefix="MILLI", Name="METRE"),
            self.make("IfcSIUnit", UnitType="PLANEANGLEUNIT", Name="RADIAN"),
        ]
        self.context = self.make(
            "IfcGeometricRepresentationContext",
            ContextType="Model",
            CoordinateSpaceDimension=3,
            Precision=1e-5,
            WorldCoordinateSystem=self._axes(),
        )
        self.project = self.rooted("IfcProject", "project", RepresentationContexts=[self.context])
        self.project.UnitsInContext = self.make("IfcUnitAssignment", Units=units)
        self.site = self.rooted("IfcSite", "site", CompositionType="ELEMENT")
        self.site.ObjectPlacement = self.make("IfcLocalPlacement", RelativePlacement=self._axes(at))
        self.building = self.rooted("IfcBuilding", "building", CompositionType="ELEMENT")
        self.aggregate(self.project, self.site)
        self.aggregate(self.site, self.building)
        self.plaster = self.style("plaster", COLOR)
        self.glass = self.style("glass", GLASS, Transparency=0.75)
        self.storeys = [self._storey(number) for number in range(2)]

    def _storey(self, number: int) -> Any:
        low = HEIGHT * number
        storey = self.rooted("IfcBuildingStorey", f"level {number}", CompositionType="ELEMENT", Elevation=low)
        self.aggregate(self.building, storey)
        wall = self.block("IfcWall", (SIZE, THICK, HEIGHT), (0.0, 0.0, low), self.plaster)
        left, right, bottom, top = WINDOW
        size = (right - left, THICK, top - bottom)
        opening = self.block("IfcOpeningElement", size, (left, 0.0, low + bottom))
        pane = self.block("IfcWindow", (size[0], 20.0, size[2]), (left, 90.0, low + bottom), self.glass)
        self.rooted("IfcRelVoidsElement", RelatingBuildingElement=wall, RelatedOpeningElement=opening)
        self.rooted("IfcRelFillsElement", RelatingOpeningElement=opening, RelatedBuildingElement=pane)
        slab = self.block("IfcSlab", (SIZE, SIZE, THICK), (0.0, 0.0, low - THICK))
        room = self.block("IfcSpace", (SIZE, SIZE, HEIGHT), (0.0, 0.0, low))
        self.aggregate(storey, room)
        self.rooted("IfcRelContainedInSpatialStructure", RelatingStructure=storey, RelatedElements=[wall, slab])
        return storey

    def make(self, kind: str, *values: Any, **attributes: Any) -> Any:
        return self.model.create_entity(kind, *values, **attributes)

    def rooted(self, kind: str, name: str | None = None, **attributes: Any) -> Any:
        """An entity with a GlobalId."""
        import ifcopenshell.guid

        return self.make(kind, GlobalId=ifcopenshell.guid.new(), Name=name, **attributes)

    def aggregate(self, whole: Any, part: Any) -> None:
        self.rooted("IfcRelAggregates", RelatingObject=whole, RelatedObjects=[part])

    def block(self, kind: str, size: Triple, low: Triple, style: Any = None) -> Any:
        """A product of a `kind`: a box of `size` from `low` up."""
        middle = self.make("IfcAxis2Placement2D", self.make("IfcCartesianPoint", (size[0] / 2, size[1] / 2)))
        profile = self.make("IfcRectangleProfileDef", "AREA", None, middle, size[0], size[1])
        return self.extruded(kind, profile, size[2], low, style)

    def extruded(self, kind: str, profile: Any, depth: float, low: Triple, style: Any = None) -> Any:
        upwards = self.make("IfcDirection", (0.0, 0.0, 1.0))
        solid = self.make("IfcExtrudedAreaSolid", profile, self._axes(), upwards, depth)
        if style is not None:
            if self.model.schema == "IFC2X3":
                style = self.make("IfcPresentationStyleAssignment", [style])
            self.make("IfcStyledItem", solid, [style])
        return self.product(kind, solid, "SweptSolid", low)

    def product(self, kind: str, item: Any, form: str, low: Triple = (0.0, 0.0, 0.0), identifier: str = "Body") -> Any:
        shape = self.make("IfcShapeRepresentation", self.context, identifier, form, [item])
        product = self.rooted(kind)
        product.Representation = self.make("IfcProductDefinitionShape", Representations=[shape])
        product.ObjectPlacement = self.make("IfcLocalPlacement", self.site.ObjectPlacement, self._axes(low))
        return product

    def style(self, name: str, color: Triple, **rendering: Any) -> Any:
        """A surface style, with an IfcSurfaceStyleRendering of these attributes."""
        rgb = self.make("IfcColourRgb", None, *color)
        method = rendering.pop("ReflectanceMethod", "NOTDEFINED")
        item = self.make("IfcSurfaceStyleRendering", SurfaceColour=rgb, ReflectanceMethod=method, **rendering)
        return self.make("IfcSurfaceStyle", name, "BOTH", [item])

    def bytes(self) -> bytes:
        return str(self.model.to_string()).encode()

    def _axes(self, at: Triple = (0.0, 0.0, 0.0)) -> Any:
        return self.make("IfcAxis2Placement3D", self.make("IfcCartesianPoint", at))
