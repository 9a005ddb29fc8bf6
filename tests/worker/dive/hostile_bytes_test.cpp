#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <iterator>
#include <random>

#include "tests/temporary_folder.hpp"
#include "tests/worker/dive/test_archive.hpp"
#include "tests/worker/dive/tiny_dive.hpp"
#include "worker/dive/intake.hpp"

namespace divemesh::dive {
namespace {

// Cuts, flips, doubles or inflates a part of the bytes; the same seed gives the same damage.
std::string damaged(std::string bytes, unsigned seed) {
    std::mt19937 random(seed);
    const auto below = [&](std::size_t n) { return n == 0 ? 0 : random() % n; };
    const std::size_t num_changes = 1 + below(8);
    for (std::size_t change = 0; change < num_changes && !bytes.empty(); ++change) {
        const std::size_t at = below(bytes.size());
        switch (below(5)) {
            case 0: bytes[at] = static_cast<char>(random()); break;
            case 1: bytes[at] ^= static_cast<char>(1U << below(8)); break;
            case 2: bytes.resize(at); break;
            case 3: bytes.insert(at, bytes.substr(below(bytes.size()), below(64))); break;
            default: bytes.replace(at, std::min<std::size_t>(4, bytes.size() - at), "9999"); break;
        }
    }
    return bytes;
}

std::string read_file(const std::filesystem::path& file) {
    std::ifstream stream(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), {}};
}

// Expects a report or an intended Error; anything else fails the test.
void expect_survived(const std::filesystem::path& path, const std::filesystem::path& scratch) {
    try {
        const auto report = examine_dive(path, scratch, base::ignore_progress);
        for (const Finding& finding : report.findings) {
            EXPECT_FALSE(finding.code.empty());
            EXPECT_FALSE(finding.message.empty());
            for (const char c : finding.message + finding.where)
                EXPECT_GE(static_cast<unsigned char>(c), 0x20) << finding.message;
        }
    } catch (const Error& error) {
        EXPECT_EQ(error.code(), ErrorCode::BadData) << error.what();
    }
}

TEST(HostileBytesTest, DamagedArchivesGiveFindingsAndNeverCrash) {
    const TemporaryFolder folder;
    const TinyDive tiny(folder / "dive");
    for (const Container container :
         {Container::Zip, Container::Tar, Container::TarGz, Container::TarZst}) {
        const auto good = folder / "good";
        { TestArchive(good, container).add_folder(tiny.folder()); }
        const std::string bytes = read_file(good);
        for (unsigned seed = 0; seed < 30; ++seed) {
            SCOPED_TRACE(testing::Message()
                         << "container " << static_cast<int>(container) << " seed " << seed);
            const auto file = folder / "damaged";
            std::ofstream(file, std::ios::binary) << damaged(bytes, seed);
            expect_survived(file, folder / "scratch");
        }
    }
}

TEST(HostileBytesTest, DamagedFilesGiveFindingsAndNeverCrash) {
    const TemporaryFolder folder;
    const TinyDive tiny(folder / "dive");
    tiny.write("measurements.json",
               R"({"distances": [{"name": "bar", "a": [0,0,0], "b": [1,0,0], "distance_m": 1}]})");
    tiny.write("markers.json",
               R"({"family": "25h9", "scale_bars": [{"from": 1, "to": 2, "distance_m": 0.5}]})");
    tiny.write("reference.ply",
               "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
               "property float z\nelement face 1\nproperty list uchar int vertex_indices\n"
               "end_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n");
    for (const std::string& file : {std::string("mav0/cam0/data.csv"),
                                    std::string("mav0/cam0/sensor.yaml"),
                                    std::string("mav0/imu0/data.csv"),
                                    std::string("mav0/state_groundtruth_estimate0/data.csv"),
                                    "mav0/cam1/data/" + TinyDive::image_name(0),
                                    std::string("dive.json"),
                                    std::string("measurements.json"),
                                    std::string("markers.json"),
                                    std::string("reference.ply")}) {
        const std::string good = tiny.read(file);
        for (unsigned seed = 0; seed < 23; ++seed) {
            SCOPED_TRACE(testing::Message() << file << " seed " << seed);
            tiny.write(file, damaged(good, seed));
            expect_survived(tiny.folder(), folder / "scratch");
        }
        tiny.write(file, good);
    }
}

}  // namespace
}  // namespace divemesh::dive
