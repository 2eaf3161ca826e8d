"""A USD stage of layers from the scene's folder alone: what refers elsewhere is refused, what is missing left out."""

import os
import zipfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path, PureWindowsPath
from typing import Any

from pxr import Ar, Sdf, Tf, Usd, UsdUtils

from gpu.errors import SceneError
from gpu.scene.formats.files import confined_file, file_beside, read_bytes
from gpu.scene.formats.package import entry_name
from gpu.scene.formats.usd.layers import LAYERS
from gpu.scene.limits import SceneLimits
from gpu.scene.remarks import Remarks
from gpu.scene.validate import check_count


@dataclass(frozen=True)
class Stage:
    """An opened file. usd: its Usd.Stage; time: the time code at which all is read; remarks: for the report."""

    path: Path
    limits: SceneLimits
    usd: Any
    time: Any
    remarks: Remarks = field(default_factory=Remarks)

    def content(self, attribute: Any) -> tuple[str, bytes] | None:
        """Identifier and bytes of the file that an asset-valued `attribute` names; None, and said, if it is missing.

        Of an absolute path, as of another machine, the end is looked for beside the scene. Raises SceneError when it is
        outside the scene's folder.
        """
        value = attribute.Get(self.time)
        if value is None or not value.path:
            return None
        place = str(attribute.GetPath())
        if PureWindowsPath(value.path).anchor or value.path.lower().startswith("file:"):
            beside = file_beside(self.path, value.path, place, self.remarks)
            found = None if beside is None else str(beside)
        else:
            found = _located(self.path, attribute.GetPropertyStack(self.time)[0].layer, value.path, place)
        if found is None:
            self.remarks.add("a file that the scene refers to is missing and was left out", value.path)
            return None
        outer, inner = Ar.SplitPackageRelativePathOuter(found)
        return found, _packed(Path(outer), inner, self.limits) if inner else read_bytes(Path(outer), self.limits)


def open_stage(path: Path, limits: SceneLimits) -> Stage:
    """The stage of the file at `path`.

    Raises SceneError when a layer is too large or outside its folder, and the errors of USD (see `refusing`).
    """
    remarks = Remarks()
    _sized(path, limits)
    root = _opened(path, str(path.parent.resolve() / path.name))
    layers = _confined_layers(path, root, limits, remarks)
    diagnostics = UsdUtils.CoalescingDiagnosticDelegate()  # also keeps warnings off the console
    usd = Usd.Stage.Open(root)
    for problem in diagnostics.TakeUncoalescedDiagnostics():
        remarks.add("USD cannot compose a part of the scene", _brief(path, problem.commentary))
    del layers  # which were kept open, as they were changed, until the stage had them
    if usd.HasAuthoredTimeCodeRange() and usd.GetStartTimeCode() < usd.GetEndTimeCode():
        remarks.add("animations are not played; the scene is shown at its first time")
    # Clips would bring in further layers for all times but the default one.
    clips = any(prim.HasAuthoredMetadata("clips") for prim in Usd.PrimRange.AllPrims(usd.GetPseudoRoot()))
    time = Usd.TimeCode.Default() if clips else Usd.TimeCode(usd.GetStartTimeCode())
    return Stage(path, limits, usd, time, remarks)


def _confined_layers(path: Path, root: Any, limits: SceneLimits, remarks: Remarks) -> list[Any]:
    """`root` and all layers that it refers to, in every variant, without references to what is not there."""
    layers, seen = [root], {root.identifier}
    for layer in layers:
        for asset in filter(None, layer.GetCompositionAssetDependencies()):  # an empty one is this layer itself
            found = _located(path, layer, asset, "layers")
            if found and Path(found.rstrip("]")).suffix.lower() not in LAYERS:
                remarks.add("a layer that is no USD file was left out", asset)
                found = None
            elif not found:
                remarks.add("a layer that the scene refers to is missing and was left out", asset)
            # An absolute path is not searched for elsewhere.
            layer.UpdateCompositionAssetDependency(asset, found or "")
            if found and found not in seen:
                seen.add(found)
                _sized(Path(Ar.SplitPackageRelativePathOuter(found)[0]), limits)
                layers.append(_opened(path, found))
    return layers


def _opened(path: Path, identifier: str) -> Any:
    """The layer of the scene at `path` with that identifier. Raises SceneError when it is broken."""
    layer = Sdf.Layer.FindOrOpen(identifier)
    if layer is None:
        raise SceneError(str(path), "", f"{Path(identifier).name} is not a USD file that can be read")
    return layer


def _located(scene: Path, layer: Any, asset: str, field: str) -> str | None:
    """The identifier of what `layer` calls `asset`; None when it does not exist.

    Raises SceneError when it is outside the folder of `scene`.
    """
    if asset.startswith("`"):  # an expression, which only composition evaluates
        return None
    folder = scene.parent.resolve()
    identifier = layer.ComputeAbsolutePath(asset)
    outer, inner = Ar.SplitPackageRelativePathOuter(identifier)
    outer = str(folder / outer)  # which an absolute path replaces
    file = confined_file(scene, os.path.relpath(outer, folder), field)
    if file is None or (inner and inner not in _entries(file)):
        return None
    return Ar.JoinPackageRelativePath(str(file), inner) if inner else str(file)  # which may differ in case


def _entries(package: Path) -> dict[str, zipfile.ZipInfo]:
    try:
        with zipfile.ZipFile(package) as opened:
            return {entry_name(entry): entry for entry in opened.infolist()}
    except (OSError, zipfile.BadZipFile):
        return {}


def _packed(package: Path, name: str, limits: SceneLimits) -> bytes:
    """The file `name` of a USDZ package. Raises SceneError when it cannot be read or is too large."""
    try:
        entry = _entries(package)[name]
        check_count(f"{package}: {name}", "bytes", entry.file_size, limits.max_file_bytes, "max_file_bytes")
        with zipfile.ZipFile(package) as opened:
            return opened.read(entry)
    except (OSError, KeyError, RuntimeError, NotImplementedError, zipfile.BadZipFile) as error:
        raise SceneError(str(package), name, f"cannot be unpacked: {error}") from error


def _sized(path: Path, limits: SceneLimits) -> None:
    """Raise SceneError when there is no file at `path` or it is larger than allowed."""
    try:
        check_count(str(path), "bytes", path.stat().st_size, limits.max_file_bytes, "max_file_bytes")
    except OSError as error:
        raise SceneError(str(path), "", f"cannot be read: {error.strerror}") from error


@contextmanager
def refusing(path: Path) -> Iterator[None]:
    """Errors of USD as SceneError of `path`, and those of Python with what is no text, be it in USD's words, or is of
    another type than USD's schemas say.
    """
    try:
        try:
            yield
        except Tf.ErrorException as error:
            problem = str(error).partition(" : ")[2].strip(" '\n")
            raise SceneError(str(path), "", f"not a USD file that can be read: {_brief(path, problem)}") from error
    except UnicodeDecodeError as error:
        raise SceneError(str(path), "", "not a USD file that can be read: it has text that is not UTF-8") from error
    except (TypeError, ValueError, OverflowError) as error:
        raise SceneError(str(path), "", f"it has a value of another type than it should: {str(error)[:200]}") from error


def _brief(path: Path, problem: str) -> str:
    """What USD says of a problem, without where the scene at `path` is kept."""
    return problem.partition("\n")[0].partition(" (instantiating")[0].replace(f"{path.parent.resolve()}/", "")[:200]
