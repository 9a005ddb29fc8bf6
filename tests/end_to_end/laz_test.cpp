// An exported LAZ file has the points of the LAS file, as a foreign reader decodes them.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <fstream>

#include "tests/end_to_end/service.hpp"
#include "tests/paths.hpp"

namespace divemesh {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;

class LazTest : public testing::Test {
protected:
    // Writes a reconstruction whose mesh is a rippled surface of so many vertices.
    fs::path write_reconstruction(std::uint32_t num_vertices) const {
        const fs::path folder = service / ("model-" + std::to_string(num_vertices));
        fs::create_directories(folder);
        std::ofstream(folder / "metrics.json") << "{}";
        std::ofstream ply(folder / "mesh.ply", std::ios::binary);
        ply << "ply\nformat binary_little_endian 1.0\nelement vertex " << num_vertices
            << "\nproperty float x\nproperty float y\nproperty float z\nproperty uchar red\n"
               "property uchar green\nproperty uchar blue\nproperty float sigma\n"
               "property uint num_observations\nend_header\n";
        for (std::uint32_t i = 0; i < num_vertices; ++i) {
            const float x = 0.004F * static_cast<float>(i % 500);
            const float y = 0.004F * static_cast<float>(i / 500);
            const float z = 0.2F * std::sin(4 * x + y);
            const float sigma = 0.001F + 0.0001F * static_cast<float>(i * 37 % 11);
            const std::uint32_t num_observations = i * 13 % 9;
            const auto grey = static_cast<unsigned char>(90 + i % 40);
            const unsigned char rgb[] = {
                grey, static_cast<unsigned char>(i % 5 == 0 ? 200 - i % 17 : grey), grey};
            const auto put = [&](const auto& value) {
                char bytes[sizeof value];
                std::memcpy(bytes, &value, sizeof value);
                ply.write(bytes, sizeof value);
            };
            for (const float coordinate : {x, y, z}) put(coordinate);
            put(rgb);
            put(sigma);
            put(num_observations);
        }
        return folder;
    }

    Service service;
};

TEST_F(LazTest, LazPerfReadsThePointsOfLasInAnyNumberOfChunks) {
    const fs::path scripts = source_directory() / "tests/end_to_end/js";
    if (!fs::exists(scripts / "node_modules/laz-perf"))
        GTEST_SKIP() << "run npm ci in tests/end_to_end/js first";
    for (const std::uint32_t num_vertices : {0U, 1U, 50'000U, 50'001U, 260'000U}) {
        const fs::path model = write_reconstruction(num_vertices);
        const Outcome exported =
            service.run({"export", model.string(), "--format", "las,laz"}, 60s);
        ASSERT_EQ(exported.exit_code, 0) << exported.err;

        Process node({"/usr/bin/env",
                      "node",
                      (scripts / "check_laz.mjs").string(),
                      (model / "surface.las").string(),
                      (model / "surface.laz").string()},
                     service / ".");
        EXPECT_EQ(node.wait(120s), 0) << node.stdout_text() << node.stderr_text();
    }
}

}  // namespace
}  // namespace divemesh
