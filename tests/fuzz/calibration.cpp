#include <fstream>
#include <vector>

#include "schemas/error.hpp"
#include "tests/fuzz/input.hpp"
#include "tests/temporary_folder.hpp"
#include "worker/recording/read_rig.hpp"

// Fuzzes calibrations of other programs: one file, or two with a form feed between them.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    static const divemesh::TemporaryFolder folder;
    const std::string_view all = divemesh::fuzz::Input(data, size).rest();
    const std::size_t end = all.find('\f');
    const auto file = [](const char* name, std::string_view text) {
        std::ofstream(folder / name, std::ios::binary) << text;
        return folder / name;
    };
    std::vector<std::filesystem::path> files = {file("first", all.substr(0, end))};
    if (end != std::string_view::npos) files.push_back(file("second", all.substr(end + 1)));
    try {
        divemesh::dive::FindingLog findings;
        divemesh::recording::RigHints hints;
        hints.resolution = {640, 480};
        divemesh::recording::read_rig(files, findings, hints);
    } catch (const divemesh::Error&) {
        return 0;
    }
    return 0;
}
