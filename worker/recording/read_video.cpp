#include "worker/recording/read_video.hpp"

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "schemas/error.hpp"
#include "worker/base/part_of.hpp"
#include "worker/base/seconds.hpp"
#include "worker/base/text.hpp"
#include "worker/video/chapter_files.hpp"

namespace divemesh::recording {
namespace {

std::string listed(const std::vector<std::string>& names) {
    std::string text;
    for (const std::string& name : names) {
        if (!text.empty()) text += ", ";
        text += name;
    }
    return text;
}

void report_file(const std::string& name,
                 const video::VideoIndex& index,
                 dive::FindingLog& findings) {
    if (index.is_cut)
        findings.warning("recording_cut",
                         name,
                         "the video ends at " + base::fixed(base::to_s(index.stamps_ns.back()), 1) +
                             " s, though it states " + base::fixed(index.traits.duration_s, 1) +
                             " s; what is before is used",
                         "Copy it again if the original is longer.");
    if (index.num_repeated > 0)
        findings.warning("image_repeated",
                         name,
                         std::to_string(index.num_repeated) +
                             " frames have the stamp of another one, and are left out",
                         "");
    if (index.num_unstamped > 0)
        findings.warning(
            "stamp_missing",
            name,
            std::to_string(index.num_unstamped) + " frames have no stamp, and are left out",
            "");
    if (index.traits.rotation_deg != 0)
        findings.info("video_rotated",
                      name,
                      "images are turned by " + std::to_string(index.traits.rotation_deg) +
                          " degrees clockwise, as the video states; the calibration has to be of "
                          "such images");
    if (index.traits.is_interlaced)
        findings.warning("images_interlaced",
                         name,
                         "the video is interlaced: each image holds two times, and is used as it "
                         "is",
                         "Record progressive images.");
}

void report_names(const video::ChapterFiles& chapters,
                  const std::string& name,
                  dive::FindingLog& findings) {
    if (!chapters.earlier.empty())
        findings.info("video_chapters_earlier",
                      name,
                      "this chapter is used alone, though earlier ones of its recording lie beside "
                      "it (" +
                          listed(chapters.earlier) +
                          "): give the first one, and those after it are joined");
    if (!chapters.missing.empty())
        findings.warning("video_chapter_missing",
                         chapters.missing,
                         "this chapter of the recording does not lie beside the others, so those "
                         "after it are left out (" +
                             listed(chapters.after_gap) + "); what is before it is used",
                         "Copy it from the camera's card into the same folder.");
}

void report_unusable(const std::string& name, const std::string& why, dive::FindingLog& findings) {
    findings.warning("video_chapter_unusable",
                     name,
                     "the recording is used up to this chapter, which is left out with those after "
                     "it: " +
                         why,
                     "Copy it from the camera's card again.");
}

// Returns the index of a further chapter; nullopt if the file is damaged.
std::optional<video::VideoIndex> index_of_chapter(const std::filesystem::path& path,
                                                  dive::FindingLog& findings,
                                                  const base::ProgressCallback& progress) {
    try {
        return video::read_index(path, progress);
    } catch (const Error& error) {
        if (error.code() != ErrorCode::BadData) throw;
        report_unusable(path.filename().string(), error.what(), findings);
        return std::nullopt;
    }
}

void report_joined(const video::IndexedVideo& video, dive::FindingLog& findings) {
    if (video.parts.size() < 2) return;
    std::vector<std::string> names;
    for (const video::VideoPart& part : video.parts) names.push_back(part.path.filename().string());
    findings.info(
        "video_chapters_joined",
        video.name(),
        std::to_string(names.size()) + " chapters of one recording are joined: " + listed(names));
}

}  // namespace

video::IndexedVideo read_video(const std::filesystem::path& path,
                               dive::FindingLog& findings,
                               const base::ProgressCallback& progress) {
    const video::ChapterFiles chapters = video::find_chapters(path);
    const double part = 1.0 / static_cast<double>(chapters.files.size());
    auto video = video::one_file(path, video::read_index(path, base::part_of(progress, 0.0, part)));
    report_file(video.name(), video.index, findings);
    report_names(chapters, video.name(), findings);
    for (std::size_t i = 1; i < chapters.files.size(); ++i) {
        const std::filesystem::path& file = chapters.files[i];
        const double begin = part * static_cast<double>(i);
        auto chapter =
            index_of_chapter(file, findings, base::part_of(progress, begin, begin + part));
        if (!chapter) break;
        if (!video::continues(video, *chapter)) {
            report_unusable(file.filename().string(),
                            "its codec, or the size or rotation of its images, is another one than "
                            "that of the chapters before it",
                            findings);
            break;
        }
        report_file(file.filename().string(), *chapter, findings);
        video::append_chapter(video, file, std::move(*chapter));
    }
    report_joined(video, findings);
    return video;
}

}  // namespace divemesh::recording
