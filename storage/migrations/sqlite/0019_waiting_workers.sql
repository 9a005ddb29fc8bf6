-- Why a worker takes no jobs; '': it takes them. A word of schemas/wait_reason.hpp.
ALTER TABLE workers ADD COLUMN waits_for TEXT NOT NULL DEFAULT '';
