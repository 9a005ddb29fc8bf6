#include "tests/worker/dive/tiny_dive.hpp"

#include <fstream>
#include <iterator>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <sstream>
#include <stdexcept>
#include <vector>

namespace divemesh::dive {
namespace {

std::string png(const cv::Mat& image) {
    std::vector<unsigned char> bytes;
    cv::imencode(".png", image, bytes);
    return {bytes.begin(), bytes.end()};
}

std::string noise_png(int seed) {
    cv::Mat image(48, 64, CV_8UC1);
    cv::RNG random(static_cast<std::uint64_t>(seed));
    random.fill(image, cv::RNG::UNIFORM, 20, 235);
    return png(image);
}

std::string imu_rows() {
    std::ostringstream rows;
    rows << "#timestamp [ns],w_x,w_y,w_z,a_x,a_y,a_z\n";
    for (int i = -10; i < 100; ++i)
        rows << TinyDive::kFirst_ns + i * 5'000'000LL << ",0.01,-0.02,0.03,0.1,0.2,9.8\n";
    return rows.str();
}

constexpr const char* kImuYaml =
    "T_BS: [1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,1]\n"
    "gyroscope_noise_density: 1.7e-4\ngyroscope_random_walk: 2.0e-5\n"
    "accelerometer_noise_density: 2.0e-3\naccelerometer_random_walk: 3.0e-3\n";

std::string truth_rows() {
    std::ostringstream rows;
    rows << "#timestamp, p_x, p_y, p_z, q_w, q_x, q_y, q_z\n";
    for (int i = -1; i < 10; ++i)
        rows << TinyDive::kFirst_ns + i * 50'000'000LL << "," << 0.1 * i << ",0,0,1,0,0,0\n";
    return rows.str();
}

}  // namespace

TinyDive::TinyDive(std::filesystem::path folder) : folder_(std::move(folder)) {
    for (const std::string camera : {"cam0", "cam1"}) {
        const std::string prefix = "mav0/" + camera + "/";
        std::string rows = "#timestamp [ns],filename\n";
        for (int i = 0; i < kNumFrames; ++i) {
            const std::string stamp = std::to_string(kFirst_ns + i * 100'000'000LL);
            rows += stamp + "," + image_name(i) + "\n";
            write(prefix + "data/" + image_name(i), noise_png(i + (camera == "cam1" ? 100 : 0)));
        }
        write(prefix + "data.csv", rows);
        const std::string x = camera == "cam1" ? "0.1" : "0";
        write(prefix + "sensor.yaml",
              camera_yaml("1, 0, 0, " + x + ", 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1"));
    }
    write("mav0/imu0/data.csv", imu_rows());
    write("mav0/imu0/sensor.yaml", kImuYaml);
    write("mav0/state_groundtruth_estimate0/data.csv", truth_rows());
    write("dive.json", R"({"name": "Tiny", "site": "Tank", "tags": ["test"]})");
}

std::string TinyDive::image_name(int index) {
    return std::to_string(kFirst_ns + index * 100'000'000LL) + ".png";
}

std::string TinyDive::read(const std::string& file) const {
    std::ifstream stream(folder_ / file, std::ios::binary);
    if (!stream) throw std::runtime_error("cannot read " + file);
    return {std::istreambuf_iterator<char>(stream), {}};
}

void TinyDive::write(const std::string& file, const std::string& bytes) const {
    const auto path = folder_ / file;
    std::filesystem::create_directories(path.parent_path());
    std::ofstream(path, std::ios::binary) << bytes;
}

void TinyDive::remove(const std::string& file) const {
    std::filesystem::remove_all(folder_ / file);
}

void TinyDive::replace(const std::string& file,
                       const std::string& from,
                       const std::string& to) const {
    std::string text = read(file);
    const std::size_t at = text.find(from);
    if (at == std::string::npos) throw std::runtime_error(file + " does not hold " + from);
    write(file, text.replace(at, from.size(), to));
}

std::string camera_yaml(const std::string& T_body_sensor) {
    return "sensor_type: camera\nT_BS:\n  cols: 4\n  rows: 4\n  data: [" + T_body_sensor +
           "]\nrate_hz: 10\nresolution: [64, 48]\ncamera_model: pinhole\n"
           "intrinsics: [50.0, 50.0, 32.0, 24.0]\ndistortion_model: radial-tangential\n"
           "distortion_coefficients: [-0.1, 0.01, 0.0, 0.0]\n";
}

std::string png_of_size(int width_px, int height_px, int type) {
    cv::Mat image(height_px, width_px, type);
    cv::RNG random(7);
    random.fill(image, cv::RNG::UNIFORM, 0, CV_MAT_DEPTH(type) == CV_16U ? 65535 : 255);
    return png(image);
}

std::string black_png(int width_px, int height_px) {
    return png(cv::Mat::zeros(height_px, width_px, CV_8UC1));
}

}  // namespace divemesh::dive
