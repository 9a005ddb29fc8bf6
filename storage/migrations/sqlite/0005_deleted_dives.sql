-- A deleted dive can be brought back until it expires; then it is removed for good.
ALTER TABLE dives ADD COLUMN deleted_at_ms INTEGER NOT NULL DEFAULT 0;
ALTER TABLE dives ADD COLUMN expires_at_ms INTEGER NOT NULL DEFAULT 0;

CREATE INDEX dives_to_remove ON dives (expires_at_ms) WHERE deleted_at_ms > 0;

-- A deleted one stands in nobody's way either.
DROP INDEX dives_content_once;
DROP INDEX dives_archive_once;
CREATE UNIQUE INDEX dives_content_once ON dives (project, content_sha256)
    WHERE content_sha256 <> '' AND state <> 'refused' AND deleted_at_ms = 0;
CREATE UNIQUE INDEX dives_archive_once ON dives (project, archive_sha256)
    WHERE archive_sha256 <> '' AND state <> 'refused' AND deleted_at_ms = 0;

-- The tags of dives.tags, to be looked for.
CREATE TABLE dive_tags (
    dive_id TEXT NOT NULL REFERENCES dives (id),
    tag     TEXT NOT NULL,
    PRIMARY KEY (dive_id, tag)
) STRICT;

CREATE INDEX dives_by_tag ON dive_tags (tag);

INSERT INTO dive_tags (dive_id, tag)
SELECT DISTINCT dives.id, tags.value FROM dives, json_each(dives.tags) AS tags
WHERE tags.type = 'text';
