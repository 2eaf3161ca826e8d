"""Sample points: Owen-scrambled Sobol pairs (gpu.sampling.warps maps them to directions and triangles)."""

import warp as wp

from gpu.core.intrinsics import reversed_bits

TO_UNIT = wp.constant(2.3283064365386963e-10)  # 2⁻³²
BELOW_ONE = wp.constant(0.99999994)
MIX_1 = wp.constant(wp.uint32(0x7FEB352D))
MIX_2 = wp.constant(wp.uint32(0x846CA68B))
GOLDEN = wp.constant(wp.uint32(0x9E3779B9))
FIRST_KEY = wp.constant(wp.uint32(0xA511E9B3))
SHIFTS = wp.constant(1 << 16)  # sequences from this one on are those that `sobol_pair_at` shifts by
SECOND_KEY = wp.constant(wp.uint32(0x63D83595))


@wp.func
def hashed(x: wp.uint32) -> wp.uint32:
    """A well-mixed 32-bit hash (C. Wellons' lowbias32)."""
    x ^= x >> wp.uint32(16)
    x *= MIX_1
    x ^= x >> wp.uint32(15)
    x *= MIX_2
    x ^= x >> wp.uint32(16)
    return x


@wp.func
def scrambled(x: wp.uint32, seed: wp.uint32) -> wp.uint32:
    """Nested uniform scrambling of binary digits that stand in reverse, the first lowest.

    B. Burley, Practical Hash-based Owen Scrambling, 2020.
    """
    x ^= x * wp.uint32(0x3D20ADEA)
    x += seed
    x *= (seed >> wp.uint32(16)) | wp.uint32(1)
    x ^= x * wp.uint32(0x05526C56)
    x ^= x * wp.uint32(0x53A22864)
    return x


@wp.func
def sobol_second(index: wp.uint32) -> wp.uint32:
    """The second dimension of Sobol's sequence, its binary digits in reverse.

    The matrix is Pascal's triangle modulo 2, a power of [[1, 1], [0, 1]], so it takes a step for each bit of a digit's
    number (A. Ahmed, An Implementation Algorithm of 2D Sobol Sequence Fast, Elegant, and Compact, 2024).
    """
    x = index
    x ^= (x >> wp.uint32(16)) & wp.uint32(0x0000FFFF)
    x ^= (x >> wp.uint32(8)) & wp.uint32(0x00FF00FF)
    x ^= (x >> wp.uint32(4)) & wp.uint32(0x0F0F0F0F)
    x ^= (x >> wp.uint32(2)) & wp.uint32(0x33333333)
    x ^= (x >> wp.uint32(1)) & wp.uint32(0x55555555)
    return x


@wp.struct
class Pair:
    """Two sample values as 32-bit fractions, and as floats in [0, 1)."""

    a: wp.uint32
    b: wp.uint32
    x: float
    y: float


@wp.func
def sobol_pair(index: int, pair: int, seed: int) -> Pair:
    """Point `index` of the scrambled two-dimensional Sobol sequence number `pair` of `seed`.

    Different pairs are shuffled independently (padding); every power of two of consecutive indices is stratified.
    """
    key = hashed(wp.uint32(seed) * GOLDEN ^ hashed(wp.uint32(pair) + wp.uint32(0x68BC21EB)))
    order = reversed_bits(scrambled(reversed_bits(wp.uint32(index)), key))
    point = Pair()
    point.a = reversed_bits(scrambled(order, hashed(key ^ FIRST_KEY)))
    point.b = reversed_bits(scrambled(sobol_second(order), hashed(key ^ SECOND_KEY)))
    point.x = wp.min(float(point.a) * TO_UNIT, BELOW_ONE)
    point.y = wp.min(float(point.b) * TO_UNIT, BELOW_ONE)
    return point


@wp.func
def sobol_pair_at(place: int, index: int, pair: int, seed: int) -> Pair:
    """Sample `index` of one of many places, such as pixels; as `sobol_pair`.

    The sum of two points of Sobol's sequences, digit by digit. Of any index every power of two of consecutive places is
    stratified, and at any place every power of two of consecutive indices.
    """
    point = sobol_pair(place, pair, seed)
    shift = sobol_pair(index, pair + SHIFTS, seed)
    point.a = point.a ^ shift.a
    point.b = point.b ^ shift.b
    point.x = wp.min(float(point.a) * TO_UNIT, BELOW_ONE)
    point.y = wp.min(float(point.b) * TO_UNIT, BELOW_ONE)
    return point


@wp.func
def pixel_seed(pixel: int, seed: int) -> int:
    """A seed of a pixel's own, so that neighbours are independent."""
    return int(hashed(wp.uint32(seed) ^ hashed(wp.uint32(pixel))))
