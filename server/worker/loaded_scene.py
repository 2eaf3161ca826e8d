"""A scene on the device, with its lights."""

from dataclasses import dataclass, field, replace

import warp as wp

from gpu.core.kernel_loading import LateKernels
from gpu.core.sharing import DEVICE_SHARING
from gpu.core.stages import new_number
from gpu.device_scene.features import SceneFeatures
from gpu.device_scene.upload import DeviceScene
from gpu.scene.edits import NO_EDITS, SceneEdits, shape_of, shaped, shown, with_triangles_of
from gpu.scene.types import Scene
from gpu.vpl.light_sets import LightSets
from server.wire.worker import SceneRef


@dataclass(eq=False)
class LoadedScene:
    """A scene in one state, with `edits` or as its file is, and what all renderers of that share.

    shape: with the edits of its geometry alone; number: of its arrays alone, which may become those of another state;
    late: its own kernels, while general ones show it.
    """

    ref: SceneRef
    scene: Scene
    device_scene: DeviceScene
    light_sets: LightSets
    shape: Scene
    edits: SceneEdits = NO_EDITS
    number: int = field(default_factory=new_number)
    late: LateKernels | None = None

    def features(self, *, lambertian: bool) -> SceneFeatures:
        """What it has (gpu.device_scene.features), whatever its state, looked for once."""
        return self.device_scene.features(lambertian=lambertian)


def build(ref: SceneRef, scene: Scene, device: wp.Device) -> LoadedScene:
    """Put a scene on the device; its lights are traced when the first renderer wants them."""
    device_scene = DeviceScene(scene, str(device))
    return LoadedScene(ref, scene, device_scene, LightSets(device_scene), scene)


def with_kernels(loaded: LoadedScene, late: LateKernels | None) -> LoadedScene:
    """A scene in its state, for other renderers: by general kernels while its own are `late`, else by those."""
    device_scene = loaded.device_scene.generalised(general=late is not None)
    return replace(loaded, device_scene=device_scene, light_sets=LightSets(device_scene), number=new_number(),
                   late=late)  # fmt: skip


def edit(loaded: LoadedScene, edits: SceneEdits, before: LoadedScene | None = None) -> LoadedScene:
    """The scene of `loaded`, which has none, with `edits`; both share geometry. UserError for what it has not.

    before: with other edits, which nobody needs any more: becomes what is wanted where its arrays are as large and
    kernels need to know no more, so that its renderers go on.
    """
    if before is not None and shape_of(before.edits) == shape_of(edits):
        shape = before.shape
    else:
        shape = shaped(loaded.scene, edits, DEVICE_SHARING.pause)
        shape = shape if before is None else with_triangles_of(before.shape, shape)
    scene = shown(shape, edits)
    goes_on = before is not None and before.shape.triangles is shape.triangles
    lender = before if before is not None and goes_on else loaded
    device_scene = lender.device_scene.edited(scene, in_place=goes_on)
    if before is not None and before.light_sets.follow(device_scene):
        before.scene, before.shape, before.edits = scene, shape, edits
        return before
    return LoadedScene(loaded.ref, scene, device_scene, LightSets(device_scene), shape, edits)
