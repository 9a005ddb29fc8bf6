#include "worker/io/trajectory_file.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <limits>
#include <string>
#include <vector>

#include "schemas/error.hpp"
#include "worker/base/atomic_file.hpp"

namespace divemesh::io {
namespace {

constexpr std::int64_t kNsPerSecond = 1'000'000'000;

// The current position, for messages.
struct Line {
    std::string file;
    int number = 0;

    [[noreturn]] void fail(const std::string& what) const {
        throw Error(ErrorCode::BadData, file + ":" + std::to_string(number) + ": " + what);
    }
};

std::vector<std::string> split(std::string_view text) {
    constexpr std::string_view kSeparators = " \t,;\r";
    std::vector<std::string> words;
    while (true) {
        const std::size_t start = text.find_first_not_of(kSeparators);
        if (start == std::string_view::npos) return words;
        const std::size_t end = std::min(text.find_first_of(kSeparators, start), text.size());
        words.emplace_back(text.substr(start, end - start));
        text.remove_prefix(end);
    }
}

std::string quoted(const std::string& word) {
    return std::string(1, '\'').append(word, 0, 40).append("'");
}

double parse_number(const std::string& word, const Line& line) {
    double value = 0.0;
    const char* begin = word.data() + (word.starts_with('+') ? 1 : 0);
    const auto [end, code] = std::from_chars(begin, word.data() + word.size(), value);
    if (code != std::errc() || end != word.data() + word.size() || !std::isfinite(value))
        line.fail(quoted(word) + " is not a number");
    return value;
}

std::int64_t parse_integer(std::string_view digits, const std::string& word, const Line& line) {
    std::int64_t value = 0;
    const auto [end, code] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
    if (code != std::errc() || end != digits.data() + digits.size())
        line.fail(quoted(word) + " is not a timestamp");
    return value;
}

// Parses seconds to nanoseconds digit by digit: a double would lose the last few hundred of them.
std::int64_t parse_seconds(const std::string& word, const Line& line) {
    if (word.find_first_of("eE-") != std::string::npos) {
        const double seconds = parse_number(word, line);
        if (std::abs(seconds) > 9e9) line.fail("timestamp " + quoted(word) + " is not in seconds");
        return std::llround(seconds * static_cast<double>(kNsPerSecond));
    }
    const std::size_t dot = std::min(word.find('.'), word.size());
    const std::int64_t seconds = dot == 0 ? 0 : parse_integer(word.substr(0, dot), word, line);
    if (seconds > 9'000'000'000) line.fail("timestamp " + quoted(word) + " is not in seconds");
    std::string fraction = dot < word.size() ? word.substr(dot + 1) : "";
    fraction.resize(9, '0');
    return seconds * kNsPerSecond + parse_integer(fraction, word, line);
}

Eigen::Isometry3d pose_of(const Eigen::Vector3d& position, Eigen::Quaterniond q, const Line& line) {
    if (std::abs(q.norm() - 1.0) > 0.02)
        line.fail("the quaternion has length " + std::to_string(q.norm()) + " instead of 1");
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    pose.linear() = q.normalized().toRotationMatrix();
    pose.translation() = position;
    return pose;
}

Eigen::Isometry3d pose_of_matrix(const std::vector<double>& v, const Line& line) {
    Eigen::Matrix3d R;
    R << v[0], v[1], v[2], v[4], v[5], v[6], v[8], v[9], v[10];
    if ((R * R.transpose() - Eigen::Matrix3d::Identity()).norm() > 0.05 || R.determinant() < 0.0)
        line.fail("columns 1-3 of the matrix are not a rotation");
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    pose.linear() = Eigen::Quaterniond(R).normalized().toRotationMatrix();
    pose.translation() = Eigen::Vector3d(v[3], v[7], v[11]);
    return pose;
}

TrajectoryFormat detect(const std::string& text, std::size_t num_words, const Line& line) {
    if (text.find(',') != std::string::npos && num_words >= 8) return TrajectoryFormat::Euroc;
    if (num_words == 8) return TrajectoryFormat::Tum;
    if (num_words == 12) return TrajectoryFormat::Kitti;
    line.fail(std::to_string(num_words) +
              " columns: expected TUM (8), EuRoC (8 or more, with commas) or KITTI (12)");
}

types::StampedPose parse_pose(const std::vector<std::string>& words,
                              TrajectoryFormat format,
                              std::size_t num_poses,
                              const Line& line) {
    const bool is_kitti = format == TrajectoryFormat::Kitti;
    if (is_kitti ? words.size() != 12 : words.size() < 8)
        line.fail((is_kitti ? "expected 12 columns, found " : "expected 8 columns, found ") +
                  std::to_string(words.size()));
    std::vector<double> v;
    for (std::size_t i = is_kitti ? 0 : 1; i < (is_kitti ? 12U : 8U); ++i)
        v.push_back(parse_number(words[i], line));
    if (is_kitti) return {static_cast<std::int64_t>(num_poses), pose_of_matrix(v, line)};
    const Eigen::Vector3d position(v[0], v[1], v[2]);
    if (format == TrajectoryFormat::Tum)
        return {parse_seconds(words[0], line),
                pose_of(position, Eigen::Quaterniond(v[6], v[3], v[4], v[5]), line)};
    return {parse_integer(words[0], words[0], line),
            pose_of(position, Eigen::Quaterniond(v[3], v[4], v[5], v[6]), line)};
}

// EuRoC's column names start with '#'; other tools omit it.
bool holds_no_pose(const std::string& text, int line_number) {
    const std::size_t start = text.find_first_not_of(" \t\r");
    if (start == std::string::npos || text[start] == '#') return true;
    return line_number == 1 && std::isalpha(static_cast<unsigned char>(text[start])) != 0;
}

Eigen::Quaterniond rotation_of(const Eigen::Isometry3d& pose) {
    Eigen::Quaterniond q(pose.linear());
    if (q.w() < 0.0) q.coeffs() = -q.coeffs();
    return q;
}

// Returns a row of numbers, with or without a leading separator, with a line end.
std::string row_of(const std::vector<double>& values, char separator, bool separator_first) {
    std::string text;
    for (const double value : values) {
        if (separator_first || !text.empty()) text += separator;
        char number[64];
        text.append(number,
                    static_cast<std::size_t>(std::snprintf(number, sizeof number, "%.9f", value)));
    }
    return text + "\n";
}

std::string seconds_text(std::int64_t timestamp_ns) {
    char text[48];
    const int length = std::snprintf(text,
                                     sizeof text,
                                     "%lld.%09lld",
                                     static_cast<long long>(timestamp_ns / kNsPerSecond),
                                     static_cast<long long>(timestamp_ns % kNsPerSecond));
    return {text, static_cast<std::size_t>(length)};
}

}  // namespace

std::string_view to_string(TrajectoryFormat format) {
    switch (format) {
        case TrajectoryFormat::Tum: return "tum";
        case TrajectoryFormat::Euroc: return "euroc";
        case TrajectoryFormat::Kitti: return "kitti";
    }
    return "";
}

void write_tum(const std::filesystem::path& file,
               const types::Trajectory& trajectory,
               const std::string& remark) {
    base::AtomicFile output(file);
    if (!remark.empty()) output.write("# " + remark + "\n");
    output.write("# timestamp_s x_m y_m z_m qx qy qz qw\n");
    for (const auto& [timestamp_ns, pose] : trajectory) {
        const Eigen::Vector3d p = pose.translation();
        const Eigen::Quaterniond q = rotation_of(pose);
        output.write(seconds_text(timestamp_ns) +
                     row_of({p.x(), p.y(), p.z(), q.x(), q.y(), q.z(), q.w()}, ' ', true));
    }
    output.commit();
}

void write_euroc(const std::filesystem::path& file, const types::Trajectory& trajectory) {
    base::AtomicFile output(file);
    output.write(
        "#timestamp [ns],p_RS_R_x [m],p_RS_R_y [m],p_RS_R_z [m],q_RS_w [],q_RS_x [],q_RS_y [],"
        "q_RS_z []\n");
    for (const auto& [timestamp_ns, pose] : trajectory) {
        const Eigen::Vector3d p = pose.translation();
        const Eigen::Quaterniond q = rotation_of(pose);
        output.write(std::to_string(timestamp_ns) +
                     row_of({p.x(), p.y(), p.z(), q.w(), q.x(), q.y(), q.z()}, ',', true));
    }
    output.commit();
}

void write_kitti(const std::filesystem::path& file, const types::Trajectory& trajectory) {
    base::AtomicFile output(file);
    for (const types::StampedPose& stamped : trajectory) {
        std::vector<double> values;
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 4; ++j) values.push_back(stamped.T_world_imu(i, j));
        output.write(row_of(values, ' ', false));
    }
    output.commit();
}

TrajectoryFile read_trajectory(const std::filesystem::path& file) {
    std::ifstream stream(file);
    if (!stream)
        throw Error(ErrorCode::NotFound, "cannot open " + file.string() + ": check the path");
    TrajectoryFile result;
    Line line{file.filename().string(), 0};
    for (std::string text; std::getline(stream, text);) {
        ++line.number;
        if (holds_no_pose(text, line.number)) continue;
        const std::vector<std::string> words = split(text);
        if (result.poses.empty()) result.format = detect(text, words.size(), line);
        const types::StampedPose pose = parse_pose(words, result.format, result.poses.size(), line);
        if (!result.poses.empty() && pose.timestamp_ns <= result.poses.back().timestamp_ns)
            line.fail(
                "timestamp " + words[0] +
                " is not later than the one before: sort the file and remove repeated timestamps");
        result.poses.push_back(pose);
    }
    if (result.poses.empty())
        line.fail(
            "the file has no poses: if a reconstruction made it, the findings in its metrics.json "
            "say why");
    return result;
}

}  // namespace divemesh::io
