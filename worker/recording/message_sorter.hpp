#pragma once

#include "worker/dive/finding_log.hpp"
#include "worker/recording/choose_topics.hpp"
#include "worker/recording/dive_writer.hpp"
#include "worker/recording/message_log.hpp"

namespace divemesh::recording {

// Passes the messages of the chosen topics on to a dive. What cannot be read is left out, what is
// doubtful is used, both with a warning.
class MessageSorter {
public:
    MessageSorter(const std::vector<Topic>& topics,
                  const ChosenTopics& chosen,
                  const RigFiles& rig,
                  DiveWriter& writer,
                  dive::FindingLog& findings);

    void add(const LoggedMessage& message);

private:
    void add_image(Side side, const LoggedMessage& message);
    void add_imu(const LoggedMessage& message);
    void add_pressure(const LoggedMessage& message);
    std::int64_t time_ns(const LoggedMessage& message, const MessageHeader& header);
    void check_size(Side side, const ImageFile& image, const std::string& topic) const;

    const std::vector<Topic>& topics_;
    const ChosenTopics& chosen_;
    const RigFiles& rig_;
    DiveWriter& writer_;
    dive::FindingLog& findings_;
};

}  // namespace divemesh::recording
