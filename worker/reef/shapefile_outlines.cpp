#include "worker/reef/shapefile_outlines.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>

#include "schemas/error.hpp"
#include "worker/reef/little_endian.hpp"

namespace divemesh::reef {
namespace {

constexpr std::size_t kFileHeader_bytes = 100;
constexpr std::size_t kRecordHeader_bytes = 8;
constexpr std::size_t kShapeHeader_bytes = 44;  // type, box, number of parts and of points
constexpr std::size_t kPoint_bytes = 16;
constexpr std::uint32_t kFileCode = 9994;

constexpr std::size_t kMaxParts = 10'000;  // of a shape; finding their holes takes its square

enum class ShapeKind { None, Points, Line, Polygon, Unknown };

std::uint32_t big_endian_at(std::string_view bytes, std::size_t offset) {
    std::uint32_t value = 0;
    for (std::size_t i = 0; i < 4; ++i)
        value = (value << 8U) | static_cast<unsigned char>(bytes[offset + i]);
    return value;
}

// With Z a type is larger by 10, with M by 20; what they add is behind the points.
ShapeKind kind_of(std::uint32_t type) {
    if (type == 0) return ShapeKind::None;
    if (type > 30) return ShapeKind::Unknown;
    switch (type % 10) {
        case 1:
        case 8: return ShapeKind::Points;
        case 3: return ShapeKind::Line;
        case 5: return ShapeKind::Polygon;
        default: return ShapeKind::Unknown;
    }
}

[[noreturn]] void refuse(std::size_t record, const std::string& what) {
    throw Error(ErrorCode::BadData, "record " + std::to_string(record + 1) + ": " + what);
}

// Returns the parts of a shape: rings without their repeated last point, or lines.
std::vector<Polygon> parts_of(std::string_view shape, std::size_t record) {
    if (shape.size() < kShapeHeader_bytes) refuse(record, "it is too short for a shape");
    const std::size_t num_parts = little_endian_at<std::uint32_t>(shape, 36);
    const std::size_t num_points = little_endian_at<std::uint32_t>(shape, 40);
    const std::size_t room = shape.size() - kShapeHeader_bytes;
    if (num_parts > room / 4 || num_points > (room - 4 * num_parts) / kPoint_bytes)
        refuse(record,
               "it announces " + std::to_string(num_points) + " points in " +
                   std::to_string(num_parts) + " parts, more than the file holds");
    if (num_parts > kMaxParts) refuse(record, "it has more than 10,000 parts");
    const std::size_t points_at = kShapeHeader_bytes + 4 * num_parts;
    const auto start_of = [&](std::size_t part) {
        return part == num_parts
                   ? num_points
                   : little_endian_at<std::uint32_t>(shape, kShapeHeader_bytes + 4 * part);
    };
    std::vector<Polygon> parts(num_parts);
    for (std::size_t part = 0; part < num_parts; ++part) {
        if (start_of(part) > start_of(part + 1) || start_of(part + 1) > num_points)
            refuse(record, "its parts do not follow each other");
        for (std::size_t i = start_of(part); i < start_of(part + 1); ++i)
            parts[part].emplace_back(
                little_endian_at<double>(shape, points_at + i * kPoint_bytes),
                little_endian_at<double>(shape, points_at + i * kPoint_bytes + 8));
    }
    return parts;
}

bool is_clockwise(const Polygon& ring) {
    double twice_m2 = 0.0;
    for (std::size_t i = 1; i + 1 < ring.size(); ++i) {
        const Eigen::Vector2d a = ring[i] - ring[0];
        const Eigen::Vector2d b = ring[i + 1] - ring[0];
        twice_m2 += a.x() * b.y() - a.y() * b.x();
    }
    return twice_m2 < 0.0;
}

// Adds the rings of one shape that are outlines. Others count as holes of the smallest ring around
// them.
void add_polygon(const std::vector<Polygon>& rings, Outline feature, OutlineFile& file) {
    std::vector<std::size_t> outer;  // indices of rings
    std::vector<std::size_t> inner;
    for (std::size_t i = 0; i < rings.size(); ++i)
        (rings.size() == 1 || is_clockwise(rings[i]) ? outer : inner).push_back(i);
    const std::size_t first = file.outlines.size();
    const auto add = [&](std::size_t ring) {
        feature.points = rings[ring];
        file.outlines.push_back(feature);
    };
    for (const std::size_t ring : outer) add(ring);
    for (const std::size_t ring : inner) {
        Outline* around = nullptr;
        for (std::size_t k = first; k < first + outer.size(); ++k) {
            Outline& candidate = file.outlines[k];
            if (rings[ring].empty() || !contains(candidate.points, rings[ring].front())) continue;
            if (around == nullptr || area_m2(candidate.points) < area_m2(around->points))
                around = &candidate;
        }
        if (around != nullptr)
            ++around->num_holes;
        else
            add(ring);  // of a program that does not know which way a ring runs
    }
}

void add_shape(std::string_view shape, Outline feature, OutlineFile& file) {
    if (shape.size() < 4) refuse(feature.feature, "it has no type");
    const auto type = little_endian_at<std::uint32_t>(shape, 0);
    const ShapeKind kind = kind_of(type);
    if (kind == ShapeKind::None || kind == ShapeKind::Points) return;
    if (kind == ShapeKind::Unknown)
        refuse(
            feature.feature,
            "shapes of type " + std::to_string(type) + " are not read: save polygons or polylines");
    const std::vector<Polygon> parts = parts_of(shape, feature.feature);
    if (kind == ShapeKind::Polygon) return add_polygon(parts, std::move(feature), file);
    feature.is_line = true;
    for (const Polygon& part : parts) {
        feature.points = part;
        file.outlines.push_back(feature);
    }
}

}  // namespace

bool is_shapefile(std::string_view bytes) {
    return bytes.size() >= kFileHeader_bytes && big_endian_at(bytes, 0) == kFileCode;
}

OutlineFile shapefile_outlines(std::string_view bytes, const DbfTable& table) {
    OutlineFile file;
    std::size_t record = 0;
    for (std::size_t at = kFileHeader_bytes; at < bytes.size(); ++record) {
        if (bytes.size() - at < kRecordHeader_bytes) refuse(record, "the file ends within it");
        const std::size_t size = std::size_t{2} * big_endian_at(bytes, at + 4);
        at += kRecordHeader_bytes;
        if (size > bytes.size() - at)
            refuse(record, "the file ends within it: copy the file again");
        Outline feature;
        feature.feature = record;
        if (record < table.size()) feature.columns = table[record];
        add_shape(bytes.substr(at, size), std::move(feature), file);
        at += size;
    }
    if (!table.empty() && table.size() != record)
        throw Error(ErrorCode::BadData,
                    "it has " + std::to_string(record) + " shapes, but its table (.dbf) has " +
                        std::to_string(table.size()) + " rows: copy both files of one data set");
    return file;
}

}  // namespace divemesh::reef
