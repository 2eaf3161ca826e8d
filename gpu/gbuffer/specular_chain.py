"""Specular chains: what the camera sees in mirrors and through clear glass (the 2009 paper, section 3.1).

A camera ray that meets a perfect mirror or clear glass goes on to the first surface that is neither, where the shading
point is. At glass it is reflected or goes through by chance, as Fresnel's law says, or takes the likelier of both; at
the first glass there may be two chains, one by each, and so there may at surfaces that are there in part
(gpu.gbuffer.veils). Chains that are drawn may go on in specular lobes and frosted
glass, too, by a direction of these.
"""

from dataclasses import dataclass

import warp as wp

from gpu.core.image_size import ImageSize
from gpu.core.morton import morton_2d
from gpu.device_scene.bsdf import BsdfSample, is_followed, largest, sample_lobe, specular_share
from gpu.device_scene.data import HALF, NO_HIT, SceneData
from gpu.device_scene.dispersion import ALL_COLOURS, disperses, drawn_channel, of_channel, refracting
from gpu.device_scene.glass import attenuated, glass_fresnel
from gpu.device_scene.offsets import OFFSET_ULP, offset_origin
from gpu.device_scene.panes import TintedHit, meet, met_surface
from gpu.device_scene.part_glass import part_at
from gpu.device_scene.rays import seen_hit
from gpu.device_scene.scattering import choose_part, coat_share, is_perfect, part_of, sample_scattering
from gpu.device_scene.sides import ray_coverage
from gpu.device_scene.surface import Surface, surface_at
from gpu.gbuffer.camera_rays import CameraRay
from gpu.gbuffer.veils import past_veil
from gpu.lights.background import background
from gpu.sampling.sobol import hashed, sobol_pair_at


@dataclass(frozen=True)
class ChainParameters:
    """vertices: specular surfaces of a chain at most. What comes after them is seen straight through any more glass:
    what is reflected within that again and again has lost little light, so that black would be worse. most_followed:
    the share of chains that go on in a specular lobe at most; the others find direct light in it. Compiled in.
    """

    vertices: int = 8
    most_followed: float = 0.5


CHAIN_PARAMETERS = ChainParameters()
CHAIN_VERTICES = wp.constant(CHAIN_PARAMETERS.vertices)
# The sequences of `sobol_pair_at` that chains take, beside those of direct light.
CHAIN_PAIR = wp.constant(16)
DIRECTION_PAIR = wp.constant(16 + CHAIN_PARAMETERS.vertices + 1)
# The frame index of chains that are not drawn.
LIKELIER = -1


@wp.struct
class ChainSamples:
    """How chains choose.

    frame_index (1,): the number of a frame among those that complement each other, whose chains are drawn; LIKELIER,
    below zero: they take the likelier branch, of which two frames alike show the same. seed: of what is drawn. splits:
    where they are not drawn, the first glass or veil shows both branches, each by its share: the likelier, and the
    other in a chain of its own (gpu.indirect.other_branch). lobes: they are drawn, and go on in specular lobes, at
    clear coats and through frosted glass, too.
    """

    frame_index: wp.array[int]
    seed: int
    splits: bool
    lobes: bool


def chain_samples(device: wp.Device, frame_index: int = LIKELIER, seed: int = 0) -> ChainSamples:
    """The struct of these, on a device."""
    samples = ChainSamples()
    samples.seed = seed
    samples.frame_index = wp.full(1, frame_index, dtype=int, device=device)
    return samples


@wp.struct
class ChainEnd:
    """What a pixel's ray sees in the end.

    face: the triangle there, NO_HIT where there is none; surface: of it; to_viewer: unit direction that it is seen
    from; throughput: share of its light that comes back; emitted: light of emitters and the sky that does, those on
    the way too [W/m²/sr]; length: of all segments.
    """

    face: int
    surface: Surface
    to_viewer: wp.vec3
    throughput: wp.vec3
    emitted: wp.vec3
    length: float


