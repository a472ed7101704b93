"""The paper's experiment, run again, as one page beside what the paper prints."""
