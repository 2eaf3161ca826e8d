"""Rays against triangles in a tree of boxes, four children a node (H. Dammertz et al., Shallow Bounding Volume
Hierarchies for Fast SIMD Ray Tracing of Incoherent Rays, 2008).

Rays between surfaces go where no neighbour goes, so what a ray reads is what it costs. A node's four boxes lie side by
side, as do a triangle's corners, in the order of the leaves: a third of what a binary tree over indexed triangles has
to read. gpu.device_scene.bvh_build makes the tree.
"""

import warp as wp

# As of the binary trees that Warp builds. Each level leaves at most three nodes for later.
MAX_LEVELS = 32


@wp.struct
class Bvh:
    """A tree over triangles; node 0 is its root. Unit space.

    bounds (6·node + row,): of a node's four children, least x, greatest x, then y, then z; a child that there is not is
    far away. children (2·node + row,): row 0 the child's node or, for a leaf, its first place; row 1 how many places a
    leaf has, 0 for a node. corners (3·place + corner,): of the leaves' triangles, the first with 1 for w where its back
    can be culled, else 0; faces (place,): which they are. levels (MAX_LEVELS + 1,): the first node of each, and after
    the last one how many nodes there are.
    """

    bounds: wp.array[wp.vec4]
    children: wp.array[wp.vec4i]
    corners: wp.array[wp.vec4]
    faces: wp.array[int]
    levels: wp.array[int]


