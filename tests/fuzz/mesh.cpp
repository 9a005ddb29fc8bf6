#include <cstdlib>

#include "schemas/error.hpp"
#include "tests/fuzz/input.hpp"
#include "worker/io/mesh_reader.hpp"

// OBJ and GLB: no triangle of what is read names a vertex that is missing, and memory stays a
// small multiple of the file.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    divemesh::fuzz::Input input(data, size);
    const auto bytes = input.rest();
    const auto parse_textured = [](std::string_view text, const std::string& name) {
        return divemesh::io::parse_textured_glb(text, name).mesh;
    };
    using Parse = divemesh::types::Mesh (*)(std::string_view, const std::string&);
    for (const Parse parse :
         {Parse(divemesh::io::parse_obj), Parse(divemesh::io::parse_glb), Parse(parse_textured)}) {
        try {
            const divemesh::types::Mesh mesh = parse(bytes, "mesh");
            if (mesh.vertices.size() > bytes.size()) std::abort();
            for (const auto& triangle : mesh.triangles)
                for (const std::uint32_t vertex : triangle)
                    if (vertex >= mesh.vertices.size()) std::abort();
        } catch (const divemesh::Error&) {
        }
    }
    return 0;
}