@wp.func
def straight_end(scene: SceneData, ray: CameraRay) -> ChainEnd:
    """The first surface along a camera's ray, in a scene without specular ones and veils."""
    end = ChainEnd()
    hit = seen_hit(scene, ray.origin, ray.direction)
    end.face = hit.face
    end.to_viewer = -ray.direction
    end.throughput = wp.vec3(1.0, 1.0, 1.0)
    end.length = hit.t
    if hit.face == NO_HIT:
        end.emitted = background(scene, ray.origin, ray.direction)
    else:
        end.surface = surface_at(scene, hit, ray.direction)
        end.emitted = end.surface.emission
    return end


@wp.func
def chain_choice(samples: ChainSamples, place: int, vertex: int) -> float:
    """The number in [0, 1) by which a chain chooses at a vertex; at one half it takes what is likelier."""
    if samples.frame_index[0] < 0:
        return 0.5
    return sobol_pair_at(place, samples.frame_index[0], CHAIN_PAIR + vertex, samples.seed).x


@wp.func
def chain_channel(samples: ChainSamples, place: int) -> int:
    """The colour in which a drawn chain goes on through glass that disperses light."""
    return drawn_channel(sobol_pair_at(place, samples.frame_index[0], CHAIN_PAIR, samples.seed).y)


@wp.func
def followed_share(surface: Surface, view: wp.vec3) -> float:
    """The share of chains that go on in the specular lobe of `surface`, 0 where none do."""
    if not is_followed(surface):
        return 0.0
    return wp.min(specular_share(surface, view), wp.static(CHAIN_PARAMETERS.most_followed))


@wp.func
def has_coat_apart(surface: Surface) -> bool:
    """Whether drawn chains end at no coat of `surface`, but at what is below, where the coat has direct light, too
    (gpu.indirect.clear_coat).
    """
    return surface.coat > 0.0 and surface.glass == 0.0 and not surface.mirror


@wp.struct
class CoatChoice:
    """The number by which a chain chooses a part of a surface, and what that counts over how often it is chosen."""

    value: float
    weight: float


@wp.func
def coat_choice(surface: Surface, view: wp.vec3, value: float) -> CoatChoice:
    """That of a uniform `value` in [0, 1). Chains go on from a coat more often than light does: what it reflects of
    bright things would leave fireflies.
    """
    choice = CoatChoice()
    share = coat_share(surface, view)
    chance = wp.max(share, wp.min(wp.sqrt(share), wp.static(CHAIN_PARAMETERS.most_followed)))
    if value < chance:
        choice.value = value * (share / chance)
        choice.weight = share / chance
    else:
        choice.weight = (1.0 - share) / (1.0 - chance)
        choice.value = share + (value - chance) * choice.weight
    return choice


@wp.struct
class FirstBranch:
    """Reflection or refraction at the first glass: the `share` of light by it, and the number that chooses it."""

    share: float
    rest: float


@wp.func
def first_branch(part: Surface, to_viewer: wp.vec3, rest: float, other: bool) -> FirstBranch:
    """The branch that `rest` chooses at glass, or the other one."""
    share = glass_fresnel(part, wp.dot(part.normal, to_viewer))
    crosses = rest >= share
    branch = FirstBranch()
    branch.rest = rest
    if other:
        crosses = not crosses
        branch.rest = wp.where(crosses, 1.0, 0.0)
    branch.share = wp.where(crosses, 1.0 - share, share)
    return branch


