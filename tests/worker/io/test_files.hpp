#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include "schemas/error.hpp"
#include "worker/types/mesh.hpp"

namespace divemesh::io {

// A test with a temporary folder, which is removed at its end.
class FileTest : public testing::Test {
protected:
    FileTest() {
        const auto* info = testing::UnitTest::GetInstance()->current_test_info();
        folder_ = std::filesystem::path(testing::TempDir()) /
                  (std::string("divemesh_") + info->test_suite_name() + "_" + info->name());
        std::filesystem::remove_all(folder_);
        std::filesystem::create_directories(folder_);
    }
    ~FileTest() override {
        std::error_code ignored;
        std::filesystem::remove_all(folder_, ignored);
    }

    std::filesystem::path file(const std::string& name) const { return folder_ / name; }
    std::filesystem::path write(const std::string& name, const std::string& text) const {
        std::ofstream(file(name), std::ios::binary) << text;
        return file(name);
    }
    static std::string read(const std::filesystem::path& path) {
        std::ifstream stream(path, std::ios::binary);
        return {std::istreambuf_iterator<char>(stream), {}};
    }

private:
    std::filesystem::path folder_;
};

// Returns the Error that `act` throws. Fails the test if it throws no Error.
template <typename Act>
Error error_of(Act&& act) {
    try {
        act();
    } catch (const Error& error) {
        return error;
    }
    ADD_FAILURE() << "no Error was thrown";
    return Error(ErrorCode::InvalidArgument, "");
}

// Returns a tetrahedron with all attributes and outward normals.
inline types::Mesh tetrahedron() {
    types::Mesh mesh;
    mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    mesh.normals = {{-1, -1, -1}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    mesh.colors = {{0, 10, 20}, {255, 0, 0}, {0, 255, 0}, {188, 188, 188}};
    mesh.sigma_m = {0.001F, 0.002F, 0.003F, 0.004F};
    mesh.sigma_local_m = {0.0005F, 0.001F, 0.0015F, 0.002F};
    mesh.num_observations = {1, 2, 3, 4};
    mesh.triangles = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
    return mesh;
}

}  // namespace divemesh::io
