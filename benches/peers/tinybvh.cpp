// What tinybvh-rs leaves out of tinybvh: the AVX builder, spatial splits with all of their references, the optimiser, the
// choice of threads, and the wide CPU layout. Compiled against the header inside that package, under a namespace of its
// own so that both can stand in one program.
#define tinybvh bvh_lab_tinybvh
#define TINYBVH_IMPLEMENTATION
#include "tiny_bvh.h"

using namespace bvh_lab_tinybvh;

namespace {

struct Tree {
    BVH binary;
    // A tree traced in this layout owns its binary tree; the other one stays empty.
    BVH8_CPU* wide = nullptr;
    ~Tree() { delete wide; }
    const BVH& tree() const { return wide ? wide->bvh8.bvh : binary; }
};

// BVH::Optimize does the same but loses the memory of its intermediate tree, which repeated builds would add up.
void optimize(BVH& bvh, bool extreme, bool single) {
    BVH_Verbose verbose;
    verbose.ConvertFrom(bvh);
    if (single) verbose.SplitLeafs(1);
    verbose.Optimize(25, extreme);
    bvh.ConvertFrom(verbose);
}

}

extern "C" {

enum Preset : uint32_t {
    REFERENCE,
    AVX,
    SWEEP,
    HQ,
    AVX_OPTIMIZED,
    AVX_EXTREME,
    SWEEP_EXTREME,
    SINGLE_EXTREME,
    HQ_EXTREME,
    WIDE,
    WIDE_HQ
};

const char* bvh_lab_tinybvh_version() {
#define TEXT_(x) #x
#define TEXT(x) TEXT_(x)
    return TEXT(TINY_BVH_VERSION_MAJOR) "." TEXT(TINY_BVH_VERSION_MINOR) "." TEXT(TINY_BVH_VERSION_SUB);
}

// `vertices`: three of 16 bytes a triangle, aligned to 16, alive as long as the tree.
void* bvh_lab_tinybvh_build(const float* vertices, uint32_t triangles, uint32_t preset, bool threaded) {
    bvhvec4slice slice((const bvhvec4*)vertices, triangles * 3, sizeof(bvhvec4));
    Tree* tree = new Tree();
    BVH& bvh = tree->binary;
    bvh.threadedBuild = threaded;
    if (preset == WIDE || preset == WIDE_HQ) {
        tree->wide = new BVH8_CPU();
        tree->wide->bvh8.bvh.threadedBuild = threaded;
    }
    switch (preset) {
    case REFERENCE: bvh.Build(slice); break;
    case AVX: bvh.BuildAVX(slice); break;
    case SWEEP: bvh.useFullSweep = true; bvh.Build(slice); break;
    case HQ: bvh.BuildHQ(slice); break;
    case AVX_OPTIMIZED: bvh.BuildAVX(slice); optimize(bvh, false, false); break;
    case AVX_EXTREME: bvh.BuildAVX(slice); optimize(bvh, true, false); break;
    case SWEEP_EXTREME: bvh.useFullSweep = true; bvh.Build(slice); optimize(bvh, true, false); break;
    case SINGLE_EXTREME: bvh.BuildAVX(slice); optimize(bvh, true, true); break;
    case HQ_EXTREME: bvh.BuildHQ(slice); optimize(bvh, true, false); break;
    case WIDE: tree->wide->Build(slice); break;
    case WIDE_HQ: tree->wide->BuildHQ(slice); break;
    }
    return tree;
}

void bvh_lab_tinybvh_free(void* tree) { delete (Tree*)tree; }

// Nodes in tinybvh's 32-byte layout, the root at 0; which of them are used only a walk tells.
const void* bvh_lab_tinybvh_nodes(const void* tree, uint32_t* count) {
    const BVH& bvh = ((const Tree*)tree)->tree();
    *count = bvh.allocatedNodes;
    return bvh.bvhNode;
}

const uint32_t* bvh_lab_tinybvh_indices(const void* tree, uint32_t* count) {
    const BVH& bvh = ((const Tree*)tree)->tree();
    *count = bvh.idxCount;
    return bvh.primIdx;
}

// `rays`: eight floats a ray, origin, least t, direction of unit length, greatest t. `hits`: id and t a ray.
void bvh_lab_tinybvh_trace(const void* tree, const float* rays, uint32_t count, uint32_t* hits) {
    const Tree& self = *(const Tree*)tree;
    for (uint32_t i = 0; i < count; i++, rays += 8, hits += 2) {
        Ray ray(bvhvec3(rays[0], rays[1], rays[2]), bvhvec3(rays[4], rays[5], rays[6]));
        if (self.wide) self.wide->Intersect(ray); else self.binary.Intersect(ray);
        const bool hit = ray.hit.t < BVH_FAR;
        hits[0] = hit ? ray.hit.prim : 0xffffffffu;
        const float t = hit ? ray.hit.t : INFINITY;
        memcpy(hits + 1, &t, 4);
    }
}

// Whether a ray meets anything before its greatest t: id 0 at t 0, or none.
void bvh_lab_tinybvh_occluded(const void* tree, const float* rays, uint32_t count, uint32_t* hits) {
    const Tree& self = *(const Tree*)tree;
    for (uint32_t i = 0; i < count; i++, rays += 8, hits += 2) {
        const float far = rays[7] < BVH_FAR ? rays[7] : BVH_FAR;
        Ray ray(bvhvec3(rays[0], rays[1], rays[2]), bvhvec3(rays[4], rays[5], rays[6]), far);
        const bool hit = self.wide ? self.wide->IsOccluded(ray) : self.binary.IsOccluded(ray);
        hits[0] = hit ? 0 : 0xffffffffu;
        const float t = hit ? 0 : INFINITY;
        memcpy(hits + 1, &t, 4);
    }
}

}
