-- What was found when a dive was reconstructed, and what the result can be used for.
ALTER TABLE jobs ADD COLUMN verdict TEXT NOT NULL DEFAULT ''
    CHECK (verdict IN ('', 'good', 'usable_with_restrictions', 'not_usable'));
ALTER TABLE jobs ADD COLUMN findings TEXT NOT NULL DEFAULT '[]';  -- JSON
