#include "worker/dive/dive_json.hpp"

#include "tests/fuzz/input.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const auto text = divemesh::fuzz::Input(data, size).rest();
    divemesh::dive::FindingLog findings;
    divemesh::dive::parse_dive_info(text, findings);
    divemesh::dive::parse_known_distances(text, findings);
    if (const auto port = divemesh::dive::parse_port(text, findings))
        divemesh::dive::port_of(*port, "dive.json", findings);
    divemesh::dive::parse_markers(text, findings);
    return 0;
}
