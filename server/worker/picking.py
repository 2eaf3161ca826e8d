"""What is under a point of a picture, by the ids that edits go by."""

from gpu.device_scene.upload import DeviceScene
from gpu.gbuffer.pick import pick
from gpu.scene.parts import LightForm, lights_of, material_ids
from gpu.scene.types import Camera, Scene
from server.scenes.scene_info import MOST_PARTS
from server.wire.browser import PickedPart


def picked_part(scene: Scene, state: DeviceScene, camera: Camera, place: tuple[float, float]) -> PickedPart:
    """What `camera` sees at `place` in [0, 1]² of its picture, from the top left.

    scene: as its file has it, whose ids stay when it is edited; state: that on a device, with its edits.
    """
    lights = lights_of(scene)[:MOST_PARTS]
    picked = pick(state, camera, place)
    if picked is None:
        sky = None if state.scene.sky is None else LightForm.SKY
        return PickedPart(light=next((light.id for light in lights if light.form is sky), None))
    index = int(state.scene.triangle_material[picked.triangle])
    surfaces = {light.index: light.id for light in lights if light.form is LightForm.SURFACE}
    number = -1
    if state.scene.objects:
        number = int(state.scene.vertex_object[state.scene.triangles[picked.triangle, 0]])
    return PickedPart(
        object=state.scene.objects[number] if 0 <= number < MOST_PARTS else None,
        material=material_ids(scene)[index] if index < MOST_PARTS else None,
        light=surfaces.get(index),
        point=picked.point,
        distance=picked.distance,
    )
