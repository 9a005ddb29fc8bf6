#pragma once

#include <bit>
#include <cstdint>
#include <string>
#include <vector>

#include "worker/reef/polygon.hpp"

namespace divemesh::reef {

// Bytes of a shapefile as ESRI's description of 1998 lays them out, for tests.
class ShapefileBytes {
public:
    explicit ShapefileBytes(std::uint32_t type) : type_(type) {
        put_big(9994);
        for (int i = 0; i < 6; ++i) put_big(0);  // unused, and the length, which nobody needs
        put_little(1000);
        put_little(type);
        bytes_.append(64, '\0');  // the box
    }

    // Adds a record; Z and M types get zeros behind their points.
    void add(const std::vector<Polygon>& parts) {
        std::uint32_t num_points = 0;
        for (const Polygon& part : parts) num_points += static_cast<std::uint32_t>(part.size());
        const std::size_t extra = type_ > 10 ? (type_ > 20 ? 1 : 2) * (16 + 8 * num_points) : 0;
        put_big(++num_records_);
        put_big(static_cast<std::uint32_t>((44 + 4 * parts.size() + 16 * num_points + extra) / 2));
        put_little(type_);
        bytes_.append(32, '\0');
        put_little(static_cast<std::uint32_t>(parts.size()));
        num_points_at_ = bytes_.size();
        put_little(num_points);
        std::uint32_t start = 0;
        for (const Polygon& part : parts) {
            put_little(start);
            start += static_cast<std::uint32_t>(part.size());
        }
        for (const Polygon& part : parts)
            for (const Eigen::Vector2d& point : part)
                for (const double value : point) put_double(value);
        bytes_.append(extra, '\0');
    }
    void add_null() {
        put_big(++num_records_);
        put_big(2);
        put_little(0);
    }
    // Makes the last record claim another number of points.
    void claim_points(std::uint32_t num_points) {
        for (int i = 0; i < 4; ++i)
            bytes_[num_points_at_ + i] = static_cast<char>(num_points >> (8 * i));
    }
    const std::string& bytes() const { return bytes_; }

private:
    void put_big(std::uint32_t value) {
        for (int i = 3; i >= 0; --i) bytes_ += static_cast<char>(value >> (8 * i));
    }
    void put_little(std::uint32_t value) {
        for (int i = 0; i < 4; ++i) bytes_ += static_cast<char>(value >> (8 * i));
    }
    void put_double(double value) {
        const auto bits = std::bit_cast<std::uint64_t>(value);
        for (int i = 0; i < 8; ++i) bytes_ += static_cast<char>(bits >> (8 * i));
    }

    std::uint32_t type_;
    std::uint32_t num_records_ = 0;
    std::size_t num_points_at_ = 0;
    std::string bytes_;
};

// Returns a closed square, clockwise as outlines of a shapefile run.
inline Polygon clockwise_square(double x, double y, double side) {
    return {{x, y}, {x, y + side}, {x + side, y + side}, {x + side, y}, {x, y}};
}

}  // namespace divemesh::reef
