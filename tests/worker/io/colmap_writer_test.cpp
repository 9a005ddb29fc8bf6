#include "worker/io/colmap_writer.hpp"

#include <algorithm>
#include <cstring>
#include <sstream>

#include "tests/worker/io/exported_folder.hpp"
#include "worker/io/exports.hpp"

namespace divemesh::io {
namespace {

// A model of COLMAP, read by the description of its format alone.
struct SparseModel {
    struct Camera {
        std::uint64_t width_px = 0;
        std::uint64_t height_px = 0;
        double fx = 0.0, fy = 0.0, cx = 0.0, cy = 0.0;
        bool operator==(const Camera&) const = default;
    };
    struct Image {
        double qw = 0.0, qx = 0.0, qy = 0.0, qz = 0.0, tx = 0.0, ty = 0.0, tz = 0.0;
        std::uint32_t camera = 0;
        std::string name;
        bool operator==(const Image&) const = default;

        // x right, y down, z forward
        Eigen::Vector3d point_cam(const Eigen::Vector3d& p_world) const {
            return Eigen::Quaterniond(qw, qx, qy, qz) * p_world + Eigen::Vector3d(tx, ty, tz);
        }
    };
    struct Point {
        double x = 0.0, y = 0.0, z = 0.0;
        int r = 0, g = 0, b = 0;
        double error = 0.0;
        bool operator==(const Point&) const = default;
    };
    std::map<std::uint32_t, Camera> cameras;
    std::map<std::uint32_t, Image> images;
    std::map<std::uint64_t, Point> points;
    bool operator==(const SparseModel&) const = default;
};

// The values of a little-endian file one after another.
class Values {
public:
    explicit Values(std::string bytes) : bytes_(std::move(bytes)) {}
    template <typename Value>
    Value next() {
        Value value{};
        EXPECT_LE(at_ + sizeof value, bytes_.size());
        std::memcpy(&value, bytes_.data() + at_, sizeof value);
        at_ += sizeof value;
        return value;
    }
    std::string text() {
        const std::string text = bytes_.c_str() + at_;
        at_ += text.size() + 1;
        return text;
    }
    bool at_end() const { return at_ == bytes_.size(); }

private:
    std::string bytes_;
    std::size_t at_ = 0;
};

class ColmapWriterTest : public ExportedFolderTest {
protected:
    std::string stored(const std::string& name) const {
        return read(file("colmap/sparse/0/" + name));
    }

    void read_binary_cameras(SparseModel& model) const {
        Values values(stored("cameras.bin"));
        for (auto left = values.next<std::uint64_t>(); left > 0; --left) {
            SparseModel::Camera& camera = model.cameras[values.next<std::uint32_t>()];
            EXPECT_EQ(values.next<std::int32_t>(), 1) << "not PINHOLE";
            camera.width_px = values.next<std::uint64_t>();
            camera.height_px = values.next<std::uint64_t>();
            for (double* value : {&camera.fx, &camera.fy, &camera.cx, &camera.cy})
                *value = values.next<double>();
        }
        EXPECT_TRUE(values.at_end());
    }
    void read_binary_images(SparseModel& model) const {
        Values values(stored("images.bin"));
        for (auto left = values.next<std::uint64_t>(); left > 0; --left) {
            SparseModel::Image& image = model.images[values.next<std::uint32_t>()];
            for (double* value :
                 {&image.qw, &image.qx, &image.qy, &image.qz, &image.tx, &image.ty, &image.tz})
                *value = values.next<double>();
            image.camera = values.next<std::uint32_t>();
            image.name = values.text();
            EXPECT_EQ(values.next<std::uint64_t>(), 0U) << "2D points";
        }
        EXPECT_TRUE(values.at_end());
    }
    void read_binary_points(SparseModel& model) const {
        Values values(stored("points3D.bin"));
        for (auto left = values.next<std::uint64_t>(); left > 0; --left) {
            SparseModel::Point& point = model.points[values.next<std::uint64_t>()];
            for (double* value : {&point.x, &point.y, &point.z}) *value = values.next<double>();
            for (int* value : {&point.r, &point.g, &point.b}) *value = values.next<std::uint8_t>();
            point.error = values.next<double>();
            EXPECT_EQ(values.next<std::uint64_t>(), 0U) << "track";
        }
        EXPECT_TRUE(values.at_end());
    }
    SparseModel read_binary() const {
        SparseModel model;
        read_binary_cameras(model);
        read_binary_images(model);
        read_binary_points(model);
        return model;
    }

    // Returns the lines of a text file that are no comments.
    std::vector<std::string> lines(const std::string& name) const {
        std::istringstream stream(stored(name));
        std::vector<std::string> lines;
        for (std::string line; std::getline(stream, line);)
            if (!line.starts_with('#')) lines.push_back(line);
        return lines;
    }
    SparseModel read_text() const {
        SparseModel model;
        for (const std::string& line : lines("cameras.txt")) {
            std::istringstream words(line);
            std::uint32_t id = 0;
            std::string name;
            words >> id >> name;
            EXPECT_EQ(name, "PINHOLE");
            SparseModel::Camera& camera = model.cameras[id];
            words >> camera.width_px >> camera.height_px >> camera.fx >> camera.fy >> camera.cx >>
                camera.cy;
        }
        const std::vector<std::string> of_images = lines("images.txt");
        EXPECT_EQ(of_images.size() % 2, 0U);
        for (std::size_t i = 0; i + 1 < of_images.size(); i += 2) {
            std::istringstream words(of_images[i]);
            std::uint32_t id = 0;
            words >> id;
            SparseModel::Image& image = model.images[id];
            words >> image.qw >> image.qx >> image.qy >> image.qz >> image.tx >> image.ty >>
                image.tz >> image.camera >> image.name;
            EXPECT_TRUE(of_images[i + 1].empty());
        }
        for (const std::string& line : lines("points3D.txt")) {
            std::istringstream words(line);
            std::uint64_t id = 0;
            words >> id;
            SparseModel::Point& point = model.points[id];
            words >> point.x >> point.y >> point.z >> point.r >> point.g >> point.b >> point.error;
        }
        return model;
    }

