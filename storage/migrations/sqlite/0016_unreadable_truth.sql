-- Why a report could not read the file. What is not empty is left aside by reports that name no file.
ALTER TABLE truth_files ADD COLUMN problem TEXT NOT NULL DEFAULT '';
