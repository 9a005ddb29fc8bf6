// embed_page FOLDER OUT.cpp: runs during the build and writes the files of the web page as C++.
// Without a folder it writes that there is none.
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <iterator>
#include <libdeflate.h>
#include <map>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "schemas/content_hash.hpp"

namespace {

namespace fs = std::filesystem;

constexpr int kBestLevel = 12;
constexpr std::size_t kBytesPerLine = 80;

std::string media_type_of(const fs::path& file) {
    static const std::map<std::string, std::string> kTypes = {
        {".css", "text/css; charset=utf-8"},
        {".html", "text/html; charset=utf-8"},
        {".ico", "image/x-icon"},
        {".jpg", "image/jpeg"},
        {".js", "text/javascript; charset=utf-8"},
        {".json", "application/json"},
        {".png", "image/png"},
        {".svg", "image/svg+xml"},
        {".txt", "text/plain; charset=utf-8"},
        {".wasm", "application/wasm"},
        {".webmanifest", "application/manifest+json"},
        {".webp", "image/webp"},
        {".woff2", "font/woff2"}};
    const auto found = kTypes.find(file.extension().string());
    if (found == kTypes.end())
        throw std::runtime_error(file.string() + ": add the media type to cli/embed_page.cpp");
    return found->second;
}

std::string read_file(const fs::path& file) {
    std::ifstream in(file, std::ios::binary);
    std::string bytes{std::istreambuf_iterator<char>(in), {}};
    if (!in) throw std::runtime_error(file.string() + ": cannot read it");
    return bytes;
}

// Returns "" where compression saves less than a tenth.
std::string compress(const std::string& bytes) {
    const std::unique_ptr<libdeflate_compressor, void (*)(libdeflate_compressor*)> compressor(
        libdeflate_alloc_compressor(kBestLevel), libdeflate_free_compressor);
    std::string packed(bytes.size() - bytes.size() / 10, '\0');
    packed.resize(libdeflate_gzip_compress(
        compressor.get(), bytes.data(), bytes.size(), packed.data(), packed.size()));
    return packed;
}

// Returns a literal of any bytes. Three octal digits end an escape whatever follows.
std::string literal(const std::string& bytes) {
    std::string text = "std::string_view(\"";
    for (std::size_t i = 0; i < bytes.size(); ++i) {
        const auto byte = static_cast<unsigned char>(bytes[i]);
        if (i > 0 && i % kBytesPerLine == 0) text += "\"\n        \"";
        if (byte < 0x20 || byte > 0x7e || byte == '"' || byte == '\\' || byte == '?') {
            text += '\\';
            for (int shift = 6; shift >= 0; shift -= 3)
                text += static_cast<char>('0' + ((byte >> shift) & 7));
        } else {
            text += bytes[i];
        }
    }
    return text + "\", " + std::to_string(bytes.size()) + ")";
}

std::string row(const fs::path& folder, const fs::path& file) {
    const std::string bytes = read_file(file);
    return "    {\"" + file.lexically_relative(folder).generic_string() + "\", \"" +
           media_type_of(file) + "\", \"" + divemesh::sha256_hex(bytes) + "\",\n     " +
           literal(bytes) + ",\n     " + literal(compress(bytes)) + "},\n";
}

std::string rows(const fs::path& folder) {
    std::vector<fs::path> files;
    for (const auto& entry : fs::recursive_directory_iterator(folder))
        if (entry.is_regular_file() && entry.path().extension() != ".map")
            files.push_back(entry.path());
    std::sort(files.begin(), files.end());
    if (!fs::exists(folder / "index.html"))
        throw std::runtime_error(folder.string() + ": there is no index.html");
    std::string text;
    for (const fs::path& file : files) text += row(folder, file);
    return text;
}

std::string source(const std::string& body) {
    return "#include \"cli/page.hpp\"\n\nnamespace divemesh::cli {\n\n"
           "std::span<const api::PageFile> page() {\n" +
           body + "}\n\n}  // namespace divemesh::cli\n";
}

}  // namespace

int main(int argc, char** argv) {
    if (argc != 2 && argc != 3) return 2;
    try {
        const std::string body = argc == 2 ? "    return {};\n"
                                           : "    static constexpr api::PageFile kFiles[] = {\n" +
                                                 rows(argv[1]) + "    };\n    return kFiles;\n";
        std::ofstream out(argv[argc - 1]);
        out << source(body);
        return out.flush() ? 0 : 1;
    } catch (const std::exception& error) {
        std::cerr << "embed_page: " << error.what() << '\n';
        return 1;
    }
}
