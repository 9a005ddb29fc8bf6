#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <vector>

#include "worker/base/atomic_file.hpp"
#include "worker/base/observer.hpp"
#include "worker/dive/finding_log.hpp"
#include "worker/recording/choose_topics.hpp"
#include "worker/recording/message_log.hpp"
#include "worker/recording/read_rig.hpp"

namespace divemesh::recording {

// Whether a dive is named after the file that it was imported from.
enum class Naming { AfterFile, Unnamed };

struct ImportOptions {
    std::filesystem::path recording;
    std::filesystem::path out;                       // folder of the dive, which must not exist
    std::vector<std::filesystem::path> calibration;  // as read_rig() reads it; {}: CameraInfo
    std::optional<double> metres_per_unit;           // of its translations, where that is open
    NamedTopics topics;
    Naming naming = Naming::AfterFile;
    base::Durability durability = base::Durability::Synced;
};

// What came of an import.
struct ImportCounts {
    std::int64_t num_left = 0;
    std::int64_t num_right = 0;
    std::int64_t num_imu = 0;
    std::int64_t num_pressures = 0;
};

// Turns a recording of a robot into a dive in EuRoC layout. Images keep their pixels, numbers their
// values, and times are those of the messages' headers.
class RecordingImport {
public:
    // Opens the recording and chooses its topics. Throws as open_container() does.
    RecordingImport(ImportOptions options, const base::ProgressCallback& progress);

    const std::vector<Topic>& topics() const { return log_.topics(); }
    const ChosenTopics& chosen() const { return chosen_; }
    // Writes the dive. Throws Error{InvalidArgument} if the choice of topics is not clear,
    // Error{BadData} if there is no calibration or no image that can be read, and as DiveWriter
    // does. A message that cannot be read is left out with a warning.
    ImportCounts write(const base::ProgressCallback& progress);
    const std::vector<Finding>& findings() const { return findings_.all(); }

private:
    RigFiles find_rig();
    Rectification rectification() const;
    RigHints hints();

    ImportOptions options_;
    dive::FindingLog findings_;
    MessageLog log_;
    ChosenTopics chosen_;
};

}  // namespace divemesh::recording
