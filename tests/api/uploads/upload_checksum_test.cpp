#include "api/uploads/upload_checksum.hpp"

#include <gtest/gtest.h>

#include "schemas/error.hpp"

namespace divemesh::api {
namespace {

bool matches(const std::string& header, std::string_view bytes, std::size_t chunk) {
    UploadChecksum checksum(header);
    for (std::size_t at = 0; at < bytes.size(); at += chunk)
        checksum.update(bytes.substr(at, chunk));
    return checksum.matches();
}

// FIPS 180-4 examples ("abc"), tus 1.0's example ("hello world"), RFC 3720 B.4 (32 zeros).
TEST(UploadChecksumTest, AgreesWithThePublishedDigests) {
    const std::tuple<const char*, std::string> known[] = {
        {"sha1 qZk+NkcGgWq6PiVxeFDCbJzQ2J0=", "abc"},
        {"sha256 ungWv48Bz+pBQUDeXa4iI7ADYaOWF3qctBD/YfIAFa0=", "abc"},
        {"sha1 Kq5sNclPz7QV2+lfQIuc6R7oRu0=", "hello world"},
        {"crc32c ipE2qg==", std::string(32, '\0')},
        {"crc32c 4waSgw==", "123456789"},
        {"crc32c AAAAAA==", ""}};
    for (const auto& [header, bytes] : known)
        for (const std::size_t chunk : {1, 5, 100})
            EXPECT_TRUE(matches(header, bytes, chunk)) << header;
    EXPECT_FALSE(matches("crc32c 4waSgw==", "123456780", 3));
    EXPECT_FALSE(matches("sha1 qZk+NkcGgWq6PiVxeFDCbJzQ2J0=", "abd", 3));
}

TEST(UploadChecksumTest, RefusesOtherAlgorithmsAndLengths) {
    for (const char* header : {"",
                               "sha1",
                               "sha1 ",
                               "sha1 qZk+NkcGgWq6PiVxeFDCbJzQ2J0",
                               "sha256 qZk+NkcGgWq6PiVxeFDCbJzQ2J0=",
                               "md5 kAFQmDzST7DWlj99KOF/cg==",
                               "crc32c AAA="})
        EXPECT_THROW(UploadChecksum{header}, Error) << header;
}

}  // namespace
}  // namespace divemesh::api