@wp.func
def onward(part: Surface, to_viewer: wp.vec3, rest: float, follows: bool, drawn: wp.vec2) -> BsdfSample:
    """Where a chain goes on from `part`, by its specular lobe if it `follows` that; without weight it goes nowhere."""
    if follows:
        return sample_lobe(part, to_viewer, drawn[0], drawn[1])
    sample = sample_scattering(part, to_viewer, rest, drawn[0], drawn[1])
    if largest(sample.weight) <= 0.0 and is_perfect(part):
        # Where a bent normal sends light through the surface that reflects it, or back, the true one does not.
        part.normal = part.geometric_normal
        sample = sample_scattering(part, to_viewer, rest, 0.5, 0.5)
    return sample


@wp.struct
class ChainStep:
    """What a chain does at a surface: whether it `goes_on` from the chosen `part` of it, a coat or not, and `follows`
    the specular lobe of that; rest: what is left of the number that chose the part, uniform in [0, 1) again;
    throughput: of the chain, with how seldom what it does is chosen.
    """

    part: Surface
    coat: bool
    rest: float
    goes_on: bool
    follows: bool
    throughput: wp.vec3


@wp.func
def chain_step(surface: Surface, view: wp.vec3, value: float, throughput: wp.vec3, crosses: bool,
               follows_lobes: bool) -> ChainStep:  # fmt: skip
    """The step of a chain of so much `throughput`, chosen by a `value` in [0, 1).

    crosses: it goes through glass whatever the value; follows_lobes: it may go on in lobes and through frosted glass.
    """
    step = ChainStep()
    step.throughput = throughput
    apart = has_coat_apart(surface)
    if apart:
        choice = coat_choice(surface, view, value)
        value = choice.value
        step.throughput = step.throughput * choice.weight
    chosen = choose_part(surface, view, value)
    if crosses:
        chosen.glass = 1.0
        chosen.rest = 0.0
    step.coat = chosen.coat
    step.rest = chosen.rest
    step.part = part_of(surface, chosen)
    step.goes_on = is_perfect(step.part)
    if follows_lobes and not step.goes_on:
        step.follows = chosen.coat and apart
        step.goes_on = step.part.glass > 0.0 or step.follows
        share = float(0.0)
        if not step.goes_on:
            share = followed_share(step.part, view)
        if share > 0.0:
            step.follows = chosen.rest < share
            step.goes_on = step.follows
            step.throughput = step.throughput / wp.where(step.follows, share, 1.0 - share)
    return step


@wp.struct
class BranchHit:
    """What a chain meets, and whether it still `splits`: the first glass or veil was neither here nor before."""

    met: TintedHit
    splits: bool


@wp.func
def meet_in_branch(scene: SceneData, origin: wp.vec3, direction: wp.vec3, culls: bool, splits: bool,
                   other: bool) -> BranchHit:  # fmt: skip
    """What one of both branches of a chain, which `splits` yet or not, meets along a ray; other: as of `seen_end`."""
    found = BranchHit()
    found.met = meet(scene, origin, direction, culls)
    found.splits = splits
    if scene.sheer and splits:
        past = past_veil(scene, origin, direction, found.met, culls, other)
        found.met = past.met
        found.splits = not past.veiled
    return found


