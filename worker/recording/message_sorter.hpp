#pragma once

#include <array>
#include <functional>

#include "worker/dive/finding_log.hpp"
#include "worker/recording/choose_topics.hpp"
#include "worker/recording/dive_writer.hpp"
#include "worker/recording/message_log.hpp"
#include "worker/video/access_unit_decoder.hpp"

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
    // Passes on what decoders of video still have. No message may follow.
    void finish();

private:
    void add_image(Side side, const LoggedMessage& message);
    void add_video(Side side, const LoggedMessage& message);
    void finish_video(Side side, std::size_t topic);
    void leave_out_unreadable(std::size_t topic,
                              std::int64_t log_time_ns,
                              const std::function<void()>& read);
    void write_frames(Side side,
                      const std::vector<video::VideoFrame>& frames,
                      const std::string& topic);
    void write(Side side,
               std::int64_t timestamp_ns,
               const ImageFile& image,
               const std::string& topic);
    video::AccessUnitDecoder& decoder_of(Side side) {
        return decoders_[side == Side::Left ? 0 : 1];
    }
    void add_imu(const LoggedMessage& message);
    void add_pressure(const LoggedMessage& message);
    std::int64_t time_ns(const LoggedMessage& message, const MessageHeader& header);
    void check_size(Side side,
                    std::int64_t width_px,
                    std::int64_t height_px,
                    const std::string& topic) const;

    const std::vector<Topic>& topics_;
    const ChosenTopics& chosen_;
    const RigFiles& rig_;
    DiveWriter& writer_;
    dive::FindingLog& findings_;
    std::int64_t last_time_ns_ = 0;
    std::array<video::AccessUnitDecoder, 2> decoders_;  // of the cameras whose images are video
};

}  // namespace divemesh::recording
