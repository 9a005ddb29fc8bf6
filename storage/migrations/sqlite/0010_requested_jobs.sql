-- The job that a request with an Idempotency-Key led to, written with the job: the answer to the
-- request is kept after it, and the server may die between the two.
CREATE TABLE requested_jobs (
    request_key   TEXT NOT NULL PRIMARY KEY,                  -- NewJob::request_key
    job_id        TEXT NOT NULL REFERENCES jobs (id) ON DELETE CASCADE,
    created_at_ms INTEGER NOT NULL
) STRICT;

CREATE INDEX requested_jobs_by_age ON requested_jobs (created_at_ms);
CREATE INDEX requested_jobs_of_job ON requested_jobs (job_id);
