#include "worker/io/e57_writer.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cstdio>

#include "schemas/content_hash.hpp"
#include "schemas/error.hpp"
#include "worker/io/e57_pages.hpp"
#include "worker/io/record.hpp"

namespace divemesh::io {
namespace {

constexpr std::uint64_t kFileHeader_bytes = 48;
constexpr std::uint64_t kSectionHeader_bytes = 32;
constexpr std::uint64_t kIndexPacket_bytes = 32;
constexpr std::uint64_t kPointsOfPacket = 4096;  // a packet has at most 64 KiB
constexpr std::uint64_t kNumFields = 6;
constexpr std::uint64_t kPoint_bytes = 3 * sizeof(float) + 3;
constexpr std::uint64_t kData = kFileHeader_bytes + kSectionHeader_bytes;  // where packets begin

std::uint64_t packet_bytes(std::uint64_t num_points) {
    const std::uint64_t used = 6 + kNumFields * sizeof(std::uint16_t) + num_points * kPoint_bytes;
    return (used + 3) / 4 * 4;
}

std::uint64_t all_packets_bytes(std::uint64_t num_points) {
    const std::uint64_t rest = num_points % kPointsOfPacket;
    return num_points / kPointsOfPacket * packet_bytes(kPointsOfPacket) +
           (rest == 0 ? 0 : packet_bytes(rest));
}

// Returns a GUID of version 8 (RFC 9562) that is made from a text.
std::string guid_of(const std::string& text) {
    std::string guid = sha256_hex(text).substr(0, 32);
    guid[12] = '8';
    guid[16] = '8';
    std::string result = "{";
    for (std::size_t i = 0; i < guid.size(); ++i) {
        if (i == 8 || i == 12 || i == 16 || i == 20) result += '-';
        result += guid[i];
    }
    return result + '}';
}

// Returns a number with as many letters as every other one.
std::string fixed_number(float value) {
    char text[32];
    std::snprintf(text, sizeof text, "%+.8e", static_cast<double>(value));
    return text;
}

std::string string_element(const char* name, std::string text) {
    constexpr std::string_view kEnd = "]]>";  // of the section, which the text may not contain
    for (std::size_t at = 0; (at = text.find(kEnd, at)) != std::string::npos; at += 12)
        text.insert(at + 2, "]]><![CDATA[");
    std::string element = "<";
    element.append(name).append(" type=\"String\"><![CDATA[").append(text);
    return element.append("]]></").append(name).append(">\n");
}

std::string number_element(const std::string& name, const char* type, const std::string& value) {
    std::string element = "<";
    element.append(name).append(" type=\"").append(type).append("\">").append(value);
    return element.append("</").append(name).append(">\n");
}

std::string bounds_xml(const Eigen::AlignedBox3f& bounds) {
    std::string xml = "<cartesianBounds type=\"Structure\">\n";
    for (const int axis : {0, 1, 2}) {
        const std::string name(1, "xyz"[axis]);
        xml += number_element(name + "Minimum", "Float", fixed_number(bounds.min()[axis]));
        xml += number_element(name + "Maximum", "Float", fixed_number(bounds.max()[axis]));
    }
    xml += "</cartesianBounds>\n<colorLimits type=\"Structure\">\n";
    for (const char* name : {"colorRed", "colorGreen", "colorBlue"}) {
        xml += number_element(std::string(name) + "Minimum", "Integer", "0");
        xml += number_element(std::string(name) + "Maximum", "Integer", "255");
    }
    return xml + "</colorLimits>\n";
}

// Returns the XML section. Its length does not depend on the bounds.
std::string xml_of(std::uint64_t num_points,
                   const std::string& text,
                   const Eigen::AlignedBox3f& bounds) {
    const std::string identity = text + std::to_string(num_points);
    std::string xml =
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
        "<e57Root type=\"Structure\" xmlns=\"http://www.astm.org/COMMIT/E57/2010-e57-v1.0\">\n";
    xml += string_element("formatName", "ASTM E57 3D Imaging Data File");
    xml += string_element("guid", guid_of("file " + identity));
    xml += number_element("versionMajor", "Integer", "1");
    xml += number_element("versionMinor", "Integer", "0");
    xml += string_element("e57LibraryVersion", "divemesh");
    xml += string_element("coordinateMetadata", "");
    xml += "<data3D type=\"Vector\" allowHeterogeneousChildren=\"1\">\n";
    xml += "<vectorChild type=\"Structure\">\n";
    xml += string_element("guid", guid_of("scan " + identity));
    xml += string_element("name", "cloud");
    xml += string_element("description", text);
    xml += bounds_xml(bounds);
    xml += "<points type=\"CompressedVector\" fileOffset=\"";
    xml += std::to_string(E57Pages::physical(kFileHeader_bytes));
    xml.append("\" recordCount=\"").append(std::to_string(num_points));
    xml += "\">\n<prototype type=\"Structure\">\n";
    for (const char* name : {"cartesianX", "cartesianY", "cartesianZ"})
        xml.append("<").append(name).append(" type=\"Float\" precision=\"single\"/>\n");
    for (const char* name : {"colorRed", "colorGreen", "colorBlue"})
        xml.append("<").append(name).append(" type=\"Integer\" minimum=\"0\" maximum=\"255\"/>\n");
    return xml +
           "</prototype>\n<codecs type=\"Vector\" allowHeterogeneousChildren=\"1\"/>\n</points>\n"
           "</vectorChild>\n</data3D>\n"
           "<images2D type=\"Vector\" allowHeterogeneousChildren=\"1\"/>\n</e57Root>\n";
}

void write_headers(std::uint64_t num_points, std::uint64_t xml_bytes, E57Pages& pages) {
    const std::uint64_t index = kData + all_packets_bytes(num_points);
    const std::uint64_t xml = index + kIndexPacket_bytes;
    Record record;
    record.put_field("ASTM-E57", 8);
    record.put(std::uint32_t{1});  // version 1.0
    record.put(std::uint32_t{0});
    record.put(E57Pages::file_length(xml + xml_bytes));
    record.put(E57Pages::physical(xml));
    record.put(xml_bytes);
    record.put(E57Pages::kPage_bytes);
    constexpr std::uint8_t kCompressedVector = 1;
    record.put(kCompressedVector);
    record.put_zeros(7);
    record.put(xml - kFileHeader_bytes);
    record.put(E57Pages::physical(kData));
    record.put(E57Pages::physical(index));
    record.flush_to(pages);
}

// Gathers points field by field, as packets have them.
class DataPacket {
public:
    void add(const Eigen::Vector3f& p_world, const types::Color& color) {
        for (std::size_t i = 0; i < 3; ++i) {
            fields_[i].put(p_world[static_cast<Eigen::Index>(i)]);
            fields_[3 + i].put(color[i]);
        }
        ++num_points_;
    }
    std::uint64_t num_points() const { return num_points_; }

