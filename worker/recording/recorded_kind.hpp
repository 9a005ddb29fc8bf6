#pragma once

#include <filesystem>

namespace divemesh::recording {

// What lies at a path, told by first bytes and by names.
struct RecordedKind {
    enum class Kind { Dive, Messages, Images, Videos };

    bool is_dive() const { return kind == Kind::Dive; }

    Kind kind = Kind::Dive;    // also of what is none of the others
    bool may_be_dive = false;  // of images: they lie in folders as those of a dive do
};

// Returns what lies at a path: a bag or MCAP, or a folder or an archive that holds a dive with its
// tables, images or videos. Links are not followed.
RecordedKind recorded_kind(const std::filesystem::path& path);

}  // namespace divemesh::recording
