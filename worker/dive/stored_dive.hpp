#pragma once

#include <deque>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "worker/dive/dive_contents.hpp"
#include "worker/dive/frame_reader.hpp"
#include "worker/dive/repeated_images.hpp"

namespace divemesh::dive {

// A dive read from a folder or an archive; Dive::open() returns one.
class StoredDive : public Dive {
public:
    StoredDive(const std::filesystem::path& path,
               const std::filesystem::path& scratch,
               const DiveLimits& limits,
               const base::ProgressCallback& progress,
               Links links = Links::LeaveOut);

    const types::Rig& rig() const override { return contents_.rig; }
    int num_frames() const override { return static_cast<int>(contents_.frames.pairs.size()); }
    const std::vector<types::ImuSample>& imu() const override { return contents_.imu; }
    const std::vector<types::OrientationSample>& ahrs() const override { return contents_.ahrs; }
    const std::vector<types::PressureSample>& pressure() const override {
        return contents_.pressure;
    }
    const cv::Mat& fixed_pattern() const override { return contents_.fixed_pattern; }
    std::optional<types::StereoFrame> next_frame() override;
    std::optional<types::StereoFrame> frame(int index) const override;
    cv::Mat left_in_color(int frame_index, int reduction) const override;
    void rewind() override {
        reader_.rewind();
        first_.clear();
        has_begun_ = false;
        repeated_left_ = {};
        repeated_right_ = {};
    }
    std::int64_t num_skipped_frames() const override { return std::ssize(skipped_); }

    const DiveInfo& info() const override { return contents_.info; }
    const std::vector<Finding>& findings() const override { return findings_.all(); }
    const std::string& content_sha256() const override { return content_hash().sha256; }
    const ContentHash& content_hash() const override;
    double duration_s() const override;
    const types::Trajectory& ground_truth() const override { return contents_.ground_truth; }
    const types::OutsidePositions& outside() const override { return contents_.outside; }
    const std::vector<KnownDistance>& known_distances() const override {
        return contents_.known_distances;
    }
    const std::optional<MarkerPlan>& markers() const override { return contents_.markers; }
    std::optional<types::Mesh> read_reference_mesh() const override;
    std::optional<types::Mesh> read_scene_mesh() const override;

    // Hashes the files that are not hashed yet, with progress.
    void hash_contents(const base::ProgressCallback& progress) const;
    FindingLog& log() { return findings_; }

private:
    LoadedPair load(int index, Eyes eyes = Eyes::Both) const;
    void report_other_dives();
    void pair_images();
    std::optional<types::Mesh> read_mesh(const char* file) const;
    void check_mesh(const char* file);
    void check_first_images();
    types::StereoFrame frame_of(LoadedPair pair) const;
    std::optional<LoadedPair> next_pair();
    void leave_out_repeated(LoadedPair& pair);
    void report_skipped(const LoadedPair& pair);

    FindingLog findings_;
    DiveLimits limits_;
    DiveFiles files_;
    DiveContents contents_;
    FrameReader reader_;            // after the members that its threads use
    std::deque<LoadedPair> first_;  // read ahead at the beginning
    bool has_begun_ = false;
    RepeatedImages repeated_left_;
    RepeatedImages repeated_right_;
    std::set<int> skipped_;
    bool has_reported_16_bit_ = false;
    mutable ContentHash content_hash_;  // computed on first use
};

}  // namespace divemesh::dive
