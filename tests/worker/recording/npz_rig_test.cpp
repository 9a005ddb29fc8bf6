#include <gtest/gtest.h>

#include <algorithm>
#include <archive.h>
#include <archive_entry.h>
#include <cmath>
#include <cstring>
#include <fstream>
#include <memory>

#include "schemas/error.hpp"
#include "tests/temporary_folder.hpp"
#include "worker/recording/npy_array.hpp"
#include "worker/recording/read_rig.hpp"

namespace divemesh::recording {
namespace {

namespace fs = std::filesystem;

// Returns an array as numpy.lib.format describes it. `shape` is as Python writes it: "(3, 3)".
template <typename Value>
std::string npy(const std::string& type,
                const std::string& shape,
                const std::vector<Value>& values,
                const std::string& order = "False",
                int version = 1) {
    std::string header =
        "{'descr': '" + type + "', 'fortran_order': " + order + ", 'shape': " + shape + ", }";
    const std::size_t start = version == 1 ? 10 : 12;  // what precedes the header
    header.resize((header.size() + start) / 64 * 64 + 64 - start, ' ');
    header.back() = '\n';
    std::string bytes = "\x93NUMPY";
    bytes += {static_cast<char>(version), '\0'};
    bytes += {static_cast<char>(header.size() & 255U), static_cast<char>(header.size() >> 8U)};
    if (version > 1) bytes += {'\0', '\0'};
    bytes += header;
    for (Value value : values) {
        char raw[sizeof value];
        std::memcpy(raw, &value, sizeof raw);
        if (type[0] == '>') std::reverse(raw, raw + sizeof raw);
        bytes.append(raw, sizeof raw);
    }
    return bytes;
}

// Writes entries as zipfile does, stored as by savez() or deflated as by savez_compressed().
void write_zip(const fs::path& file,
               const std::vector<std::pair<std::string, std::string>>& entries,
               const char* compression) {
    const std::unique_ptr<archive, int (*)(archive*)> writer(archive_write_new(),
                                                             &archive_write_free);
    archive_write_set_format_zip(writer.get());
    archive_write_set_options(writer.get(),
                              (std::string("zip:compression=") + compression).c_str());
    ASSERT_EQ(archive_write_open_filename(writer.get(), file.c_str()), ARCHIVE_OK);
    for (const auto& [name, bytes] : entries) {
        const std::unique_ptr<archive_entry, void (*)(archive_entry*)> entry(archive_entry_new(),
                                                                             &archive_entry_free);
        archive_entry_set_pathname(entry.get(), name.c_str());
        archive_entry_set_size(entry.get(), static_cast<la_int64_t>(bytes.size()));
        archive_entry_set_filetype(entry.get(), AE_IFREG);
        archive_write_header(writer.get(), entry.get());
        archive_write_data(writer.get(), bytes.data(), bytes.size());
    }
    archive_write_close(writer.get());
}

class NpzRigTest : public testing::Test {
protected:
    using Entries = std::vector<std::pair<std::string, std::string>>;

    // The arrays that VIAME's calibration saves. T is in mm.
    static Entries viame() {
        return {{"R.npy", npy<double>("<f8", "(3, 3)", {0.96, -0.28, 0, 0.28, 0.96, 0, 0, 0, 1})},
                {"T.npy", npy<double>("<f8", "(3, 1)", {-250, 3, 1})},
                {"cameraMatrixL.npy",
                 npy<double>("<f8", "(3, 3)", {700, 0, 320, 0, 701, 240, 0, 0, 1})},
                {"distCoeffsL.npy", npy<double>("<f8", "(1, 5)", {-0.2, 0.1, 1e-3, -2e-3, 0})},
                {"cameraMatrixR.npy",
                 npy<double>("<f8", "(3, 3)", {710, 0, 321, 0, 711, 241, 0, 0, 1})},
                {"distCoeffsR.npy", npy<double>("<f8", "(5,)", {-0.3, 0.2, 0, 0, 0})},
                {"board.npy", npy<double>("|O", "()", {})}};
    }
    RigFiles read(const Entries& entries, const char* compression = "store") {
        write_zip(folder_ / "calibration.npz", entries, compression);
        RigHints hints;
        hints.resolution = {640, 480};
        return read_rig({folder_ / "calibration.npz"}, findings_, hints);
    }
    std::string refusal_of(const Entries& entries) {
        try {
            read(entries);
        } catch (const Error& error) {
            return error.what();
        }
        ADD_FAILURE() << "it was not refused";
        return "";
    }

