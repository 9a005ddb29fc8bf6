-- Whether what an attempt that came to nothing has left in the blob store has been removed.
ALTER TABLE attempts ADD COLUMN cleaned INTEGER NOT NULL DEFAULT 0;

CREATE INDEX attempts_to_clean ON attempts (finished_at_ms)
    WHERE cleaned = 0 AND state NOT IN ('running', 'succeeded');
CREATE INDEX events_by_time ON events (time_ms);
