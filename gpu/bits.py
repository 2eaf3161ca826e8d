"""The bits of a word that are set: where they are, and how many."""

import warp as wp


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
