#include "worker/io/tiff_directory.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <memory>
#include <tiffio.h>

#include "tests/worker/io/test_files.hpp"

namespace divemesh::io {
namespace {

constexpr std::array<std::uint8_t, 6> kPixels = {1, 2, 3, 4, 5, 6};

// A grey image of 3 x 2 pixels, without compression, after the header of its variant.
class TiffDirectoryTest : public FileTest, public testing::WithParamInterface<TiffVariant> {
protected:
    std::string image() const {
        using namespace std::string_literals;
        const bool is_big = GetParam() == TiffVariant::Big;
        std::string bytes =
            is_big ? "II\x2b\0\x08\0\0\0\x10\0\0\0\0\0\0\0"s : "II\x2a\0\x08\0\0\0"s;
        TiffDirectory directory;
        directory.set_longs(TIFFTAG_IMAGEWIDTH, {3});
        directory.set_longs(TIFFTAG_IMAGELENGTH, {2});
        directory.set_shorts(TIFFTAG_BITSPERSAMPLE, {8});
        directory.set_shorts(TIFFTAG_PHOTOMETRIC, {PHOTOMETRIC_MINISBLACK});
        directory.set_longs(TIFFTAG_ROWSPERSTRIP, {1});
        directory.set_text(TIFFTAG_IMAGEDESCRIPTION, "grey, six pixels");
        directory.set_doubles(TIFFTAG_SMINSAMPLEVALUE, {0.5});
        directory.set_longs(TIFFTAG_STRIPBYTECOUNTS, {3, 3});
        directory.set_offsets(TIFFTAG_STRIPOFFSETS, {0, 0}, GetParam());
        const std::uint64_t data = bytes.size() + directory.num_bytes(GetParam());
        directory.set_offsets(TIFFTAG_STRIPOFFSETS, {data, data + 3}, GetParam());
        bytes += directory.bytes(GetParam(), bytes.size(), 0);
        return bytes.append(reinterpret_cast<const char*>(kPixels.data()), kPixels.size());
    }
};

TEST_P(TiffDirectoryTest, LibtiffReadsIt) {
    const std::unique_ptr<TIFF, void (*)(TIFF*)> tiff(
        TIFFOpen(write("image.tif", image()).c_str(), "r"), TIFFClose);
    ASSERT_TRUE(tiff);
    EXPECT_EQ(TIFFIsBigTIFF(tiff.get()) != 0, GetParam() == TiffVariant::Big);
    const char* text = nullptr;
    ASSERT_EQ(TIFFGetField(tiff.get(), TIFFTAG_IMAGEDESCRIPTION, &text), 1);
    EXPECT_STREQ(text, "grey, six pixels");
    for (std::uint32_t row = 0; row < 2; ++row) {
        std::array<std::uint8_t, 3> pixels{};
        ASSERT_EQ(TIFFReadScanline(tiff.get(), pixels.data(), row, 0), 1);
        for (std::size_t i = 0; i < 3; ++i) EXPECT_EQ(pixels[i], kPixels[3 * row + i]);
    }
    EXPECT_EQ(TIFFLastDirectory(tiff.get()), 1);
}

INSTANTIATE_TEST_SUITE_P(Variants,
                         TiffDirectoryTest,
                         testing::Values(TiffVariant::Classic, TiffVariant::Big));

}  // namespace
}  // namespace divemesh::io
