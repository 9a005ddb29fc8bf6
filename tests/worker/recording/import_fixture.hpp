#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <vector>

#include "schemas/error.hpp"
#include "schemas/finding.hpp"
#include "tests/temporary_folder.hpp"
#include "worker/recording/import_recording.hpp"

namespace divemesh::recording {

// Returns a chain of Kalibr of two cameras with 64 x 48 px whose IMU is where the left one is, and
// whose clock is `shift_s` ahead.
inline std::string small_camchain(const std::string& shift_s) {
    std::string text;
    for (const char* camera : {"cam0", "cam1"}) {
        const std::string x_m = camera == std::string("cam0") ? "0" : "-0.1";
        text += std::string(camera) + ":\n  T_cam_imu:\n  - [1, 0, 0, " + x_m +
                "]\n  - [0, 1, 0, 0]\n  - [0, 0, 1, 0]\n  - [0, 0, 0, 1]\n" +
                "  camera_model: pinhole\n  intrinsics: [60, 60, 32, 24]\n" +
                "  distortion_model: radtan\n  distortion_coeffs: [0, 0, 0, 0]\n" +
                "  resolution: [64, 48]\n  timeshift_cam_imu: " + shift_s + "\n";
    }
    return text;
}

// What the tests of an importer share: a folder, and what the last import found.
template <typename Importer, typename Options>
class ImportFixture : public testing::Test {
protected:
    ImportCounts imported(const Options& options) {
        Importer importer(options, base::ignore_progress);
        const ImportCounts counts = importer.write(base::ignore_progress);
        findings_ = importer.findings();
        return counts;
    }
    // Returns why an import is refused; expects that it leaves nothing.
    std::string refusal_of(const Options& options) {
        try {
            imported(options);
            ADD_FAILURE() << "it was not refused";
        } catch (const Error& error) {
            EXPECT_FALSE(std::filesystem::exists(options.out));
            EXPECT_FALSE(std::filesystem::exists(options.out.string() + ".partial"));
            return error.what();
        }
        return "";
    }
    bool has_code(const std::string& code) const {
        for (const Finding& finding : findings_)
            if (finding.code == code) return true;
        return false;
    }

    TemporaryFolder folder_;
    std::vector<Finding> findings_;
};

}  // namespace divemesh::recording
