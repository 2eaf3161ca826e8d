"""The page in a real browser: one for the files that run one after another in a process."""
