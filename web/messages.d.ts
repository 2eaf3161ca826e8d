// The messages of server/wire/browser.py, written by tests/browser/message_types.py: make changes there.

/** The first message of a viewer. */
export interface Hello {
  type: "hello";
  protocol: 2;
  /** of frames that do not move, width and height [px] */
  size: [number, number];
  /** scene id; None is the served scene */
  scene?: string | null;
  /** how its file is read; None is as the server does */
  scene_options?: ImportOptions | null;
  settings?: RenderSettings;
  stream?: Stream;
  /** that the viewer decodes, the best first */
  codecs?: readonly string[];
}

/** How a file is read. What is None, or empty, is as the file says; where it says nothing, it is guessed. */
export interface ImportOptions {
  /** which axis of the file points up */
  up?: "y" | "z" | null;
  /** what one unit of length in the file is */
  unit?: "m" | "cm" | "mm" | "ft" | "in" | null;
  /** the point "x,y,z" of the file that metres of the scene are counted from; "auto" is its middle */
  origin?: [number, number, number] | "auto" | null;
  /** which of the file's variants is shown */
  variant?: string | null;
  /** which of the file's storeys are shown, comma-separated; all if none */
  storeys?: readonly string[];
}

/** Method and quality of a render. A count that is None is chosen for the device (fewer on a CPU). */
export type RenderSettings = Readonly<Record<string, unknown>>;

/** How a viewer wants its frames sent. */
export interface Stream {
  /** side of frames while moving, as a share of `size`; None: by speed */
  motion_scale?: number | null;
  /** the final frame of a still view is lossless, if the viewer takes png */
  lossless?: boolean;
  /** frames while moving are H.264, if the viewer and the server take it; None: on slow lines */
  video?: boolean | null;
}

/** Where the viewer stands now. */
export interface Pose {
  type: "pose";
  id: number;
  /** camera to world, column-major, rotation and translation only */
  matrix: readonly number[];
  /** vertical field of view [rad] */
  yfov: number;
  /** what is less far in front of the camera is cut away [m] */
  near?: number;
}

/** A change of scene, frame size or render settings; what is None stays. */
export interface Settings {
  type: "settings";
  id: number;
  scene?: string | null;
  /** how its file is read; None: as the server does */
  scene_options?: ImportOptions | null;
  size?: [number, number] | null;
  settings?: RenderSettings | null;
  stream?: Stream | null;
}

/** A change of the scene itself, for all who look at it, or for a viewer that has edits of its own. */
export interface Edit {
  type: "edit";
  id: number;
  patch: ScenePatch;
}

/** A change of what differs from a scene's file, as JSON Merge Patch: null takes an edit back. */
export interface ScenePatch {
  /** seconds into an animation of the scene, which stays at its end; without, as the file poses it */
  time?: number | null;
  /** the animation that the time is of, by its id; without, the first */
  animation?: string | null;
  /** by id */
  lights?: Readonly<Record<string, LightEdit | null>> | null;
  /** by id */
  materials?: Readonly<Record<string, MaterialEdit | null>> | null;
  /** by id */
  objects?: Readonly<Record<string, ObjectEdit | null>> | null;
}

/** What differs of a light; None is as the file says. */
export interface LightEdit {
  /** whether it shines; a sun or a sky that the file has not does if this is true or it has a date */
  on?: boolean | null;
  /** how many times as bright as its file says */
  intensity?: number | null;
  /** of its light; of a sky that is a picture, what tints it */
  color?: [number, number, number] | null;
  /** of a point or spot light, in the world, whose +Y is up [m] */
  position?: [number, number, number] | null;
  /** where the light of a spot or a directional light goes, in the world, of any length */
  direction?: [number, number, number] | null;
  /** of 1900 to 2100; a directional light is the sun at this time, with its zone: it shines from there, unless a direction is given, and as much of it as comes through the air of what does when it is overhead; a sky is that of a clear day then, as bright as the file's when the sun is overhead */
  date?: string | null;
  /** of that sun: latitude and longitude, north and east are positive [°] */
  place?: [number, number] | null;
  /** for that sun: from −Z to the north, clockwise as seen from above [°] */
  north?: number | null;
}

