-- How long the stages of jobs took, counted where a worker reports one, so that nobody has to read
-- all jobs for it. up_to_s is the bound of the row's class of durations; -1: longer than all.
CREATE TABLE stage_seconds (
    stage    TEXT NOT NULL,
    cached   INTEGER NOT NULL CHECK (cached IN (0, 1)),       -- 1: taken from the cache
    up_to_s  REAL NOT NULL,
    num_runs INTEGER NOT NULL,
    total_s  REAL NOT NULL,
    PRIMARY KEY (stage, cached, up_to_s)
) STRICT;