_TRAVERSAL = """
    typedef wp::vec_t<4, wp::float32> Four;
    typedef wp::vec_t<4, wp::int32> Four_ints;
    BEGIN
#if defined(__CUDA_ARCH__)
    auto four = [](const Four* from) -> Four {
        const float4 read = __ldg(reinterpret_cast<const float4*>(from));
        return Four(read.x, read.y, read.z, read.w);
    };
    auto four_ints = [](const Four_ints* from) -> Four_ints {
        const int4 read = __ldg(reinterpret_cast<const int4*>(from));
        return Four_ints(read.x, read.y, read.z, read.w);
    };
    auto larger = [](float a, float b) -> float { return fmaxf(a, b); };
    auto smaller = [](float a, float b) -> float { return fminf(a, b); };
#else
    auto larger = [](float a, float b) -> float { return a > b ? a : b; };
    auto smaller = [](float a, float b) -> float { return a < b ? a : b; };
    auto four = [](const Four* from) -> Four { return *from; };
    auto four_ints = [](const Four_ints* from) -> Four_ints { return *from; };
#endif
    auto lower = [&](float a, float b, float c) -> float { return smaller(a, smaller(b, c)); };
    auto upper = [&](float a, float b, float c) -> float { return larger(a, larger(b, c)); };
    const float far_away = 1.0e30f;
    // Boxes are a little longer than they are, since distances to their sides are rounded.
    const float longer = 1.0f + 8.0f * 1.1920929e-07f;
    const float ox = origin[0], oy = origin[1], oz = origin[2];
    const float dx = direction[0], dy = direction[1], dz = direction[2];

    // The shear after which the ray runs along the third axis, one unit a unit of its length.
    float along_x[3], along_y[3], along_z[3];
    bool ascends;
    {
        const float size_x = fabsf(dx), size_y = fabsf(dy), size_z = fabsf(dz);
        const int longest = size_x > size_y ? (size_x > size_z ? 0 : 2) : (size_y > size_z ? 1 : 2);
        const float scale = 1.0f / (longest == 0 ? dx : (longest == 1 ? dy : dz));
        along_x[0] = longest == 0 ? -dy * scale : (longest == 1 ? 0.0f : 1.0f);
        along_x[1] = longest == 0 ? 1.0f : (longest == 1 ? -dz * scale : 0.0f);
        along_x[2] = longest == 0 ? 0.0f : (longest == 1 ? 1.0f : -dx * scale);
        along_y[0] = longest == 0 ? -dz * scale : (longest == 1 ? 1.0f : 0.0f);
        along_y[1] = longest == 0 ? 0.0f : (longest == 1 ? -dx * scale : 1.0f);
        along_y[2] = longest == 0 ? 1.0f : (longest == 1 ? 0.0f : -dy * scale);
        along_z[0] = longest == 0 ? scale : 0.0f;
        along_z[1] = longest == 1 ? scale : 0.0f;
        along_z[2] = longest == 2 ? scale : 0.0f;
        ascends = scale > 0.0f;
    }
    auto dot = [](const float* row, float x, float y, float z) -> float {
        return row[0] * x + row[1] * y + row[2] * z;
    };

    // In no direction a ray moves by nothing: what it may meet then is at most a little more.
    const float tiny = 1.0e-20f;
    const float rx = 1.0f / (fabsf(dx) < tiny ? tiny : dx);
    const float ry = 1.0f / (fabsf(dy) < tiny ? tiny : dy);
    const float rz = 1.0f / (fabsf(dz) < tiny ? tiny : dz);
    const int back_x = rx < 0.0f, back_y = ry < 0.0f, back_z = rz < 0.0f;

    // Of two faces in one place the one that is turned to the ray counts: a back is met as if it were this much below.
    const float least_height = 8.0f * 1.1920929e-07f;
    // A triangle is met where its own box is, too, and not before. All boxes above hold that one, so that what is met
    // first does not depend on the tree: what is nearest counts and, of what is as near, the lowest number.
    float nearest = max_t, least = far_away, limit = max_t, u = 0.0f, v = 0.0f;
    int found = -1;
    int stack[STACK];
    float entries[STACK];
    int size = 0;
    int node = 0;
    while (true) {
        LOOK
        const Four* bounds = bvh.bounds.data + 6 * node;
        const Four near_x = four(bounds + back_x), far_x = four(bounds + 1 - back_x);
        const Four near_y = four(bounds + 2 + back_y), far_y = four(bounds + 3 - back_y);
        const Four near_z = four(bounds + 4 + back_z), far_z = four(bounds + 5 - back_z);
        const Four_ints child = four_ints(bvh.children.data + 2 * node);
        const Four_ints count = four_ints(bvh.children.data + 2 * node + 1);
        int leaves = 0;
        int next = -1;
        float next_entry = far_away;
#pragma unroll
        for (int c = 0; c < 4; ++c) {
            const float begin_x = (near_x[c] - ox) * rx, end_x = (far_x[c] - ox) * rx;
            const float begin_y = (near_y[c] - oy) * ry, end_y = (far_y[c] - oy) * ry;
            const float begin_z = (near_z[c] - oz) * rz, end_z = (far_z[c] - oz) * rz;
            const float begin = larger(larger(begin_x, begin_y), larger(begin_z, 0.0f));
            const float end = smaller(smaller(end_x, end_y), smaller(end_z, limit));
            if (begin <= end * longer) {
                if (count[c] > 0) {
                    leaves |= 1 << c;
                } else {
                    int later = child[c];
                    float later_entry = begin;
                    if (begin < next_entry) {
                        later = next;
                        later_entry = next_entry;
                        next = child[c];
                        next_entry = begin;
                    }
                    if (later >= 0) {
                        stack[size] = later;
                        if (!any_one) entries[size] = later_entry;
                        ++size;
                    }
                }
            }
        }
        while (leaves != 0) {
            int c = 0;
            while (((leaves >> c) & 1) == 0) ++c;
            leaves &= leaves - 1;
            const int* leaf = reinterpret_cast<const int*>(bvh.children.data + 2 * node) + c;
            const int end = leaf[0] + leaf[4];
            for (int place = leaf[0]; place < end; ++place) {
                LOOK
                const Four p = four(bvh.corners.data + 3 * place);
                const Four q = four(bvh.corners.data + 3 * place + 1);
                const Four r = four(bvh.corners.data + 3 * place + 2);
                const float ax = p[0] - ox, ay = p[1] - oy, az = p[2] - oz;
                const float bx = q[0] - ox, by = q[1] - oy, bz = q[2] - oz;
                const float cx = r[0] - ox, cy = r[1] - oy, cz = r[2] - oz;
                const float Ax = dot(along_x, ax, ay, az), Ay = dot(along_y, ax, ay, az);
                const float Bx = dot(along_x, bx, by, bz), By = dot(along_y, bx, by, bz);
                const float Cx = dot(along_x, cx, cy, cz), Cy = dot(along_y, cx, cy, cz);
                const float U = wp::diff_product(Cx, By, Cy, Bx);
                const float V = wp::diff_product(Ax, Cy, Ay, Cx);
                const float W = wp::diff_product(Bx, Ay, By, Ax);
                if ((U < 0.0f || V < 0.0f || W < 0.0f) && (U > 0.0f || V > 0.0f || W > 0.0f)) continue;
                const float whole = U + V + W;
                if (whole == 0.0f) continue;
                const float depth = U * dot(along_z, ax, ay, az) + V * dot(along_z, bx, by, bz)
                    + W * dot(along_z, cx, cy, cz);
                const bool is_front = (whole > 0.0f) == ascends;
                if (cull_backs && !is_front && p[3] != 0.0f) continue;
                const float share = 1.0f / whole;
                const float t = depth * share;
                if (t >= 0.0f && t <= limit) {
                    const float begin = larger(
                        larger(lower(ax * rx, bx * rx, cx * rx), lower(ay * ry, by * ry, cy * ry)),
                        larger(lower(az * rz, bz * rz, cz * rz), 0.0f));
                    const float leave = smaller(
                        smaller(upper(ax * rx, bx * rx, cx * rx), upper(ay * ry, by * ry, cy * ry)),
                        upper(az * rz, bz * rz, cz * rz));
                    float key = larger(t, begin);
                    if (begin > leave * longer || key >= max_t) continue;
                    const int face = bvh.faces.data[place];
                    if (any_one) return FOUND(t, U * share, V * share, face);
                    if (!is_front) {
                        const float ex = bx - ax, ey = by - ay, ez = bz - az, fx = cx - ax, fy = cy - ay, fz = cz - az;
                        const float nx = ey * fz - ez * fy, ny = ez * fx - ex * fz, nz = ex * fy - ey * fx;
                        key += least_height * sqrtf(nx * nx + ny * ny + nz * nz)
                            / larger(fabsf(nx * dx + ny * dy + nz * dz), tiny);
                    }
                    if (key < least || (key == least && face < found)) {
                        least = key;
                        limit = smaller(key, max_t);
                        nearest = t;
                        u = U * share;
                        v = V * share;
                        found = face;
                    }
                }
            }
        }
        while (next < 0 || next_entry > limit * longer) {
            if (size == 0) return FOUND(nearest, u, v, found);
            --size;
            next = stack[size];
            next_entry = any_one ? 0.0f : entries[size];
        }
        node = next;
    }
""".replace("STACK", str(3 * MAX_LEVELS))
_FOUND = "auto FOUND = [](float t, float u, float v, int f) { return Four(t, u, v, wp::cast<wp::float32>(f)); };"
_COUNT = "int looked = 0; auto FOUND = [&](float, float, float, int) { return looked; };"


