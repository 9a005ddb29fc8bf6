#include "worker/io/posed_images.hpp"

#include "tests/worker/io/exported_folder.hpp"

namespace divemesh::io {
namespace {

class PosedImagesTest : public ExportedFolderTest {
protected:
    Error refusal() const {
        return error_of([&] { read_posed_images(open()); });
    }
    void change(const std::string& field, const nlohmann::json& value) const {
        auto document = nlohmann::json::parse(read(file("keyframes.json")));
        document[field] = value;
        write("keyframes.json", document.dump());
    }
};

TEST_F(PosedImagesTest, AMissingImageIsNamed) {
    std::filesystem::remove(file("keyframes/000012.jpg"));

    EXPECT_EQ(refusal().code(), ErrorCode::NotFound);
    EXPECT_NE(std::string(refusal().what()).find("000012.jpg"), std::string::npos);
}

TEST_F(PosedImagesTest, ABrokenImageIsNamed) {
    write("keyframes/000012.jpg", "GIF89a");

    EXPECT_EQ(refusal().code(), ErrorCode::BadData);
    EXPECT_NE(std::string(refusal().what()).find("000012.jpg"), std::string::npos);
}

TEST_F(PosedImagesTest, AnImageOfAnotherSizeIsRefused) {
    write_image(12, 160, 120);

    EXPECT_EQ(refusal().code(), ErrorCode::BadData);
}

TEST_F(PosedImagesTest, ImagesOfAnotherShapeThanTheCamerasAreRefused) {
    change("image_size_px", {640, 640});

    EXPECT_EQ(refusal().code(), ErrorCode::BadData);
}

TEST_F(PosedImagesTest, BrokenCamerasAreRefused) {
    const std::string whole = read(file("keyframes.json"));
    const std::vector<std::pair<std::string, nlohmann::json>> broken = {
        {"focal_px", 0},
        {"focal_px", "long"},
        {"principal_point_px", {1}},
        {"image_size_px", {0, 0}},
        {"image_size_px", nullptr},
        {"keyframes", nlohmann::json::array()},
        {"keyframes", 7}};
    for (const auto& [field, value] : broken) {
        write("keyframes.json", whole);
        change(field, value);
        EXPECT_EQ(refusal().code(), ErrorCode::BadData) << field << " " << value;
        EXPECT_NE(std::string(refusal().what()).find("keyframes.json"), std::string::npos);
    }
    write("keyframes.json", "[");
    EXPECT_EQ(refusal().code(), ErrorCode::BadData);
    std::filesystem::remove(file("keyframes.json"));
    EXPECT_EQ(refusal().code(), ErrorCode::NotFound);
}

TEST_F(PosedImagesTest, AFrameThatIsThereTwiceIsRefused) {
    auto document = nlohmann::json::parse(read(file("keyframes.json")));
    document["keyframes"].push_back(document["keyframes"][0]);
    write("keyframes.json", document.dump());

    EXPECT_EQ(refusal().code(), ErrorCode::BadData);
}

}  // namespace
}  // namespace divemesh::io
