#pragma once

#include <Eigen/Geometry>
#include <filesystem>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <vector>

#include "schemas/links.hpp"
#include "worker/base/parallel.hpp"
#include "worker/boards/find_board.hpp"
#include "worker/dive/dive_files.hpp"
#include "worker/dive/finding_log.hpp"
#include "worker/dive/frame_list.hpp"

namespace divemesh::boards {

// A board in a stereo pair; empty corners: that camera does not see it.
struct BoardView {
    std::int64_t timestamp_ns = 0;
    BoardCorners left;
    BoardCorners right;
};

// The stereo pairs of a dive in EuRoC layout, whose sensor.yaml may be missing: images are taken as
// they are, all of the size of their camera's first one.
class BoardRecording {
public:
    // Opens a folder or an archive. Throws as dive::open_source does, and Error{BadData} with what
    // to do if it holds no pairs.
    BoardRecording(const std::filesystem::path& path,
                   const std::filesystem::path& scratch,
                   const base::ProgressCallback& progress,
                   Links links = Links::LeaveOut);

    cv::Size left_size() const { return left_size_; }
    cv::Size right_size() const { return right_size_; }
    std::size_t num_pairs() const { return pairs_.size(); }
    // Returns T_BS of cam0 as its sensor.yaml states it, so that the body stays where it is; the
    // identity where none is stated.
    Eigen::Isometry3d T_body_cam0() const;

    // Searches at most `max_pairs` pairs, spread over the recording, and returns those in which a
    // camera sees the board, in the order of time. The result does not depend on `num_threads`.
    std::vector<BoardView> find_boards(const Board& board,
                                       std::size_t max_pairs,
                                       const base::ProgressShare& progress,
                                       int num_threads) const;
    const std::vector<Finding>& findings() const { return findings_.all(); }

private:
    std::vector<dive::CameraRow> rows_of(const std::string& camera);
    cv::Size first_size(const std::string& camera, const std::vector<dive::CameraRow>& rows) const;
    BoardCorners corners_in(const std::string& file, cv::Size size, const Board& board) const;

    dive::FindingLog findings_;
    std::unique_ptr<dive::DiveFiles> files_;
    std::vector<dive::FramePair> pairs_;
    cv::Size left_size_;
    cv::Size right_size_;
};

}  // namespace divemesh::boards
