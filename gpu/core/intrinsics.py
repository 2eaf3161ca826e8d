"""What Warp has no function for: warp shuffles and votes, wide loads, counting and reversing of bits.

Lanes are neighbouring threads that share the work of one item, where there are too few items for a GPU's threads. Item
i has the threads `lanes`·i to `lanes`·i + lanes − 1, which are in one warp and must all reach each sum. On a CPU an
item has one lane.
"""

import warp as wp

CUDA_LANES = 8


def lanes_of(device: wp.Device, *, few: bool) -> int:
    """How many threads of a device share an item, 8 or 1. few: there are fewer items than a GPU has threads."""
    return CUDA_LANES if few and device.is_cuda else 1


@wp.func_native("""
#if defined(__CUDA_ARCH__)
    const unsigned mask = ((1u << lanes) - 1u) << (threadIdx.x & 31u & ~(lanes - 1u));
    for (int other = 1; other < lanes; other <<= 1) value += __shfl_xor_sync(mask, value, other);
#endif
    return value;
""")
def float_sum(value: float, lanes: int) -> wp.float32:
    """The sum of a value over the lanes of an item, the same bits for each of them."""


@wp.func_native("""
#if defined(__CUDA_ARCH__)
    const unsigned mask = ((1u << lanes) - 1u) << (threadIdx.x & 31u & ~(lanes - 1u));
    for (int other = 1; other < lanes; other <<= 1) {
        const float theirs = __shfl_xor_sync(mask, value, other);
        const int their_place = __shfl_xor_sync(mask, place, other);
        if (theirs < value || (theirs == value && their_place < place)) {
            value = theirs;
            place = their_place;
        }
    }
#endif
    return place;
""")
def place_of_least(value: float, place: int, lanes: int) -> wp.int32:
    """The `place` that the lane of an item with the least `value` has; of equal ones the least place."""


@wp.func_native("""
#if defined(__CUDA_ARCH__)
    const unsigned mask = ((1u << lanes) - 1u) << (threadIdx.x & 31u & ~(lanes - 1u));
    for (int other = 1; other < lanes; other <<= 1) value = fminf(value, __shfl_xor_sync(mask, value, other));
#endif
    return value;
""")
def float_least(value: float, lanes: int) -> wp.float32:
    """The least value of the lanes of an item."""


@wp.func_native("""
#if defined(__CUDA_ARCH__)
    const unsigned mask = ((1u << lanes) - 1u) << (threadIdx.x & 31u & ~(lanes - 1u));
    for (int other = 1; other < lanes; other <<= 1) value |= __shfl_xor_sync(mask, value, other);
#endif
    return value;
""")
def bits_of_all(value: int, lanes: int) -> wp.int32:
    """The bits that are set in any lane of an item."""


@wp.func_native("""
#if defined(__CUDA_ARCH__) && __CUDA_ARCH__ >= 800
    return __reduce_or_sync(__activemask(), bits);
#else
    return bits;
#endif
""")
def bits_of_warp(bits: wp.uint32) -> wp.uint32:
    """The bits that are set in any thread that runs with this one; at least its own.

    Threads that go through the same bits reach each of them together and share what they read. Which threads run
    together is not defined, so no result may depend on the bits of others.
    """


@wp.func_native("""
#if defined(__CUDA_ARCH__)
    const unsigned alike = __match_any_sync(__activemask(), element);
    if ((threadIdx.x & 31u) == __ffs(alike) - 1) atomicAdd(counts.data + element, __popc(alike));
#else
    ++counts.data[element];
#endif
""")
def count_in(counts: wp.array[int], element: int) -> None:
    """Adds 1 to an element of `counts`, once for all threads that run together and add to the same one."""


@wp.func_native("""
#if defined(__CUDA_ARCH__)
    const unsigned together = __activemask(), lane = threadIdx.x & 31u;
    int before = 0, total = 0;
    for (int bit = 0; bit < 6; ++bit) {
        const unsigned have = __ballot_sync(together, (number >> bit) & 1);
        before += __popc(have & ((1u << lane) - 1u)) << bit;
        total += __popc(have) << bit;
    }
    const int leader = __ffs(together) - 1;
    int end = 0;
    if (lane == leader) end = atomicAdd(ends.data + element, total);
    return __shfl_sync(together, end, leader) + before;
#else
    const int end = ends.data[element];
    ends.data[element] += number;
    return end;
#endif
""")
def room_in(ends: wp.array[int], element: int, number: int) -> wp.int32:
    """Reserves `number` places, 0 to 63, at the end of a list whose length is ends[element], and returns the first.

    The length is changed once for all threads that run together, which must reserve in one list. Which places a thread
    gets is not defined, so no result may depend on it.
    """


@wp.func
def vector_sum(value: wp.vec3, lanes: int) -> wp.vec3:
    """`float_sum` of each element."""
    return wp.vec3(float_sum(value[0], lanes), float_sum(value[1], lanes), float_sum(value[2], lanes))


@wp.func_native("""
#if defined(__CUDA_ARCH__)
    const float4 four = __ldg(reinterpret_cast<const float4*>(values.data) + index);
    return wp::vec_t<4, wp::float32>(four.x, four.y, four.z, four.w);
#else
    return values.data[index];
#endif
""")
def four_at(values: wp.array[wp.vec4], index: int) -> wp.vec4:
    """One element of `values`, which no thread of the launch writes."""


@wp.func_native("""
#if defined(__CUDA_ARCH__)
    return __ffs(bits) - 1;
#else
    return __builtin_ctz(bits);
#endif
""")
def lowest_bit(bits: wp.uint32) -> wp.int32:
    """The place of the lowest bit that is set."""


@wp.func_native("""
#if defined(__CUDA_ARCH__)
    return __popc(bits);
#else
    return __builtin_popcount(bits);
#endif
""")
def bit_count(bits: wp.uint32) -> wp.int32:
    """How many bits are set."""


@wp.func_native("""
#if defined(__CUDA_ARCH__)
    return __brev(bits);
#else
    return __builtin_bitreverse32(bits);
#endif
""")
def reversed_bits(bits: wp.uint32) -> wp.uint32:
    """The 32 bits in reverse order."""
