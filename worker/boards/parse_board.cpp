#include <cmath>
#include <string>

#include "schemas/error.hpp"
#include "worker/boards/board.hpp"
#include "worker/dive/entry_name.hpp"
#include "worker/dive/yaml_document.hpp"

namespace divemesh::boards {
namespace {

constexpr int kMaxNodes = 200;        // a target file has at most a dozen
constexpr int kMinCorners = 3;        // in a row: two do not tell a checkerboard from other squares
constexpr int kMaxColumns = 50;       // more squares than a camera of 64 megapixels resolves well
constexpr int kMaxTags = 587;         // of family tag36h11
constexpr double kMinStep_m = 0.001;  // of a printed square
constexpr double kMaxStep_m = 2.0;
constexpr double kMaxGap = 2.0;  // between tags, in edges of a tag

// The values of a target file, with messages that name it.
class TargetFile {
public:
    TargetFile(std::string_view text, const std::string& file) : file_(file) {
        try {
            root_ = dive::load_yaml(text, kMaxNodes);
            if (!root_.IsMap()) refuse("it has no keys such as target_type");
        } catch (const YAML::Exception& error) {
            refuse("it cannot be read: " + dive::printable(error.msg));
        }
    }

    std::string kind() const { return dive::text_at(root_, "target_type"); }

    int count(const char* key, int min, int max) const {
        const double value = number(key);
        if (value != std::floor(value) || value < min || value > max)
            refuse(std::string(key) + " has to be a whole number from " + std::to_string(min) +
                   " to " + std::to_string(max));
        return static_cast<int>(value);
    }

    double number_between(const char* key, double min, double max, const char* what) const {
        const double value = number(key);
        if (!(value >= min && value <= max)) refuse(std::string(key) + " has to be " + what);
        return value;
    }

    [[noreturn]] void refuse(const std::string& what) const {
        throw Error(ErrorCode::BadData,
                    dive::printable(file_) + ": " + what +
                        "; write the target file as Kalibr does: target_type: 'checkerboard' with "
                        "targetCols, targetRows, colSpacingMeters and rowSpacingMeters, or "
                        "target_type: 'aprilgrid' with tagCols, tagRows, tagSize and tagSpacing");
    }

private:
    double number(const char* key) const {
        try {
            if (const auto value = dive::number_at(root_, key)) return *value;
        } catch (const YAML::Exception& error) {
            refuse(std::string(key) + " is not a number: " + dive::printable(error.msg));
        }
        refuse(std::string("it does not state ") + key);
    }

    std::string file_;
    YAML::Node root_;
};

constexpr const char* kStepWords = "in metres, from 0.001 to 2: measure the print";

Board checkerboard(const TargetFile& target) {
    Board board;
    board.num_columns = target.count("targetCols", kMinCorners, kMaxColumns);
    board.num_rows = target.count("targetRows", kMinCorners, kMaxColumns);
    board.column_step_m =
        target.number_between("colSpacingMeters", kMinStep_m, kMaxStep_m, kStepWords);
    board.row_step_m =
        target.number_between("rowSpacingMeters", kMinStep_m, kMaxStep_m, kStepWords);
    return board;
}

Board april_grid(const TargetFile& target) {
    Board board;
    board.kind = BoardKind::AprilGrid;
    board.num_columns = target.count("tagCols", 1, kMaxColumns);
    board.num_rows = target.count("tagRows", 1, kMaxColumns);
    if (board.num_columns * board.num_rows > kMaxTags)
        target.refuse("tagCols times tagRows is more than the 587 tags of the family tag36h11");
    board.tag_size_m = target.number_between("tagSize", kMinStep_m, kMaxStep_m, kStepWords);
    const double gap = target.number_between(
        "tagSpacing", 0.0, kMaxGap, "the gap between tags over the edge of a tag, from 0 to 2");
    board.column_step_m = board.row_step_m = (1.0 + gap) * board.tag_size_m;
    return board;
}

}  // namespace

Board parse_board(std::string_view text, const std::string& file) {
    const TargetFile target(text, file);
    const std::string kind = target.kind();
    if (kind == "checkerboard") return checkerboard(target);
    if (kind == "aprilgrid") return april_grid(target);
    const std::string stated = kind.empty() ? "missing" : dive::printable(kind);
    target.refuse("target_type is " + stated +
                  ": checkerboard and aprilgrid are read, ChArUco and grids of circles are not");
}

}  // namespace divemesh::boards