/** What differs of a material; None is as the file says. As in glTF, factors on what its textures say. */
export interface MaterialEdit {
  /** base colour */
  color?: [number, number, number] | null;
  roughness?: number | null;
  metallic?: number | null;
  /** radiance [W/m²/sr], linear Rec. 709 */
  emission?: [number, number, number] | null;
}

/** What differs of an object; None is as the file says. */
export interface ObjectEdit {
  /** whether it is there */
  visible?: boolean | null;
  /** by which it is moved, in the world, within the box of the scene [m] */
  offset?: [number, number, number] | null;
  /** by which it is turned about the world's X, Y and Z through its box's middle [°], Z first */
  rotation?: [number, number, number] | null;
  /** how many times as large it is, about its box's middle, within the box of the scene */
  scale?: number | null;
}

/** Whether this viewer's edits are its own, or those of all. */
export interface Own {
  type: "own";
  /** one of an edit's */
  id: number;
  own: boolean;
  /** those of all become what its own were, which end */
  share?: boolean;
}

/** The viewer has dealt with this frame and all before it. */
export interface Ack {
  type: "ack";
  frame: number;
  age_ms?: number | null;
  decode_ms?: number | null;
  /** it could not be decoded: the next picture of the video needs no other */
  broken?: boolean;
}

/** The answer to hello. */
export interface Welcome {
  type: "welcome";
  protocol: number;
  viewer: number;
  /** of the service: another one has other edits */
  run: string;
  scenes: readonly SceneName[];
  /** JSON schema of `settings` */
  settings_schema: import("./ui/schema.js").JsonSchema;
  /** that frames will come in, the usual one first */
  codecs: readonly ("jpeg" | "png" | "h264")[];
  limits: Limits;
  /** averaged in the final picture of a still view, by quality, if the settings do not say how many */
  still_frames: Readonly<Record<string, number>>;
  /** scenes can be downloaded as GLB files */
  gives_exports: boolean;
  /** lights and materials can be changed */
  takes_edits: boolean;
}

/** A scene that can be chosen. */
export interface SceneName {
  id: string;
  name: string;
  /** comes with the program; else a file of the scenes folder or the served file */
  builtin: boolean;
  /** the one shown when none is named */
  served: boolean;
}

/** What the server takes. */
export interface Limits {
  /** width × height of a streamed frame */
  max_pixels: number;
  max_side: number;
  /** frames that may be unacknowledged at first */
  window: number;
  max_message_bytes: number;
}

/** How many there are of what a user has not counted: gpu.sample_counts says how many times as many as usual. */
export type Quality = "draft" | "balanced" | "best";

/** What is known of a scene once it has been read. */
export interface SceneInfo {
  type: "scene";
  id: string;
  name: string;
  cameras: readonly CameraInfo[];
  bounds: Bounds;
  frame: SceneFrame;
  /** how the file was read */
  options: ImportOptions;
  /** what of the file can be shown: "variant", "storey" */
  choices: Readonly<Record<string, readonly string[]>>;
  /** that can be edited */
  lights: readonly LightInfo[];
  /** that can be edited */
  materials: readonly MaterialInfo[];
  /** that can be edited */
  objects: readonly ObjectInfo[];
  /** of which edits can choose a time */
  animations: readonly AnimationInfo[];
  triangles: number;
  /** what was added, ignored or changed in loading, a sentence each */
  notes: readonly string[];
}

/** A camera of a scene. */
export interface CameraInfo {
  name: string;
  /** camera to world, column-major */
  matrix: readonly number[];
  /** vertical field of view [rad]; of an orthographic camera one that shows as much */
  yfov: number;
  aspect: number;
  orthographic: boolean;
  /** what is less far in front of the camera is cut away [m] */
  near: number;
}

