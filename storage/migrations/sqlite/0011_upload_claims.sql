-- Whose token an upload was begun with, so that one of them cannot take all that a project may have
-- open; '' where no token is asked for.
ALTER TABLE uploads ADD COLUMN token_id TEXT NOT NULL DEFAULT '';
CREATE INDEX uploads_open_of_token ON uploads (token_id) WHERE dive_id IS NULL AND ended = '';

-- The parts that a final upload was made of: what two of them claim at once counts twice.
CREATE TABLE upload_parts (
    final_id TEXT NOT NULL REFERENCES uploads (id) ON DELETE CASCADE,
    part_id  TEXT NOT NULL REFERENCES uploads (id) ON DELETE CASCADE,
    PRIMARY KEY (final_id, part_id)
) STRICT;

CREATE INDEX upload_parts_by_part ON upload_parts (part_id);
