#include "worker/io/ply.hpp"

#include <cstdlib>

#include "schemas/error.hpp"
#include "tests/fuzz/input.hpp"

// Whatever is read can be used: what belongs to a vertex is there for each, and no triangle names
// one that is missing.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    try {
        const divemesh::types::Mesh mesh =
            divemesh::io::parse_ply(divemesh::fuzz::Input(data, size).rest(), "mesh.ply");
        const std::size_t num = mesh.vertices.size();
        for (const std::size_t of_each : {mesh.normals.size(),
                                          mesh.colors.size(),
                                          mesh.sigma_m.size(),
                                          mesh.num_observations.size()})
            if (of_each != 0 && of_each != num) std::abort();
        for (const auto& triangle : mesh.triangles)
            for (const std::uint32_t vertex : triangle)
                if (vertex >= num) std::abort();
    } catch (const divemesh::Error&) {
    }
    return 0;
}
