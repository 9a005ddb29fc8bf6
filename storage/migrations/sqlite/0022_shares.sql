-- A token may be a sharing link: it opens the result of this one job for reading. The job may be gone.
ALTER TABLE tokens ADD COLUMN shared_job TEXT NOT NULL DEFAULT '';

CREATE INDEX tokens_of_shared_job ON tokens (shared_job, created_at_ms) WHERE shared_job <> '';
