"""Facts, models and verdicts: how fast, how robust, how well calibrated."""
