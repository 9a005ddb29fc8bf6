#include "worker/io/e57_writer.hpp"

#include <cstring>

#include "tests/worker/io/test_files.hpp"
#include "worker/io/crc32.hpp"
#include "worker/io/ply.hpp"

namespace divemesh::io {
namespace {

// CRC-32C bit by bit, as RFC 3720 defines it.
std::uint32_t crc32c(std::string_view bytes) {
    std::uint32_t crc = 0xffffffffU;
    for (const char byte : bytes) {
        crc ^= static_cast<std::uint8_t>(byte);
        for (int bit = 0; bit < 8; ++bit)
            crc = (crc & 1U) != 0 ? crc >> 1U ^ 0x82f63b78U : crc >> 1U;
    }
    return ~crc;
}

// A reader of E57 files with one scan of floats and bytes, by the description of the format.
class E57Scan {
public:
    explicit E57Scan(const std::string& bytes) : bytes_(bytes) {
        EXPECT_EQ(bytes.substr(0, 8), "ASTM-E57");
        EXPECT_EQ(value<std::uint32_t>(8), 1U);
        EXPECT_EQ(value<std::uint32_t>(12), 0U);
        EXPECT_EQ(value<std::uint64_t>(16), bytes.size());
        EXPECT_EQ(value<std::uint64_t>(40), 1024U);
        check_pages();
        xml = content(value<std::uint64_t>(24), value<std::uint64_t>(32));
        read_points(std::stoul(attribute("fileOffset")), std::stoul(attribute("recordCount")));
    }

    // Returns the text of an element of the XML section.
    std::string element(const std::string& name) const {
        const std::size_t begin = xml.find('>', xml.find("<" + name + " ")) + 1;
        return xml.substr(begin, xml.find("</" + name + ">") - begin);
    }

    std::string xml;
    std::vector<Eigen::Vector3f> points;
    std::vector<types::Color> colors;

private:
    template <typename Value>
    Value value(std::size_t at) const {
        return value_of<Value>(bytes_, at);
    }
    template <typename Value>
    static Value value_of(const std::string& bytes, std::size_t at) {
        Value value{};
        std::memcpy(&value, bytes.substr(at, sizeof value).data(), sizeof value);
        return value;
    }
    void check_pages() const {
        ASSERT_EQ(bytes_.size() % 1024, 0U);
        for (std::size_t page = 0; page < bytes_.size(); page += 1024) {
            std::uint32_t stored = 0;  // the most significant byte first
            for (std::size_t i = 0; i < 4; ++i)
                stored = stored << 8U | static_cast<std::uint8_t>(bytes_[page + 1020 + i]);
            ASSERT_EQ(stored, crc32c(std::string_view(bytes_).substr(page, 1020))) << page;
        }
    }
    // Returns what is stored from a physical offset on, without the checksums.
    std::string content(std::size_t physical, std::size_t length) const {
        EXPECT_LT(physical % 1024, 1020U);
        std::string found;
        for (; found.size() < length; ++physical)
            if (physical % 1024 < 1020) found += bytes_.at(physical);
        return found;
    }
    std::string attribute(const std::string& name) const {
        const std::size_t begin = xml.find(name + "=\"") + name.size() + 2;
        return xml.substr(begin, xml.find('"', begin) - begin);
    }
    void read_points(std::size_t offset, std::size_t num_points) {
        const std::string section = content(offset, 32);
        EXPECT_EQ(section[0], 1);
        const auto length = value_of<std::uint64_t>(section, 8);
        const auto data = value_of<std::uint64_t>(section, 16);
        const auto index = content(value_of<std::uint64_t>(section, 24), 32);
        EXPECT_EQ(index[0], 0);
        EXPECT_EQ(value_of<std::uint16_t>(index, 2), 31);
        EXPECT_EQ(value_of<std::uint16_t>(index, 4), 1);
        EXPECT_EQ(value_of<std::uint64_t>(index, 24), data);
        EXPECT_EQ(data, offset + 32);
        const std::string packets = content(data, length - 32);
        std::size_t at = 0;
        while (points.size() < num_points) at += read_packet(packets, at);
        EXPECT_EQ(points.size(), num_points);
        EXPECT_EQ(at + 32, packets.size());  // the index
    }
    std::size_t read_packet(const std::string& packets, std::size_t at) {
        EXPECT_EQ(packets[at], 1);
        const std::size_t length = value_of<std::uint16_t>(packets, at + 2) + std::size_t{1};
        EXPECT_EQ(length % 4, 0U);
        EXPECT_EQ(value_of<std::uint16_t>(packets, at + 4), 6);
        const std::size_t num = value_of<std::uint16_t>(packets, at + 6) / sizeof(float);
        std::size_t stream = at + 18;
        const std::size_t first = points.size();
        points.resize(first + num);
        colors.resize(first + num);
        for (std::size_t field = 0; field < 6; ++field) {
            const std::size_t size = field < 3 ? sizeof(float) : 1;
            EXPECT_EQ(value_of<std::uint16_t>(packets, at + 6 + 2 * field), num * size);
            for (std::size_t i = 0; i < num; ++i, stream += size) {
                if (field < 3)
                    points[first + i][static_cast<Eigen::Index>(field)] =
                        value_of<float>(packets, stream);
                else
                    colors[first + i][field - 3] = static_cast<std::uint8_t>(packets.at(stream));
            }
        }
        EXPECT_LT(at + length - stream, 4U);
        return length;
    }

