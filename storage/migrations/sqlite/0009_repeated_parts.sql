-- Of a final upload that names a part more than once: the bytes beyond those of its parts, which count
-- from its creation on.
ALTER TABLE uploads ADD COLUMN repeated_bytes INTEGER NOT NULL DEFAULT 0 CHECK (repeated_bytes >= 0);
