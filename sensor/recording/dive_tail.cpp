#include "sensor/recording/dive_tail.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "sensor/recording/image_file.hpp"
#include "worker/dive/csv.hpp"
#include "worker/dive/entry_name.hpp"

namespace divemesh::sensor {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMaxRows = 16;
constexpr std::int64_t kMaxPartnerOffset_ns = 5'000'000;

fs::path root_of(const fs::path& folder) {
    std::error_code ignored;
    return fs::is_directory(folder / "mav0", ignored) ? folder / "mav0" : folder;
}

std::optional<std::array<double, 4>> unit_quaternion(std::span<const std::string_view> fields) {
    if (fields.size() < 5) return std::nullopt;
    std::array<double, 4> q{};
    double square = 0.0;
    for (std::size_t i = 0; i < 4; ++i) {
        const auto value = dive::parse_double(fields[i + 1]);
        if (!value || !std::isfinite(*value)) return std::nullopt;
        q[i] = *value;
        square += q[i] * q[i];
    }
    if (!(square > 0.9 && square < 1.1)) return std::nullopt;
    for (double& value : q) value /= std::sqrt(square);
    return q;
}

}  // namespace

DiveTail::DiveTail(fs::path folder)
    : folder_(std::move(folder)),
      root_(root_of(folder_)),
      cam0_(root_ / "cam0" / "data.csv"),
      cam1_(root_ / "cam1" / "data.csv"),
      imu_(root_ / "imu0" / "data.csv"),
      ahrs_(root_ / "ahrs0" / "data.csv"),
      pressure_(root_ / "pressure0" / "data.csv") {}

bool DiveTail::update(std::int64_t until_ns) {
    const auto take_into = [](std::deque<Row>& rows, const Row& row) {
        rows.push_back(row);
        if (rows.size() > kMaxRows) rows.pop_front();
    };
    const bool is_there = cam0_.read(until_ns, [&](std::int64_t stamp, auto fields) {
        if (fields.size() < 2) return;
        ++counts_.num_frames;
        counts_.num_dropped_frames += frame_stamps_.add(stamp);
        take_into(left_, {stamp, std::string(fields[1])});
    });
    cam1_.read(until_ns, [&](std::int64_t stamp, auto fields) {
        if (fields.size() >= 2) take_into(right_, {stamp, std::string(fields[1])});
    });
    imu_.read(until_ns, [&](std::int64_t stamp, auto) { imu_stamps_.add(stamp); });
    ahrs_.read(until_ns, [&](std::int64_t, auto fields) {
        if (const auto q = unit_quaternion(fields)) counts_.orientation = q;
    });
    pressure_.read(until_ns, [&](std::int64_t, auto fields) {
        const auto depth = fields.size() >= 2 ? dive::parse_double(fields[1]) : std::nullopt;
        if (depth && std::abs(*depth) < 12'000.0) counts_.depth_m = depth;
    });
    counts_.frame_rate_hz = frame_stamps_.rate_hz();
    counts_.imu_rate_hz = imu_stamps_.rate_hz();
    return is_there;
}

const DiveTail::Row* DiveTail::partner_of(const Row& left) const {
    const Row* nearest = nullptr;
    std::int64_t min_offset_ns = kMaxPartnerOffset_ns + 1;
    for (const Row& right : right_)
        if (const auto away = std::abs(right.timestamp_ns - left.timestamp_ns);
            away < min_offset_ns) {
            min_offset_ns = away;
            nearest = &right;
        }
    return nearest;
}

cv::Mat DiveTail::image(const char* camera, const Row& row) const {
    if (!dive::entry_name_problem(row.file).empty()) return {};
    return read_image(root_ / camera / "data" / row.file);
}

std::optional<FrameImages> DiveTail::newest_frame(std::int64_t before_ns) const {
    for (auto row = left_.rbegin(); row != left_.rend(); ++row) {
        if (row->timestamp_ns >= before_ns) continue;
        const Row* partner = partner_of(*row);
        if (partner == nullptr && !right_.empty()) continue;  // still being written
        FrameImages frame{row->timestamp_ns, image("cam0", *row), {}};
        if (frame.left.empty()) continue;
        if (partner == nullptr) return frame;
        frame.right = image("cam1", *partner);
        if (!frame.right.empty()) return frame;
    }
    return std::nullopt;
}

}  // namespace divemesh::sensor
