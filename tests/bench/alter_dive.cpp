// Writes a dive with errors put into its calibration: what an estimator has to find again.
//
//     alter_dive DIVE OUT [--time-offset-ms 8] [--rotation-deg 0.6,-0.5,0.6] [--k1-scale 1.1]
//
// Images are hard links where the file system allows. The time offset moves the stamps of imu0
// and ahrs0 (t_imu = t_cam + offset), the rotation turns T_BS of both cameras about the body's
// origin, the scale goes to k1 of both cameras.

#include <CLI/CLI.hpp>
#include <Eigen/Geometry>
#include <filesystem>
#include <fstream>
#include <iomanip>
#include <iostream>
#include <numbers>
#include <regex>
#include <sstream>
#include <stdexcept>
#include <vector>

namespace divemesh::bench {
namespace {

namespace fs = std::filesystem;

struct Errors {
    double time_offset_ms = 0.0;
    std::vector<double> rotation_deg = {0.0, 0.0, 0.0};  // Rodrigues vector in the body
    double k1_scale = 1.0;
};

std::string read(const fs::path& file) {
    std::ifstream stream(file, std::ios::binary);
    if (!stream) throw std::runtime_error("cannot read " + file.string());
    return {std::istreambuf_iterator<char>(stream), {}};
}

void write(const fs::path& file, const std::string& text) {
    fs::create_directories(file.parent_path());
    std::ofstream stream(file, std::ios::binary);
    stream << text;
    if (!stream.flush()) throw std::runtime_error("cannot write " + file.string());
}

// Every stamp, the first column, later by `shift_ns`.
std::string shift_stamps(const std::string& csv, std::int64_t shift_ns) {
    std::istringstream lines(csv);
    std::string result;
    for (std::string line; std::getline(lines, line);) {
        const auto comma = line.find(',');
        if (line.empty() || line[0] == '#' || comma == std::string::npos)
            result += line + "\n";
        else
            result += std::to_string(std::stoll(line) + shift_ns) + line.substr(comma) + "\n";
    }
    return result;
}

// Replaces the numbers of `key: [...]` by what `change` makes of them.
template <typename Change>
std::string change_numbers(const std::string& yaml, const std::string& key, const Change& change) {
    std::smatch found;
    if (!std::regex_search(yaml, found, std::regex(key + ":\\s*\\[([^\\]]*)\\]")))
        throw std::runtime_error("no " + key + " in sensor.yaml");
    std::vector<double> numbers;
    std::istringstream items(found[1].str());
    for (std::string item; std::getline(items, item, ',');) numbers.push_back(std::stod(item));
    change(numbers);
    std::ostringstream list;
    list << std::setprecision(15);
    for (std::size_t i = 0; i < numbers.size(); ++i) list << (i > 0 ? ", " : "") << numbers[i];
    return found.prefix().str() + key + ": [" + list.str() + "]" + found.suffix().str();
}

std::string alter_camera(const std::string& yaml, const Errors& errors) {
    const Eigen::Vector3d w =
        Eigen::Vector3d::Map(errors.rotation_deg.data()) * std::numbers::pi / 180.0;
    Eigen::Matrix4d turn = Eigen::Matrix4d::Identity();
    if (w.norm() > 0.0)
        turn.topLeftCorner<3, 3>() = Eigen::AngleAxisd(w.norm(), w.normalized()).toRotationMatrix();
    const std::string turned = change_numbers(yaml, "data", [&](std::vector<double>& numbers) {
        Eigen::Map<Eigen::Matrix<double, 4, 4, Eigen::RowMajor>> T(numbers.data());
        T = (turn * T).eval();
    });
    return change_numbers(turned, "distortion_coefficients", [&](std::vector<double>& numbers) {
        numbers.front() *= errors.k1_scale;
    });
}

void link_files(const fs::path& from, const fs::path& to) {
    fs::create_directories(to);
    for (const auto& entry : fs::directory_iterator(from)) {
        std::error_code failure;
        fs::create_hard_link(entry.path(), to / entry.path().filename(), failure);
        if (failure) fs::copy_file(entry.path(), to / entry.path().filename());
    }
}

void alter(const fs::path& dive, const fs::path& out, const Errors& errors) {
    const auto shift_ns = static_cast<std::int64_t>(errors.time_offset_ms * 1e6);
    for (const auto& entry : fs::directory_iterator(dive / "mav0")) {
        const std::string name = entry.path().filename();
        const fs::path to = out / "mav0" / name;
        if (name == "cam0" || name == "cam1") {
            write(to / "sensor.yaml", alter_camera(read(entry.path() / "sensor.yaml"), errors));
            write(to / "data.csv", read(entry.path() / "data.csv"));
            link_files(entry.path() / "data", to / "data");
        } else if (name == "imu0" || name == "ahrs0") {
            write(to / "data.csv", shift_stamps(read(entry.path() / "data.csv"), shift_ns));
            if (fs::exists(entry.path() / "sensor.yaml"))
                write(to / "sensor.yaml", read(entry.path() / "sensor.yaml"));
        } else {
            fs::create_directories(to.parent_path());
            fs::copy(entry.path(), to, fs::copy_options::recursive);
        }
    }
    for (const auto& entry : fs::directory_iterator(dive))
        if (entry.is_regular_file()) fs::copy(entry.path(), out / entry.path().filename());
}

}  // namespace
}  // namespace divemesh::bench

int main(int argc, char** argv) {
    using namespace divemesh::bench;
    fs::path dive;
    fs::path out;
    Errors errors;
    CLI::App app{"Writes a dive with errors put into its calibration."};
    app.add_option("dive", dive, "folder with mav0/")->required();
    app.add_option("out", out, "folder to write; must not exist")->required();
    app.add_option("--time-offset-ms",
                   errors.time_offset_ms,
                   "offset added to the IMU's timestamps: t_imu = t_cam + offset");
    app.add_option("--rotation-deg",
                   errors.rotation_deg,
                   "error of the cameras' orientation in the body frame")
        ->delimiter(',')
        ->expected(3);
    app.add_option("--k1-scale", errors.k1_scale, "factor on k1 of both cameras");
    CLI11_PARSE(app, argc, argv);
    try {
        if (fs::exists(out)) throw std::runtime_error(out.string() + " is already there");
        alter(dive, out, errors);
    } catch (const std::exception& error) {
        std::cerr << error.what() << "\n";
        return 1;
    }
    return 0;
}