/** The axis-aligned box, in world space, of all but what is small and far away. */
export interface Bounds {
  min: [number, number, number];
  max: [number, number, number];
}

/** Where the file's coordinates are in the world: turn(metres_per_unit · (file − origin)). If +Z is up in the file, the turn takes +Z to +Y and +Y to −Z. */
export interface SceneFrame {
  up: "y" | "z";
  metres_per_unit: number;
  origin: [number, number, number];
}

/** A light of a scene as its file has it. */
export interface LightInfo {
  id: string;
  form: LightForm;
  /** linear Rec. 709, each channel from 0 to 1 */
  color: [number, number, number];
  /** a sun or a sky that the file has not, so that it is off */
  added: boolean;
  /** in the world [m], if it can be moved */
  position: [number, number, number] | null;
  /** where its light goes, if it can be turned */
  direction: [number, number, number] | null;
}

/** What a light is. */
export type LightForm = "point" | "spot" | "directional" | "surface" | "sky";

/** A material of a scene as its file has it: factors on what its textures say. */
export interface MaterialInfo {
  id: string;
  /** linear Rec. 709, each channel from 0 to 1 */
  color: [number, number, number];
  roughness: number;
  metallic: number;
  /** radiance [W/m²/sr] */
  emission: [number, number, number];
}

/** An object of a scene, all meshes of one name, and the box around it in world space, as its file has it. */
export interface ObjectInfo {
  id: string;
  box: Bounds;
}

/** An animation of a scene, and how long it lasts. */
export interface AnimationInfo {
  id: string;
  seconds: number;
}

/** All that differs from a scene's file now. */
export interface Edits {
  type: "edits";
  scene: string;
  edits: SceneEdits;
  /** the newest of this viewer's that was dealt with, 0: none */
  edit: number;
  /** they are this viewer's own, which nobody else sees */
  own: boolean;
  /** where lights shine that are the sun of a date, by id */
  suns: Readonly<Record<string, [number, number, number]>>;
  /** what all saw until `edit`, with which this viewer has shared its own: said once */
  shared_over: SceneEdits | null;
}

/** All that differs from a scene's file, by the ids that gpu.scene.parts and gpu.scene.objects give. What moves with time comes first: an edit of a light or an object is of what is there then. Materials come before lights: an emissive surface shines as its material's emission says, times what its light's edit says. */
export interface SceneEdits {
  /** seconds into an animation of the scene, which stays at its end; without, as the file poses it */
  time: number | null;
  /** the animation that the time is of, by its id; without, the first */
  animation: string | null;
  /** by the light's id */
  lights: Readonly<Record<string, LightEdit>>;
  /** by the material's id */
  materials: Readonly<Record<string, MaterialEdit>>;
  /** by the object's id */
  objects: Readonly<Record<string, ObjectEdit>>;
}

/** What the server is doing for this viewer. */
export interface Status {
  type: "status";
  state: State;
  text: string;
  fraction: number;
}

/** What a viewer can expect now. */
export type State = "loading" | "ready" | "recovering" | "stopping";

/** Why something asked for does not happen. */
export interface ServerError {
  type: "error";
  code: ErrorCode;
  message: string;
  /** of this viewer's that is refused, 0: none */
  edit: number;
}

/** What went wrong, for programs; the message says it for people. */
export type ErrorCode = "bad-message" | "unknown-scene" | "limit" | "scene-failed" | "edit-refused" | "render-failed" | "memory";

/** What a camera sees at one point of its picture, by the ids of the scene; None is what is not there, or not listed. */
export interface PickedPart {
  object: string | null;
  material: string | null;
  /** that shines from there: the surface, or the sky where nothing is */
  light: string | null;
  /** in the world [m] */
  point: readonly number[] | null;
  /** of that from the camera [m] */
  distance: number | null;
}

export type ViewerMessage = Hello | Pose | Settings | Edit | Own | Ack;

export type ServerMessage = Welcome | SceneInfo | Edits | Status | ServerError;