    // Writes the packet and starts anew.
    void flush_to(E57Pages& pages) {
        const std::uint64_t size_bytes = packet_bytes(num_points_);
        Record record;
        record.put(std::uint8_t{1});  // a data packet
        record.put(std::uint8_t{0});
        record.put(static_cast<std::uint16_t>(size_bytes - 1));
        record.put(static_cast<std::uint16_t>(fields_.size()));
        for (const Record& field : fields_)
            record.put(static_cast<std::uint16_t>(field.size_bytes()));
        record.flush_to(pages);
        for (Record& field : fields_) field.flush_to(pages);
        record.put_zeros(size_bytes - 6 - kNumFields * sizeof(std::uint16_t) -
                         num_points_ * kPoint_bytes);
        record.flush_to(pages);
        num_points_ = 0;
    }

private:
    std::array<Record, kNumFields> fields_;
    std::uint64_t num_points_ = 0;
};

// Writes the packets, and returns the bounds of the points.
Eigen::AlignedBox3f write_points(const CloudPlyReader& cloud, E57Pages& pages) {
    Eigen::AlignedBox3f bounds;
    DataPacket packet;
    cloud.for_each([&](const Eigen::Vector3f& p_world, const types::Color& color) {
        bounds.extend(p_world);
        packet.add(p_world, color);
        if (packet.num_points() == kPointsOfPacket) packet.flush_to(pages);
    });
    if (packet.num_points() > 0) packet.flush_to(pages);
    return bounds;
}

// Writes an index with one entry: the first packet, from which readers go on.
void write_index(E57Pages& pages) {
    Record record;
    record.put(std::uint8_t{0});  // an index packet
    record.put(std::uint8_t{0});
    record.put(static_cast<std::uint16_t>(kIndexPacket_bytes - 1));
    record.put(std::uint16_t{1});  // entries
    record.put_zeros(10);          // level 0, reserved
    record.put(std::uint64_t{0});  // the first point
    record.put(E57Pages::physical(kData));
    record.flush_to(pages);
}

}  // namespace

void write_e57(const std::filesystem::path& file,
               const CloudPlyReader& cloud,
               const std::string& text) {
    const std::uint64_t num_points = cloud.num_points();
    if (num_points == 0)
        throw Error(ErrorCode::BadData,
                    "the cloud has no points to write: reconstruct the dive with a surface");
    const Eigen::AlignedBox3f not_known_yet(Eigen::Vector3f::Zero());
    E57Pages pages(file);
    write_headers(num_points, xml_of(num_points, text, not_known_yet).size(), pages);
    const Eigen::AlignedBox3f bounds = write_points(cloud, pages);
    write_index(pages);
    pages.write(xml_of(num_points, text, bounds));
    pages.commit();
}

}  // namespace divemesh::io
