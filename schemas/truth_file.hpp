#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>

namespace divemesh {

// The kinds of truth, data about a dive that are more accurate than its recording.
enum class TruthKind {
    GroundTruth,   // a trajectory: TUM, EuRoC or KITTI
    Reference,     // a mesh or points: PLY, OBJ or GLB
    Measurements,  // measurements.json: known distances
    Areas,         // areas.json: polygons to measure
};

inline constexpr std::array kTruthKinds = {
    TruthKind::GroundTruth, TruthKind::Reference, TruthKind::Measurements, TruthKind::Areas};

// In place of a file's name: the truth in the recording itself.
inline constexpr std::string_view kTruthOfDive = "dive";

std::string_view to_string(TruthKind kind);
TruthKind truth_kind_from_string(std::string_view text);  // throws Error{InvalidArgument}

// A file of truth that came after its dive. It never changes: another file has another id.
struct TruthFile {
    std::string id;
    std::string project;
    std::string dive_id;
    TruthKind kind = TruthKind::GroundTruth;
    std::string name;  // for users: that of the uploaded file
    std::string sha256;
    std::int64_t size_bytes = 0;
    std::string blob;  // key in the blob store; not shown over HTTP
    std::int64_t created_at_ms = 0;
    std::string problem;  // why a report could not read it; "": no problem known
};

// A file of truth that a report could not read.
struct UnreadableTruth {
    TruthKind kind = TruthKind::GroundTruth;
    std::string problem;
};

}  // namespace divemesh
