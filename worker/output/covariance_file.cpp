#include "worker/output/covariance_file.hpp"

#include <cinttypes>
#include <cstdio>
#include <string>

#include "worker/output/atomic_file.hpp"

namespace divemesh::worker {
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

}  // namespace

void write_covariances(const std::filesystem::path& file, const CovarianceTrack& covariances) {
    std::string text =
        "#timestamp [ns],p_xx [m^2],p_xy,p_xz,p_yy,p_yz,p_zz,"
        "r_xx [rad^2],r_xy,r_xz,r_yy,r_yz,r_zz\n";
    for (const PoseCovariance& pose : covariances) {
        char stamp[32];
        std::snprintf(stamp, sizeof stamp, "%" PRId64, pose.timestamp_ns);
        text += stamp;
        append(text, pose.position_m2);
        append(text, pose.rotation_rad2);
        text += "\n";
    }
    write_file(file, text);
}

}  // namespace divemesh::worker