@wp.func
def seen_end(scene: SceneData, ray: CameraRay, pixel: int, image: ImageSize, samples: ChainSamples,
             other: bool) -> ChainEnd:  # fmt: skip
    """Where the camera's ray of `pixel` ends after any mirrors, clear glass and veils. Drawn chains with lobes go on
    from a clear coat or end below, by chance; over a mirror or glass they may end at it. To others coats are nothing.

    other: by the branch that the first glass or veil leaves out, if samples split; nothing is seen there if there is
    none.
    """
    if not (scene.specular or scene.blended):
        return straight_end(scene, ray)
    place = morton_2d(pixel % image.width, pixel // image.width)
    end = ChainEnd()
    end.face = NO_HIT
    end.throughput = wp.vec3(1.0, 1.0, 1.0)
    absorption = wp.vec3(0.0, 0.0, 0.0)
    origin = ray.origin
    direction = ray.direction
    culls = scene.one_sided
    splits = samples.splits and samples.frame_index[0] < 0
    shows = bool(True)
    channel = int(ALL_COLOURS)
    scene.coverage = HALF
    for vertex in range(CHAIN_VERTICES + 1):
        if samples.frame_index[0] >= 0:
            seed = int(hashed(wp.uint32(samples.seed))) ^ samples.frame_index[0]
            scene.coverage = ray_coverage(place, vertex, seed)
        if vertex == CHAIN_VERTICES:
            scene.pane_count = 0
            shows = False
        branch_hit = meet_in_branch(scene, origin, direction, culls, splits, other)
        met = branch_hit.met
        splits = branch_hit.splits
        end.to_viewer = -direction
        end.throughput = wp.cw_mul(end.throughput, met.tint)
        if met.hit.face == NO_HIT:
            if other and splits:
                return end
            if shows:
                end.emitted += wp.cw_mul(end.throughput, background(scene, origin, direction))
            return end
        end.throughput = wp.cw_mul(end.throughput, attenuated(absorption, met.hit.t))
        end.length += met.hit.t
        if scene.blended and splits:
            seen = part_at(scene, met.hit, direction)
            if seen.there < 1.0:
                splits = False
                shown = wp.vec3(1.0, 1.0, 1.0) * seen.there
                end.throughput = wp.cw_mul(end.throughput, wp.where(other, seen.passes, shown))
                if other:
                    origin = origin + direction * (met.hit.t + OFFSET_ULP)
                    continue
        culls = False
        surface = met_surface(scene, met.hit, direction)
        if shows and not (other and splits):
            end.emitted += wp.cw_mul(end.throughput, surface.emission)
        coat = surface.coat
        follows_lobes = samples.lobes and vertex < CHAIN_VERTICES
        if not follows_lobes:
            surface.coat = 0.0
        crosses = other and splits and surface.crossed
        value = chain_choice(samples, place, vertex)
        step = chain_step(surface, -direction, value, end.throughput, crosses, follows_lobes)
        part = step.part
        rest = step.rest
        end.throughput = step.throughput
        if scene.dispersive and samples.frame_index[0] >= 0 and disperses(part):
            if channel == ALL_COLOURS:
                channel = chain_channel(samples, place)
                end.throughput = of_channel(end.throughput, channel)
            part = refracting(part, channel)
        if vertex == CHAIN_VERTICES or not step.goes_on:
            if other and splits:
                return end
            end.face = met.hit.face
            end.surface = surface
            if scene.part_glass and surface.crossed and samples.frame_index[0] >= 0:
                end.surface.glass = 0.0  # what it mirrors is of other chains
            if step.coat:
                end.surface = part
            elif not samples.lobes:
                end.surface.coat = coat
            return end
        if splits and part.glass > 0.0:
            splits = False
            branch = first_branch(part, -direction, rest, other and not part.crossed)
            rest = branch.rest
            end.throughput = end.throughput * branch.share
            if largest(end.throughput) <= 0.0:
                return end
        drawn = wp.vec2(0.5, 0.5)
        if samples.lobes:
            pair = sobol_pair_at(place, samples.frame_index[0], DIRECTION_PAIR + vertex, samples.seed)
            drawn = wp.vec2(pair.x, pair.y)
        # Nothing else finds emitters and the sky in mirrors and behind frosted glass; those of other lobes are direct
        # light of chains that do not go on.
        shows = not step.follows and (shows or part.glass == 0.0 or not part.clear)
        sample = onward(part, -direction, rest, step.follows, drawn)
        if largest(sample.weight) <= 0.0 and not is_perfect(part):
            return end
        end.throughput = wp.cw_mul(end.throughput, sample.weight)
        if wp.dot(sample.direction, part.geometric_normal) < 0.0 and not part.thin:
            absorption = part.absorption
        origin = offset_origin(part.position, part.geometric_normal, sample.direction)
        direction = sample.direction
    return end
