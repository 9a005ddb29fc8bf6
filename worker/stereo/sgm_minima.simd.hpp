// The minima of four paths at one pixel, for the instruction sets that have no quick way to find
// all four. Included by sgm_kernels.cpp after the operations of such a set: no include guard.

struct PathMinima {
    std::uint8_t of[4];
};
DIVEMESH_INLINE_BODY PathMinima path_minima(const V (&v)[4]) {
    PathMinima minima;
    for (int p = 0; p < 4; ++p) minima.of[p] = static_cast<std::uint8_t>(min_byte(v[p]));
    return minima;
}
template <int p>
DIVEMESH_INLINE_BODY std::uint8_t min_of_path(PathMinima minima) {
    return minima.of[p];
}
DIVEMESH_INLINE_BODY V broadcast_last(PathMinima minima) { return broadcast(minima.of[3]); }