    const std::string& bytes_;
};

class E57WriterTest : public FileTest {
protected:
    static Eigen::Vector3f point(int i) {
        const auto t = static_cast<float>(i);
        return {0.01F * t - 7.0F, std::sin(t), 3.0F / (1.0F + t)};
    }
    static types::Color color(int i) {
        return {static_cast<std::uint8_t>(i), static_cast<std::uint8_t>(i / 256), 255};
    }
    void write_cloud(int num_points) const {
        CloudPlyWriter cloud(file("cloud.ply"), num_points);
        for (int i = 0; i < num_points; ++i) cloud.add(point(i), color(i));
        cloud.commit();
    }
    std::string written(int num_points, const std::string& text) const {
        write_cloud(num_points);
        write_e57(file("cloud.e57"), CloudPlyReader(file("cloud.ply")), text);
        return read(file("cloud.e57"));
    }
};

// The check value that RFC 3720's polynomial is published with, and its test patterns (B.4).
TEST(Crc32cTest, KnownValues) {
    const auto value = [](std::string_view bytes) {
        Crc32c crc;
        crc.add(bytes);
        return crc.value();
    };
    EXPECT_EQ(value("123456789"), 0xe3069283U);
    EXPECT_EQ(value(std::string(32, '\0')), 0x8a9136aaU);
    EXPECT_EQ(value(std::string(32, '\xff')), 0x62a8ab43U);
}

TEST_F(E57WriterTest, AnotherReaderFindsAllPoints) {
    for (const int num_points : {1, 4096, 9'001}) {
        const std::string bytes = written(num_points, "t");
        const E57Scan scan(bytes);
        ASSERT_EQ(scan.points.size(), static_cast<std::size_t>(num_points));
        for (int i = 0; i < num_points; ++i) {
            EXPECT_EQ(scan.points[static_cast<std::size_t>(i)], point(i));
            EXPECT_EQ(scan.colors[static_cast<std::size_t>(i)], color(i));
        }
    }
}

TEST_F(E57WriterTest, TheXmlStatesBoundsAndDescription) {
    const std::string bytes = written(500, "verdict: good <1 & ]]> 2");
    const E57Scan scan(bytes);
    EXPECT_EQ(std::stof(scan.element("xMinimum")), point(0).x());
    EXPECT_EQ(std::stof(scan.element("xMaximum")), point(499).x());
    EXPECT_EQ(std::stof(scan.element("zMaximum")), 3.0F);
    EXPECT_EQ(scan.element("description"), "<![CDATA[verdict: good <1 & ]]]]><![CDATA[> 2]]>");
    EXPECT_EQ(scan.element("formatName"), "<![CDATA[ASTM E57 3D Imaging Data File]]>");
    EXPECT_EQ(scan.element("guid").size(), std::string("<![CDATA[{}]]>").size() + 36);
}

TEST_F(E57WriterTest, TheSameCloudGivesTheSameBytes) {
    const std::string once = written(5'000, "t");
    EXPECT_TRUE(written(5'000, "t") == once);
}

TEST_F(E57WriterTest, ACloudWithoutPointsIsRefused) {
    EXPECT_EQ(error_of([&] { written(0, "t"); }).code(), ErrorCode::BadData);
    EXPECT_FALSE(std::filesystem::exists(file("cloud.e57")));
}

TEST_F(E57WriterTest, ABrokenCloudIsBadData) {
    write_cloud(100);
    const std::string whole = read(file("cloud.ply"));
    std::string endless = whole;
    endless.replace(endless.find("vertex 100"), 10, "vertex 999");
    std::string not_finite = whole;
    not_finite.replace(not_finite.size() - 15, 4, std::string("\x00\x00\xc0\x7f", 4));
    const std::string ascii =
        "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\n"
        "property float z\nend_header\n1 2 3\n";
    for (const std::string& bytes :
         {endless, not_finite, ascii, whole.substr(0, whole.size() - 1), std::string("no cloud")}) {
        write("cloud.ply", bytes);
        const Error error =
            error_of([&] { write_e57(file("cloud.e57"), CloudPlyReader(file("cloud.ply")), "t"); });
        EXPECT_EQ(error.code(), ErrorCode::BadData);
        EXPECT_NE(std::string(error.what()).find("cloud.ply"), std::string::npos);
    }
}

}  // namespace
}  // namespace divemesh::io
