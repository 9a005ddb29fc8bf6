#include "worker/boards/board_recording.hpp"

#include <algorithm>
#include <utility>

#include "schemas/error.hpp"
#include "worker/dive/calibration.hpp"
#include "worker/dive/dive.hpp"
#include "worker/dive/dive_source.hpp"
#include "worker/dive/image.hpp"
#include "worker/dive/image_names.hpp"
#include "worker/dive/sensor_yaml.hpp"

namespace divemesh::boards {
namespace {

constexpr std::int64_t kMaxImage_bytes = std::int64_t{64} << 20;

std::string table_of(const std::string& camera) { return "mav0/" + camera + "/data.csv"; }

// Returns a grey image of that size; empty if the file is missing, damaged or of another size.
cv::Mat load_grey(const dive::DiveFiles& files, const std::string& file, cv::Size size) {
    const auto bytes = files.read(file, kMaxImage_bytes);
    if (!bytes) return {};
    try {
        const dive::ImageHeader header = dive::read_image_header(*bytes);
        if (header.width_px != size.width || header.height_px != size.height) return {};
        return dive::decode_image(*bytes, header, dive::Channels::Grey);
    } catch (const Error& error) {
        if (error.code() != ErrorCode::BadData) throw;
        return {};
    }
}

}  // namespace

BoardRecording::BoardRecording(const std::filesystem::path& path,
                               const std::filesystem::path& scratch,
                               const base::ProgressCallback& progress,
                               Links links)
    : files_(std::make_unique<dive::DiveFiles>(
          dive::open_source(path, scratch, dive::DiveLimits{}, progress, findings_, links))) {
    const auto left = rows_of("cam0");
    const auto right = rows_of("cam1");
    left_size_ = first_size("cam0", left);
    right_size_ = first_size("cam1", right);
    pairs_ = dive::match_pairs(left,
                               right,
                               dive::guess_clock_difference(left, right),
                               dive::common_clock_tolerance_ns(left));
    if (pairs_.empty())
        throw Error(ErrorCode::BadData,
                    "no image of mav0/cam0 has one of the same time in mav0/cam1: record both "
                    "cameras at once, triggered together");
}

std::vector<dive::CameraRow> BoardRecording::rows_of(const std::string& camera) {
    const std::string table = table_of(camera);
    std::vector<dive::CameraRow> rows;
    if (const auto text = files_->read(table, dive::DiveLimits{}.max_file_bytes))
        rows = dive::parse_camera_rows(*text, camera, findings_);
    dive::complete_image_names(rows, *files_, camera, findings_);
    if (rows.empty()) rows = dive::rows_by_image_names(*files_, camera, findings_);
    if (rows.empty())
        throw Error(ErrorCode::BadData,
                    "there are no images of mav0/" + camera +
                        ": put the list of images (timestamp [ns],filename) into " + table +
                        ", or name the images in mav0/" + camera +
                        "/data by their timestamps in nanoseconds");
    return rows;
}

// Returns the size of the first image that is not damaged.
cv::Size BoardRecording::first_size(const std::string& camera,
                                    const std::vector<dive::CameraRow>& rows) const {
    for (const dive::CameraRow& row : rows) {
        const auto bytes = files_->read(row.file, kMaxImage_bytes);
        if (!bytes) continue;
        try {
            const dive::ImageHeader header = dive::read_image_header(*bytes);
            if (header.width_px < 1 || header.height_px < 1 ||
                header.width_px > dive::DiveLimits{}.max_image_pixels / header.height_px)
                continue;
            return {static_cast<int>(header.width_px), static_cast<int>(header.height_px)};
        } catch (const Error& error) {
            if (error.code() != ErrorCode::BadData) throw;
        }
    }
    throw Error(ErrorCode::BadData,
                "no image of mav0/" + camera + " can be read: export the images as PNG");
}

Eigen::Isometry3d BoardRecording::T_body_cam0() const {
    const std::string file = "mav0/cam0/sensor.yaml";
    const auto text = files_->read(file, dive::kMaxYamlBytes);
    if (!text) return Eigen::Isometry3d::Identity();
    dive::FindingLog unused;  // the file may be rough: it is what is replaced
    const auto yaml = dive::parse_sensor_yaml(*text, file, unused);
    if (!yaml) return Eigen::Isometry3d::Identity();
    return dive::rigid_motion(*yaml, file, unused).value_or(Eigen::Isometry3d::Identity());
}

BoardCorners BoardRecording::corners_in(const std::string& file,
                                        cv::Size size,
                                        const Board& board) const {
    const cv::Mat image = load_grey(*files_, file, size);
    return image.empty() ? BoardCorners{} : find_board(image, board);
}

std::vector<BoardView> BoardRecording::find_boards(const Board& board,
                                                   std::size_t max_pairs,
                                                   const base::ProgressShare& progress,
                                                   int num_threads) const {
    const std::size_t num = std::min(max_pairs, pairs_.size());
    std::vector<BoardView> views(num);
    base::for_each_index(num_threads, num, progress, [&](std::size_t i) {
        const dive::FramePair& pair = pairs_[(2 * i + 1) * pairs_.size() / (2 * num)];
        BoardView& view = views[i];
        view.timestamp_ns = pair.timestamp_ns;
        view.left = corners_in(pair.left, left_size_, board);
        view.right = numbered_alike(view.left, corners_in(pair.right, right_size_, board), board);
    });
    std::erase_if(views,
                  [](const BoardView& view) { return view.left.empty() && view.right.empty(); });
    return views;
}

}  // namespace divemesh::boards
