#include "tests/ready_dive.hpp"

#include <chrono>

#include "storage/job_store.hpp"
#include "storage/upload_store.hpp"

namespace divemesh {

std::string make_ready_dive(storage::Catalog& catalog,
                            const std::string& project,
                            const std::string& archive_sha256,
                            const storage::IntakeResult& intake) {
    Upload upload;
    upload.project = project;
    upload.length_bytes = 1;
    storage::UploadStore uploads(catalog);
    upload = uploads.create(upload);
    uploads.advance(upload.id, 1);
    storage::NewDive dive;
    dive.upload_id = upload.id;
    dive.project = project;
    dive.name = "wreck";
    dive.archive_sha256 = archive_sha256;
    dive.blob = "dives/" + upload.id + "/archive";
    const auto id = storage::DiveStore(catalog).create(dive).dive.id;
    storage::JobStore jobs(catalog);
    const auto claim = jobs.claim("test:1", std::chrono::seconds(60));
    jobs.finish_intake(claim->lease, intake);
    return id;
}

}  // namespace divemesh
