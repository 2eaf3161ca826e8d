"""Wide loads: four neighbouring floats at once, for kernels that wait for little else than memory."""

import warp as wp


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
