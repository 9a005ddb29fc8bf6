#include "worker/pipeline/build_id.hpp"

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <elf.h>
#include <link.h>
#include <span>

namespace divemesh::pipeline {
namespace {

constexpr std::size_t padded(std::size_t size) { return (size + 3) & ~std::size_t{3}; }

std::string to_hex(std::span<const unsigned char> bytes) {
    static constexpr char kDigits[] = "0123456789abcdef";
    std::string hex;
    for (const unsigned char byte : bytes) {
        hex += kDigits[byte >> 4];
        hex += kDigits[byte & 15];
    }
    return hex;
}

// Searches the notes, which follow each other: a header, the owner's name, the content, each padded
// to 4 bytes.
std::string find_build_id(std::span<const unsigned char> notes) {
    while (notes.size() >= sizeof(ElfW(Nhdr))) {
        ElfW(Nhdr) header;
        std::memcpy(&header, notes.data(), sizeof header);
        const std::size_t content = sizeof header + padded(header.n_namesz);
        const std::size_t end = content + padded(header.n_descsz);
        if (end > notes.size()) return "";
        if (header.n_type == NT_GNU_BUILD_ID && header.n_namesz == sizeof "GNU" &&
            std::memcmp(notes.data() + sizeof header, "GNU", sizeof "GNU") == 0)
            return to_hex(notes.subspan(content, header.n_descsz));
        notes = notes.subspan(end);
    }
    return "";
}

// Appends the id of one object. The first one is the program itself. Another one without a name is
// the kernel's, which computes nothing here. Returns 0: the iteration goes on.
int append_id(dl_phdr_info* object, std::size_t, void* found) {
    auto& ids = *static_cast<std::string*>(found);
    if (!ids.empty() && *object->dlpi_name == '\0') return 0;
    std::string id;
    for (int i = 0; i < object->dlpi_phnum && id.empty(); ++i) {
        const ElfW(Phdr)& segment = object->dlpi_phdr[i];
        if (segment.p_type != PT_NOTE) continue;
        const std::uintptr_t address = object->dlpi_addr + segment.p_vaddr;
        // NOLINTNEXTLINE(performance-no-int-to-ptr): the loader states addresses as integers
        const auto* notes = reinterpret_cast<const unsigned char*>(address);
        id = find_build_id({notes, segment.p_memsz});
    }
    ids += id;
    return 0;
}

}  // namespace

std::string build_id() {
    std::string ids;
    dl_iterate_phdr(append_id, &ids);
    return ids;
}

}  // namespace divemesh::pipeline