    std::vector<std::string> export_it() const {
        return export_reconstruction(open(), {ExportFormat::Colmap}, std::nullopt, file(""));
    }
};

TEST_F(ColmapWriterTest, ItsCameraSeesAPointWhereOursDoes) {
    EXPECT_EQ(export_it(), (std::vector<std::string>{"colmap", "certificate.json"}));

    const SparseModel model = read_binary();

    ASSERT_EQ(model.cameras.size(), 1U);
    ASSERT_EQ(model.images.size(), 3U);
    for (std::uint32_t id = 1; id <= 3; ++id) {
        const SparseModel::Image& image = model.images.at(id);
        const SparseModel::Camera& camera = model.cameras.at(image.camera);
        const Eigen::Vector3d p = image.point_cam(point_in_sight());
        const Eigen::Vector2d pixel(camera.fx * p.x() / p.z() + camera.cx,
                                    camera.fy * p.y() / p.z() + camera.cy);
        EXPECT_NEAR(p.z(), 1.4, 0.2);
        EXPECT_LT((pixel - small_pixel(id - 1, point_in_sight())).norm(), 1e-9);
    }
    EXPECT_EQ(model.images.at(3).name, "1234567.jpg");
    EXPECT_EQ(model.cameras.at(1).width_px, 320U);
    EXPECT_EQ(model.cameras.at(1).height_px, 240U);
}

TEST_F(ColmapWriterTest, ItsPointsAreThoseOfTheCloudInMetres) {
    export_it();

    const SparseModel model = read_binary();

    ASSERT_EQ(model.points.size(), 3U);
    EXPECT_EQ(model.points.at(2), (SparseModel::Point{0.4F, -0.5F, 0.6F, 10, 20, 30, -1.0}));
}

TEST_F(ColmapWriterTest, TextAndBinaryAreTheSameModel) {
    export_it();

    EXPECT_EQ(read_text(), read_binary());
}

TEST_F(ColmapWriterTest, CopiesTheImagesAndStatesTheVerdict) {
    export_it();

    for (const char* name : {"000003.jpg", "000012.jpg", "1234567.jpg"})
        EXPECT_EQ(read(file("colmap/images") / name), read(file("keyframes") / name));
    for (const char* name : {"cameras.txt", "images.txt", "points3D.txt"})
        EXPECT_NE(stored(name).find("# divemesh 0.1.0; verdict: usable with restrictions: path"),
                  std::string::npos)
            << name;
    EXPECT_EQ(nlohmann::json::parse(read(file("colmap/certificate.json")))["dive"]["name"], "reef");
}

// Returns what a program prints; empty if it fails or is not there.
std::string output_of(const std::string& command) {
    const std::unique_ptr<FILE, int (*)(FILE*)> pipe(popen((command + " 2>&1").c_str(), "r"),
                                                     [](FILE* stream) { return pclose(stream); });
    std::string output;
    char bytes[4096];
    while (const std::size_t size = std::fread(bytes, 1, sizeof bytes, pipe.get()))
        output.append(bytes, size);
    return output;
}

// Returns the model that COLMAP itself makes of ours.
class ColmapItselfTest : public ColmapWriterTest {
protected:
    void SetUp() override {
        if (output_of("command -v colmap").empty()) GTEST_SKIP() << "install colmap for this test";
        export_it();
    }
    std::string path() const { return "'" + file("colmap/sparse/0").string() + "'"; }
};

TEST_F(ColmapItselfTest, ReadsTheBinaryModel) {
    const std::string analysis = output_of("colmap model_analyzer --path " + path());

    EXPECT_NE(analysis.find("Cameras: 1"), std::string::npos) << analysis;
    EXPECT_NE(analysis.find("Registered images: 3"), std::string::npos) << analysis;
    EXPECT_NE(analysis.find("Points: 3"), std::string::npos) << analysis;
}

TEST_F(ColmapItselfTest, MakesTheSameBinaryModelOfTheText) {
    const SparseModel ours = read_binary();
    for (const char* name : {"cameras.bin", "images.bin", "points3D.bin"})
        std::filesystem::remove(file("colmap/sparse/0") / name);

    const std::string said = output_of("colmap model_converter --output_type BIN --input_path " +
                                       path() + " --output_path " + path());

    const SparseModel theirs = read_binary();
    EXPECT_EQ(theirs.cameras, ours.cameras) << said;
    EXPECT_EQ(theirs.points, ours.points);
    ASSERT_EQ(theirs.images.size(), ours.images.size());
    for (const auto& [id, image] : ours.images) {
        EXPECT_EQ(theirs.images.at(id).name, image.name);
        EXPECT_LT(
            (theirs.images.at(id).point_cam(point_in_sight()) - image.point_cam(point_in_sight()))
                .norm(),
            1e-12);
    }
}

}  // namespace
}  // namespace divemesh::io