    TemporaryFolder folder_;
    dive::FindingLog findings_;
};

TEST_F(NpzRigTest, TheArraysOfViameAreARig) {
    for (const char* compression : {"store", "deflate"}) {
        const RigFiles rig = read(viame(), compression);

        EXPECT_EQ(rig.cam0.camera.fx_px, 700);
        EXPECT_EQ(rig.cam0.camera.cy_px, 240);
        EXPECT_EQ(rig.cam1.camera.fy_px, 711);
        const Eigen::Isometry3d T_cam1_cam0 = rig.cam1.T_body_cam.inverse() * rig.cam0.T_body_cam;
        EXPECT_TRUE(T_cam1_cam0.translation().isApprox(Eigen::Vector3d(-0.25, 0.003, 0.001)));
        EXPECT_NEAR(T_cam1_cam0.linear()(0, 1), -0.28, 1e-9);  // by rows, not by columns
    }
}

TEST_F(NpzRigTest, ArraysByColumnsAndOfOtherTypesAreTheSame) {
    Entries entries = viame();
    entries[0].second =
        npy<float>(">f4", "(3, 3)", {0.96F, 0.28F, 0, -0.28F, 0.96F, 0, 0, 0, 1}, "True", 2);
    entries[1].second = npy<std::int64_t>("<i8", "(1, 3)", {-250, 3, 1}, "False", 3);

    const RigFiles rig = read(entries);

    const Eigen::Isometry3d T_cam1_cam0 = rig.cam1.T_body_cam.inverse() * rig.cam0.T_body_cam;
    EXPECT_NEAR(T_cam1_cam0.linear()(0, 1), -0.28, 1e-6);
    EXPECT_NEAR(T_cam1_cam0.translation().x(), -0.25, 1e-9);
}

TEST_F(NpzRigTest, HostileFilesAreRefusedWithAReason) {
    const auto with = [](const std::string& array) {
        Entries entries = viame();
        entries[2].second = array;
        return entries;
    };
    const std::vector<double> nine(9, 1.0);
    EXPECT_NE(refusal_of(with(npy<double>("<f8", "(3, 3)", {1, 2}))).find("fewer"),
              std::string::npos);
    EXPECT_NE(refusal_of(with(npy<double>("<f8", "(1, 9)", std::vector<double>(9, std::nan("")))))
                  .find("not a number"),
              std::string::npos);
    for (const char* shape : {"",
                              "(",
                              "(3",
                              "(x)",
                              "(-1)",
                              "(99999999999999999999999)",
                              "(3 3)",
                              "(0, 0)",
                              "(4294967296, 4294967296)",
                              "(2,2,2,2,2,2,2,2,2,2)"})
        refusal_of(with(npy<double>("<f8", shape, nine)));
    refusal_of(with(std::string("\x93NUMPY")));
    refusal_of(with(std::string("\x93NUMPY\1\0\xff\xff{}", 12)));
    refusal_of(with("no array"));
    refusal_of({});
    refusal_of(Entries(1001, {"a.npy", "x"}));
}

TEST_F(NpzRigTest, EveryCutOfAFileIsReadOrRefused) {
    write_zip(folder_ / "whole", viame(), "deflate");
    std::ifstream stream(folder_ / "whole", std::ios::binary);
    const std::string whole{std::istreambuf_iterator<char>(stream), {}};
    for (std::size_t size = 0; size < whole.size(); size += 7) {
        std::ofstream(folder_ / "cut", std::ios::binary) << whole.substr(0, size);
        RigHints hints;
        hints.resolution = {640, 480};
        try {
            read_rig({folder_ / "cut"}, findings_, hints);
        } catch (const Error& error) {
            EXPECT_STRNE(error.what(), "");
        }
    }
}

TEST(NpyArrayTest, ManyNumbersAndOtherTypesArePassedOver) {
    EXPECT_FALSE(parse_npy(npy<double>("<f8", "(5000,)", std::vector<double>(5000))));
    EXPECT_FALSE(parse_npy(npy<double>("<f8", "(2, 2, 2)", std::vector<double>(8))));
    EXPECT_FALSE(parse_npy(npy<double>("<c16", "(1,)", {1, 2})));
    EXPECT_FALSE(parse_npy(npy<double>("|b1", "()", {1})));
    EXPECT_EQ(parse_npy(npy<double>("<f8", "()", {4.5})), std::vector<double>{4.5});
    EXPECT_EQ(parse_npy(npy<double>("<f8", "(0,)", {})), std::vector<double>{});
}

}  // namespace
}  // namespace divemesh::recording