@wp.func_native(_TRAVERSAL.replace("BEGIN", _FOUND).replace("LOOK\n", "\n"))
def intersect(bvh: Bvh, origin: wp.vec3, direction: wp.vec3, max_t: float, any_one: bool,
              cull_backs: bool) -> wp.vec4:  # fmt: skip
    """The first triangle along a ray, nearer than `max_t`, or `any_one`; `direction` has unit length.

    cull_backs: those that can be culled are not met from behind. Of two that lie in one place, back to back, the one
    whose front is met is the first; of others the one of the lowest number. Whatever the tree, the result is the same.
    (t, u, v) and, as the bits of a float, the triangle, -1 for none, which is met at u·p0 + v·p1 + (1 − u − v)·p2.
    Edges that triangles share let no ray through: S. Woop et al., Watertight Ray/Triangle Intersection, 2013.
    """


@wp.func_native(_TRAVERSAL.replace("BEGIN", _COUNT).replace("LOOK\n", "if (++looked >= most) return looked;\n"))
def looks(bvh: Bvh, origin: wp.vec3, direction: wp.vec3, max_t: float, any_one: bool, cull_backs: bool,
          most: int) -> wp.int32:  # fmt: skip
    """How many nodes and triangles `intersect` looks at for a ray, of which it stops to count `most`."""
