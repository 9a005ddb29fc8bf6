#pragma once

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <cstring>
#include <map>
#include <string>
#include <utility>

namespace divemesh::io {

// A LAS file, read at the offsets of ASPRS LAS 1.4 revision 15 (tables 3, 8, 16, 24 and 25).
class LasFile {
public:
    explicit LasFile(std::string bytes) : bytes_(std::move(bytes)) {}

    template <typename Value>
    Value at(std::size_t offset) const {
        Value value{};
        EXPECT_LE(offset + sizeof value, bytes_.size()) << offset;
        if (offset + sizeof value <= bytes_.size())
            std::memcpy(&value, bytes_.data() + offset, sizeof value);
        return value;
    }
    std::string text(std::size_t offset, std::size_t size) const {
        return bytes_.substr(offset, size).c_str();  // to the first zero
    }
    std::size_t size() const { return bytes_.size(); }

    // Returns the variable length records by user and number.
    std::map<std::pair<std::string, int>, std::string> records() const {
        std::map<std::pair<std::string, int>, std::string> records;
        std::size_t offset = at<std::uint16_t>(94);
        for (auto left = at<std::uint32_t>(100); left > 0; --left) {
            const std::size_t length = at<std::uint16_t>(offset + 20);
            records[{text(offset + 2, 16), at<std::uint16_t>(offset + 18)}] =
                bytes_.substr(offset + 54, length);
            offset += 54 + length;
        }
        EXPECT_EQ(offset, at<std::uint32_t>(96)) << "the points follow the records";
        return records;
    }
    std::size_t point_offset(std::size_t i) const {
        return at<std::uint32_t>(96) + i * at<std::uint16_t>(105);
    }
    Eigen::Vector3d point(std::size_t i) const {
        Eigen::Vector3d point;
        for (std::size_t axis = 0; axis < 3; ++axis)
            point[static_cast<int>(axis)] =
                at<std::int32_t>(point_offset(i) + 4 * axis) * at<double>(131 + 8 * axis) +
                at<double>(155 + 8 * axis);
        return point;
    }

private:
    std::string bytes_;
};

}  // namespace divemesh::io
