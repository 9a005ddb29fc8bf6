-- The results of jobs: they count towards the quota, and can be deleted alone.
ALTER TABLE jobs ADD COLUMN result_bytes INTEGER NOT NULL DEFAULT 0;  -- of its artifacts
ALTER TABLE jobs ADD COLUMN deleted_at_ms INTEGER NOT NULL DEFAULT 0;
ALTER TABLE jobs ADD COLUMN expires_at_ms INTEGER NOT NULL DEFAULT 0;
ALTER TABLE jobs ADD COLUMN kept INTEGER NOT NULL DEFAULT 0;  -- 1: restored, so no rule deletes it
ALTER TABLE queues ADD COLUMN keep_results INTEGER NOT NULL DEFAULT 0  -- of a dive and kind; 0: all
    CHECK (keep_results >= 0);

UPDATE jobs SET result_bytes =
    COALESCE((SELECT SUM(size_bytes) FROM artifacts WHERE job_id = jobs.id), 0);

CREATE INDEX jobs_results_of_project ON jobs (project, result_bytes) WHERE result_bytes > 0;
CREATE INDEX jobs_to_remove ON jobs (expires_at_ms) WHERE deleted_at_ms > 0;

CREATE TRIGGER artifacts_are_counted AFTER INSERT ON artifacts
BEGIN
    UPDATE jobs SET result_bytes = result_bytes + NEW.size_bytes WHERE id = NEW.job_id;
END;

CREATE TRIGGER removed_artifacts_are_not_counted AFTER DELETE ON artifacts
BEGIN
    UPDATE jobs SET result_bytes = result_bytes - OLD.size_bytes WHERE id = OLD.job_id;
END;
