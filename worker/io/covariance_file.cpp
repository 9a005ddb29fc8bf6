#include "worker/io/covariance_file.hpp"

#include <array>
#include <charconv>
#include <cinttypes>
#include <cstdio>
#include <fstream>
#include <optional>
#include <string>

#include "schemas/error.hpp"
#include "worker/base/atomic_file.hpp"

namespace divemesh::io {
namespace {

void append(std::string& text, const Eigen::Matrix3d& covariance) {
    for (int row = 0; row < 3; ++row) {
        for (int column = row; column < 3; ++column) {
            char number[40];
            std::snprintf(number, sizeof number, ",%.6e", covariance(row, column));
            text += number;
        }
    }
}

Eigen::Matrix3d symmetric(const double* entries) {
    Eigen::Matrix3d covariance;
    for (int row = 0; row < 3; ++row)
        for (int column = row; column < 3; ++column)
            covariance(row, column) = covariance(column, row) = *entries++;
    return covariance;
}

std::optional<types::PoseCovariance> parse_row(const std::string& line) {
    types::PoseCovariance pose;
    std::array<double, 12> entries{};
    const char* const end = line.data() + line.size();
    std::from_chars_result read = std::from_chars(line.data(), end, pose.timestamp_ns);
    for (double& entry : entries) {
        if (read.ec != std::errc() || read.ptr == end || *read.ptr != ',') return std::nullopt;
        read = std::from_chars(read.ptr + 1, end, entry);
    }
    if (read.ec != std::errc() || read.ptr != end) return std::nullopt;
    pose.position_m2 = symmetric(entries.data());
    pose.rotation_rad2 = symmetric(entries.data() + 6);
    return pose;
}

}  // namespace

void write_covariances(const std::filesystem::path& file,
                       const types::CovarianceTrack& covariances) {
    std::string text =
        "#timestamp [ns],p_xx [m^2],p_xy,p_xz,p_yy,p_yz,p_zz,"
        "r_xx [rad^2],r_xy,r_xz,r_yy,r_yz,r_zz\n";
    for (const types::PoseCovariance& pose : covariances) {
        char stamp[32];
        std::snprintf(stamp, sizeof stamp, "%" PRId64, pose.timestamp_ns);
        text += stamp;
        append(text, pose.position_m2);
        append(text, pose.rotation_rad2);
        text += "\n";
    }
    base::write_file(file, text);
}

types::CovarianceTrack read_covariances(const std::filesystem::path& file) {
    std::ifstream stream(file, std::ios::binary);
    if (!stream)
        throw Error(ErrorCode::NotFound, "there is no file " + file.string() + ": check the path");
    types::CovarianceTrack covariances;
    std::string line;
    std::getline(stream, line);  // the heading
    for (int number = 2; std::getline(stream, line); ++number) {
        const auto pose = parse_row(line);
        const bool rises =
            pose && (covariances.empty() || pose->timestamp_ns > covariances.back().timestamp_ns);
        if (!rises)
            throw Error(ErrorCode::BadData,
                        file.string() + ", line " + std::to_string(number) +
                            ": expected a later timestamp than before and twelve numbers");
        covariances.push_back(*pose);
    }
    return covariances;
}

}  // namespace divemesh::io
