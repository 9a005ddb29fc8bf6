#include "worker/recording/dive_writer.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fcntl.h>
#include <map>
#include <nlohmann/json.hpp>
#include <unistd.h>
#include <utility>

#include "schemas/error.hpp"
#include "schemas/file_descriptor.hpp"
#include "schemas/json.hpp"

namespace divemesh::recording {
namespace {

namespace fs = std::filesystem;

const char* folder_of(Side side) { return side == Side::Left ? "cam0" : "cam1"; }

// Returns the shortest text that gives exactly this number when it is read.
std::string exact(double value) {
    char text[32];
    return {text, std::to_chars(text, text + sizeof text, value).ptr};
}

void make_folder(const fs::path& folder) {
    std::error_code failure;
    fs::create_directories(folder, failure);
    if (failure)
        throw Error(ErrorCode::Unavailable,
                    "cannot make the folder " + folder.string() + ": " + failure.message() +
                        ": choose another one by --out");
}

void check_is_free(const fs::path& out) {
    std::error_code failure;
    if (!fs::exists(out, failure)) return;
    if (fs::is_directory(out, failure) && fs::is_empty(out, failure)) return;
    throw Error(ErrorCode::Conflict,
                out.string() + " exists: choose a new folder by --out, or remove it");
}

// Returns an object for one source, a list of them for several.
template <typename Sample>
void sort_by_time(std::vector<Sample>& samples) {
    std::stable_sort(samples.begin(), samples.end(), [](const Sample& a, const Sample& b) {
        return a.timestamp_ns < b.timestamp_ns;
    });
}

// Waits until everything on the folder's disk is written: syncing each of many images takes longer.
void sync_disk_of(const fs::path& folder) {
    const FileDescriptor opened(open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
    if (!opened.is_open() || syncfs(opened.get()) != 0)
        throw Error(ErrorCode::Unavailable,
                    "cannot write " + folder.string() + " to the disk: check the disk");
}

// Returns an angle to a centimetre on the ground.
double rounded_deg(double angle_deg) { return std::round(angle_deg * 1e7) / 1e7; }

std::string dive_json(const Provenance& provenance) {
    nlohmann::json files = nlohmann::json::array();
    for (const ImportedFile& file : provenance.files) {
        nlohmann::json entry = {{"sha256", file.sha256}, {"size_bytes", file.size_bytes}};
        if (!file.name.empty()) entry["file"] = file.name;
        files.push_back(std::move(entry));
    }
    nlohmann::json info = {
        {"imported_from", {{"files", std::move(files)}, {"findings", provenance.findings}}}};
    if (!provenance.name.empty()) info["name"] = provenance.name;
    if (provenance.position)
        info["position"] = {{"latitude_deg", rounded_deg(provenance.position->latitude_deg)},
                            {"longitude_deg", rounded_deg(provenance.position->longitude_deg)}};
    return info.dump(1, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
}

}  // namespace

DiveWriter::DiveWriter(fs::path out, base::Durability durability)
    : out_(std::move(out)), durability_(durability) {
    if (!out_.has_filename()) out_ = out_.parent_path();  // a slash at the end
    partial_ = out_.string() + ".partial";
    check_is_free(out_);
    std::error_code ignored;
    fs::remove_all(partial_, ignored);
    for (const char* folder : {"cam0", "cam1"}) make_folder(partial_ / "mav0" / folder / "data");
}

DiveWriter::~DiveWriter() {
    std::error_code ignored;
    fs::remove_all(partial_, ignored);
}

bool DiveWriter::add_image(Side side, std::int64_t timestamp_ns, const ImageFile& image) {
    Names& names = side == Side::Left ? left_ : right_;
    const std::string name = std::to_string(timestamp_ns) + image.extension();
    if (!names.emplace(timestamp_ns, name).second) return false;
    base::write_file(partial_ / "mav0" / folder_of(side) / "data" / name,
                     image.bytes,
                     base::Durability::Unsynced);
    return true;
}

void DiveWriter::move_imu(std::int64_t by_ns) {
    std::vector<types::ImuSample> moved;
    moved.reserve(imu_.size());
    for (types::ImuSample sample : imu_)
        if (!__builtin_add_overflow(sample.timestamp_ns, by_ns, &sample.timestamp_ns) &&
            sample.timestamp_ns >= 0)
            moved.push_back(sample);
    imu_ = std::move(moved);
}

std::int64_t DiveWriter::num_images(Side side) const {
    return std::ssize(side == Side::Left ? left_ : right_);
}

void DiveWriter::commit(const RigFiles& rig, const Provenance& provenance) {
    write_camera(Side::Left, rig.cam0_yaml);
    write_camera(Side::Right, rig.cam1_yaml);
    if (rig.imu_yaml && !imu_.empty()) write_imu(*rig.imu_yaml);
    if (!pressure_.empty()) write_pressure();
    base::write_file(partial_ / "dive.json", dive_json(provenance));
    if (durability_ == base::Durability::Synced) sync_disk_of(partial_);
    std::error_code failure;
    fs::rename(partial_, out_, failure);  // replaces an empty folder
    if (failure)
        throw Error(ErrorCode::Unavailable,
                    "cannot give the dive its name " + out_.string() + ": " + failure.message() +
                        ": choose another one by --out");
    if (durability_ == base::Durability::Synced) sync_disk_of(out_);
}

void DiveWriter::write_camera(Side side, const std::string& yaml) const {
    const Names& names = side == Side::Left ? left_ : right_;
    std::string rows = "#timestamp [ns],filename\n";
    for (const auto& [timestamp_ns, name] : std::map(names.begin(), names.end())) {
        rows += std::to_string(timestamp_ns);
        rows += ',';
        rows += name;
        rows += '\n';
    }
    const fs::path folder = partial_ / "mav0" / folder_of(side);
    base::write_file(folder / "data.csv", rows);
    if (!yaml.empty()) base::write_file(folder / "sensor.yaml", yaml);
}

void DiveWriter::write_imu(const std::string& yaml) {
    sort_by_time(imu_);
    std::string rows =
        "#timestamp [ns],w_RS_S_x [rad s^-1],w_RS_S_y [rad s^-1],w_RS_S_z [rad s^-1],"
        "a_RS_S_x [m s^-2],a_RS_S_y [m s^-2],a_RS_S_z [m s^-2]\n";
    for (const types::ImuSample& sample : imu_) {
        rows += std::to_string(sample.timestamp_ns);
        for (const auto* vector : {&sample.angular_velocity_imu, &sample.acceleration_imu})
            for (const double value : *vector) {
                rows += ',';
                rows += exact(value);
            }
        rows += '\n';
    }
    make_folder(partial_ / "mav0" / "imu0");
    base::write_file(partial_ / "mav0" / "imu0" / "data.csv", rows);
    base::write_file(partial_ / "mav0" / "imu0" / "sensor.yaml", yaml);
}

void DiveWriter::write_pressure() {
    sort_by_time(pressure_);
    std::string rows = "#timestamp [ns],depth [m]\n";
    for (const types::PressureSample& sample : pressure_) {
        rows += std::to_string(sample.timestamp_ns);
        rows += ',';
        rows += exact(sample.depth_m);
        rows += '\n';
    }
    make_folder(partial_ / "mav0" / "pressure0");
    base::write_file(partial_ / "mav0" / "pressure0" / "data.csv", rows);
}

}  // namespace divemesh::recording
